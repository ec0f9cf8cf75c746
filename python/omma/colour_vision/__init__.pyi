from .catches import von_kries
from .contrast import michelson_contrast, weber_contrast
from .detection import Detection, detect
from .noise_limited import (
    achromatic_distance,
    class_noise,
    noise_limited_coordinates,
    noise_limited_distance,
)
from .ideal_observer import d_prime, proportion_correct
from .observer import Observer
from .plots import (
    plot_distances,
    plot_fly_categories,
    plot_hexagon,
    plot_tetrahedron,
    plot_triangle,
)
from .spaces import (
    TetrahedralColour,
    excitations,
    fly_category,
    fly_opponents,
    hexagon,
    hexagon_contrast,
    hexagon_hue_deg,
    hexagon_sector,
    maxwell_triangle,
    tetrahedron,
)
from .targets import DiscTarget, SceneTarget

__all__ = [
    "Detection",
    "DiscTarget",
    "Observer",
    "SceneTarget",
    "TetrahedralColour",
    "achromatic_distance",
    "class_noise",
    "d_prime",
    "detect",
    "excitations",
    "fly_category",
    "fly_opponents",
    "hexagon",
    "hexagon_contrast",
    "hexagon_hue_deg",
    "hexagon_sector",
    "maxwell_triangle",
    "michelson_contrast",
    "noise_limited_coordinates",
    "noise_limited_distance",
    "plot_distances",
    "plot_fly_categories",
    "plot_hexagon",
    "plot_tetrahedron",
    "plot_triangle",
    "proportion_correct",
    "tetrahedron",
    "von_kries",
    "weber_contrast",
]
