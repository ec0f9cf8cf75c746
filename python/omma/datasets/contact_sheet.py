"""A sheet of small pictures of some views, to see whether a data set is what was meant."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye
from omma.base.arguments import checked, whole
from omma.base.directions import direction
from omma.base.figures import MM, figure_names, figure_style, load_matplotlib, save_figure
from omma.base.files import PathLike
from omma.datasets.job_file import lights_from
from omma.datasets.reading import Views, open_views
from omma.datasets.records import read_manifest
from omma.datasets.worlds import make_light
from omma.light import Light, uniform_sky
from omma.picture.band_colours import bands_to_rgb
from omma.picture.projections import project
from omma.rendering.labelled_files import load_package

_MOST = 400
_ACROSS = 4
_WIDTH_MM = 240.0
_PIXELS = 360  # across a picture of one eye
_NAMED = ("scene", "condition", "pose_set", "pose")


@checked
def contact_sheet(
    paths: PathLike | list[PathLike],
    store: PathLike,
    count: int = 24,
    *,
    eye: str | None = None,
    seed: int = 0,
) -> NDArray[np.int64]:
    """Draw some views of a data set on one sheet, chosen at random, each with what it is of; their
    numbers, (count,), ascending.

    The default picture of `omma.picture.project`. Responses in bands of light are shown as people
    see them, in the light of the view's condition.

    Args:
        paths: figures to write: .png, .svg, .pdf.
        store, eye: as of `open_views`.
        count: how many views; all, where there are fewer.
        seed: of which.

    Raises:
        omma.Error: no data set, one without responses or without a view yet; no Matplotlib.
    """
    names = figure_names(paths)
    count, seed = whole(count, "count", 1, _MOST), whole(seed, "seed", 0, 1 << 40)
    make_figure = load_matplotlib()
    views = open_views(store, ("response", *_NAMED), eye=eye)
    if len(views) == 0:
        raise Error(f"{views.store}: expected views, found none yet")
    chosen = np.sort(
        np.random.default_rng(seed).choice(len(views), min(count, len(views)), replace=False)
    )
    found = views[chosen]
    head, lights = _eye(views), _lights(views)
    pictures = [
        _picture(head, response, lights[int(condition)] if lights else None)
        for response, condition in zip(found["response"], found["condition"])
    ]
    known = read_manifest(views.store)["names"]
    height, width = pictures[0].shape[:2]
    down = -(-len(chosen) // _ACROSS)
    across_mm = _WIDTH_MM / _ACROSS
    with figure_style(7.0):
        row_mm = across_mm * height / width + 7
        figure = make_figure(
            figsize=(_WIDTH_MM * MM, (down * row_mm + 6) * MM), layout="constrained"
        )
        figure.suptitle(
            f"{len(chosen)} of {len(views):,} views, eye {views.eye}, of {_short(views.store)}"
        )
        axes = figure.subplots(down, _ACROSS, squeeze=False).ravel()
        for one in axes:
            one.axis("off")
            one.set_anchor("N")  # below its own title, not above the next
        for k, picture in enumerate(pictures):
            scene, condition, pose_set = (known[name][int(found[name][k])] for name in _NAMED[:3])
            axes[k].imshow(picture, interpolation="nearest")
            axes[k].set_title(
                f"view {views.numbers[chosen[k]]}: {scene}, {condition}\n"
                f"{pose_set} {int(found['pose'][k])}",
                loc="left",
            )
        save_figure(figure, names)
    return views.numbers[chosen]


def _picture(eye: Eye, response: NDArray[np.float32], light: Light | None) -> NDArray[Any]:
    if light is None:
        return project(eye, np.ascontiguousarray(response), width=_PIXELS)
    if not np.any(sum(light.irradiance())):
        # By lamps alone: the brightest that is seen is white, but for a few.
        light = uniform_sky(np.percentile(response, 98), bands=light.bands, unit=light.unit)
    shown = bands_to_rgb(response, light)
    return project(eye, np.ascontiguousarray(shown), width=_PIXELS)


def _eye(views: Views) -> Eye:
    """The eye as the store has it: where ommatidia look, how wide, in which eye."""
    inside = read_manifest(views.store)["groups"][views.eye]
    root = load_package("zarr", views.store).open_group(views.store, mode="r")
    group = root[inside] if inside else root
    axis = direction(group["azimuth"][...], group["elevation"][...])
    return Eye(
        np.zeros_like(axis), axis, np.radians(group["acceptance_angle"][...]),
        eye_id=np.asarray(group["eye"][...]),
    )  # fmt: skip


def _lights(views: Views) -> list[Light]:
    """The light of each condition; none where worlds have none."""
    manifest = read_manifest(views.store)
    bands = manifest["job_plain"].get("rendering", {}).get("bands", 0)
    found = (make_light(*one, bands) for one in lights_from(manifest["job"]))
    return [light for light in found if light is not None]


def _short(store: str) -> str:
    return store.rstrip("/").rsplit("/", 1)[-1]
