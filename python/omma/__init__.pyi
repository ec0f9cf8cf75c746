from . import (
    colour_vision,
    columns,
    compat,
    datasets,
    examples,
    eye,
    gym,
    job,
    light,
    motion,
    mujoco,
    photoreceptors,
    picture,
    receptors,
    rendering,
    scene,
    species,
    stimuli,
    study,
    view,
)
from ._core import Acceptance, Background, Error, Eye, Scene, __version__
from .base.poses import load_poses, look_at, poses_from_angles, poses_from_quaternions
from .base.velocities import velocities_from_poses
from .colour_vision.detection import detect
from .eye.files import load_eye, save_eye
from .job.rendering import render_file
from .picture.cameras import render_camera
from .picture.files import save_png
from .rendering.populations import Population
from .rendering.renderer import Renderer
from .rendering.response_files import save_responses
from .rendering.settings import Fixed, Shared, ToError
from .scene.files import load_scene
from .scene.world import World

__all__ = [
    "Acceptance",
    "Background",
    "Error",
    "Eye",
    "Fixed",
    "Population",
    "Renderer",
    "Scene",
    "Shared",
    "ToError",
    "World",
    "__version__",
    "colour_vision",
    "columns",
    "compat",
    "datasets",
    "detect",
    "examples",
    "eye",
    "gym",
    "job",
    "light",
    "load_eye",
    "load_poses",
    "load_scene",
    "look_at",
    "motion",
    "mujoco",
    "photoreceptors",
    "picture",
    "poses_from_angles",
    "poses_from_quaternions",
    "receptors",
    "render_camera",
    "render_file",
    "rendering",
    "save_eye",
    "save_png",
    "save_responses",
    "scene",
    "species",
    "stimuli",
    "study",
    "velocities_from_poses",
    "view",
]
