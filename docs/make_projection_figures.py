"""Makes docs/projections.png: one view of the meadow through a honeybee's eyes, in each projection.

.venv/bin/python docs/make_projection_figures.py
"""

from pathlib import Path

import matplotlib.patheffects as effects
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import omma

ROOT = Path(__file__).resolve().parent.parent
WIDTH, HEIGHT = 1200, 600

# Where directions are: x from 0 to 1 from left to right, y from 0 to 1 from top to bottom.
EQUIRECTANGULAR = [(0.06, 0.5, "back"), (0.25, 0.5, "left"), (0.5, 0.5, "ahead")]
EQUIRECTANGULAR += [(0.75, 0.5, "right"), (0.94, 0.5, "back"), (0.5, 0.08, "up")]
EQUIRECTANGULAR += [(0.5, 0.92, "down")]
SPLIT = [(x / 2 + shift, y, text) for shift in (0, 0.5) for x, y, text in EQUIRECTANGULAR[1:4]]
WHOLE_DISC = [(0.5, 0.5, "ahead"), (0.323, 0.5, "left"), (0.677, 0.5, "right")]
WHOLE_DISC += [(0.5, 0.146, "up"), (0.5, 0.854, "down"), (0.27, 0.85, "back: the rim")]
HALVES = [(0.25, 0.5, "left"), (0.75, 0.5, "right"), (0.5, 0.5, "ahead"), (0.06, 0.5, "back")]
HALVES += [(0.94, 0.5, "back"), (0.25, 0.08, "up"), (0.75, 0.08, "up")]
HALVES += [(0.25, 0.92, "down"), (0.75, 0.92, "down")]
FACETS = [(0.25, 0.5, "left eye"), (0.75, 0.5, "right eye"), (0.38, 0.5, "ahead")]
FACETS += [(0.62, 0.5, "ahead"), (0.12, 0.5, "back"), (0.88, 0.5, "back")]

PANELS = [
    ("spherical_orientationwise", "azimuth × elevation, nearest axis", EQUIRECTANGULAR),
    ("spherical_positionwise", "the same, nearest position", EQUIRECTANGULAR),
    ("spherical_split_orientationwise", "the same for each side", SPLIT),
    ("cylindrical", "azimuth of the axis × height on the eye", EQUIRECTANGULAR[:5]),
    ("mollweide", "whole sphere, equal-area", EQUIRECTANGULAR),
    ("lambert", "whole sphere, equal-area", WHOLE_DISC),
    ("hemisphere", "each eye's own half, equal-area", HALVES),
    ("facets", "the eyes themselves, to scale", FACETS),
]


def show(panel: Axes, picture: np.ndarray, title: str, what: str) -> None:
    panel.imshow(picture, interpolation="nearest", extent=(0, 2, 0, 1))
    panel.set_title(title, loc="left", fontsize=10, family="monospace", pad=16)
    panel.text(0, 1.02, what, transform=panel.transAxes, fontsize=8.5, color="0.35")
    panel.set_xticks([])
    panel.set_yticks([])


def label(panel: Axes, places: list[tuple[float, float, str]]) -> None:
    outline = [effects.withStroke(linewidth=2.2, foreground="black")]
    for x, y, text in places:
        panel.text(
            x,
            1 - y,
            text,
            transform=panel.transAxes,
            ha="center",
            va="center",
            color="white",
            fontsize=8.5,
            path_effects=outline,
        )


def main() -> None:
    """Render the view, project it in all ways and save the figure."""
    scene = omma.load_scene(ROOT / "examples" / "meadow.glb")
    bee = omma.eye.merge_eyes(
        [
            omma.load_eye(ROOT / "examples" / f"honeybee_worker_{side}.eye")
            for side in ("left", "right")
        ]
    )
    renderer = omma.Renderer(scene, bee, omma.Fixed(64))
    rays = renderer.render_rays("bee")
    responses = rays.mean(axis=2)

    figure, axes = plt.subplots(4, 3, figsize=(13.5, 10.2), layout="constrained")
    figure.get_layout_engine().set(h_pad=0.08, w_pad=0.06)
    cells = iter(axes.ravel())
    for name, what, places in PANELS:
        panel = next(cells)
        show(panel, omma.picture.project(bee, responses, name, WIDTH, HEIGHT), name, what)
        label(panel, places)

    # A piece of the left eye's picture from near its middle.
    close = omma.picture.project(bee, responses, "facets", 8 * WIDTH, 8 * HEIGHT)
    row, column = 4 * HEIGHT - 150, 2 * WIDTH + 150
    piece = close[row : row + 300, column : column + 600]
    show(next(cells), piece, "facets", "closer: one cell for each ommatidium")

    row = omma.picture.project(bee, responses, "single_dimension", WIDTH, HEIGHT)
    what = f"{len(bee):,} ommatidia in order; _fast: one pixel each"
    panel = next(cells)
    show(panel, row, "single_dimension", what)
    label(panel, [(0.25, 0.5, "left eye"), (0.75, 0.5, "right eye")])

    raw = omma.picture.project(bee, rays, "raw_ommatidial_samples")
    first = 2690
    show(
        next(cells),
        raw[:, first : first + 128],
        "raw_ommatidial_samples",
        f"ommatidia {first} to {first + 127}: a column each, a row for each ray",
    )

    ids = omma.picture.project(bee, None, "facets_ids", WIDTH, HEIGHT).view(">i4")[..., 0]
    shown = np.ma.masked_less(ids, 0)
    panel = next(cells)
    show(panel, np.full((1, 1, 3), 128, np.uint8), "facets_ids", "numbers instead of responses")
    drawn = panel.imshow(shown, extent=(0, 2, 0, 1), cmap="viridis", interpolation="nearest")
    scale = panel.inset_axes((0.47, 0.12, 0.02, 0.76))
    figure.colorbar(drawn, cax=scale)
    scale.tick_params(labelsize=7)
    figure.savefig(ROOT / "docs" / "projections.png", dpi=100)


if __name__ == "__main__":
    main()
