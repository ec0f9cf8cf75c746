"""A sheet of small pictures of some views, to see whether a data set is what was meant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye
from omma.base.arguments import checked, whole
from omma.base.directions import direction
from omma.base.figures import (
    INK,
    MM,
    figure_names,
    figure_style,
    load_matplotlib,
    plain,
    save_figure,
)
from omma.base.files import PathLike, reading
from omma.datasets.job_file import lights_from
from omma.datasets.reading import MOST_SEED, Views, open_views
from omma.datasets.records import open_store, read_manifest
from omma.datasets.worlds import make_light
from omma.light import Light, uniform_sky
from omma.picture.band_colours import bands_to_rgb
from omma.picture.projections import project

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST = 400
_ACROSS = 4
_WIDTH_MM = 240.0
_PIXELS = 360  # across a picture of one eye
_GAP = 14  # between those of two eyes
_BORDER = 34  # grey level, as ink
_MEANT = (
    "Azimuth −180° to 180° from left to right, straight ahead in the middle; elevation 90° to −90° "
    "from the top down."
)
_GREY = " Grey: no ommatidium looks there."
_UNSEEN = 218  # grey level; hatching would be the first thing one sees of pictures so small
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

    The default picture of `omma.picture.project`: all directions by azimuth and elevation, but grey
    where no ommatidium looks; where eyes are apart, L is the left and R the right one. Responses
    in bands of light are shown as people see them, in the light of the view's condition.

    Args:
        paths: figures to write: .png, .svg, .pdf.
        store, eye: as of `open_views`.
        count: how many views; all, where there are fewer.
        seed: of which.

    Raises:
        omma.Error: no data set, one without responses or without a view yet; no Matplotlib.

    Warns:
        UserWarning: the data set is not whole, as of `open_views`.
    """
    names = figure_names(paths)
    count, seed = whole(count, "count", 1, _MOST), whole(seed, "seed", 0, MOST_SEED)
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
    height, width = _bordered(pictures[0]).shape[:2]
    # As many side by side as leave the fewest places empty.
    across = min((_ACROSS, _ACROSS - 1), key=lambda columns: (-len(chosen) % columns, -columns))
    down = -(-len(chosen) // across)
    across_mm = _WIDTH_MM / across
    with figure_style(7.0):
        row_mm = across_mm * height / width + 7
        figure = make_figure(
            figsize=(_WIDTH_MM * MM, (down * row_mm + 11) * MM), layout="constrained"
        )
        name = views.store.rstrip("/").rsplit("/", 1)[-1]
        title = f"{len(chosen)} of {len(views):,} views, eye {views.eye}, of {name}"
        figure.suptitle(plain(title))
        figure.supxlabel(_MEANT + (_GREY if _unseen(head).any() else ""))
        axes = figure.subplots(down, across, squeeze=False).ravel()
        for one in axes:
            one.axis("off")
            one.set_anchor("N")  # below its own title, not above the next
        for k, picture in enumerate(pictures):
            with reading(views.store, "a data set"):
                numbers = [int(found[name][k]) for name in _NAMED]
                scene, condition, pose_set = (
                    known[name][number] for name, number in zip(_NAMED[:3], numbers)
                )
            _show(axes[k], picture)
            view = f"view {views.numbers[chosen[k]]}: {scene}, {condition}"
            axes[k].set_title(plain(f"{view}\npose {numbers[3]} of {pose_set}"), loc="left")
        save_figure(figure, names)
    return views.numbers[chosen]


def _show(panel: Axes, picture: NDArray[np.uint8]) -> None:
    """A view's picture, each eye's panel in a border, with its letter where there are two."""
    from matplotlib.patheffects import withStroke

    panel.imshow(_bordered(picture), interpolation="nearest")
    count = picture.shape[1] // _PIXELS
    for k, letter in enumerate("LR" if count == 2 else ""):
        panel.text(
            k * (_PIXELS + _GAP) + 8, 8, letter, ha="left", va="top", color=INK,
            path_effects=[withStroke(linewidth=1.6, foreground="white")],
        )  # fmt: skip


def _bordered(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The panels of a picture, each with a border, on white."""
    panels = picture.reshape(len(picture), -1, _PIXELS, 3).swapaxes(0, 1).copy()
    for edge in (np.s_[:, :2], np.s_[:, -2:], np.s_[:, :, :2], np.s_[:, :, -2:]):
        panels[edge] = _BORDER
    gap = np.full((len(picture), _GAP, 3), 255, np.uint8)
    parts = [part for panel in panels for part in (gap, panel)]
    return np.concatenate(parts[1:], axis=1)


def _picture(eye: Eye, response: NDArray[np.float32], light: Light | None) -> NDArray[Any]:
    if light is None:
        return _projected(eye, response)
    if not np.any(sum(light.irradiance())):
        # By lamps alone: the brightest that is seen is white, but for a few.
        light = uniform_sky(np.percentile(response, 98), bands=light.bands, unit=light.unit)
    return _projected(eye, bands_to_rgb(response, light))


def _projected(eye: Eye, response: NDArray[np.float32]) -> NDArray[np.uint8]:
    picture = project(eye, np.ascontiguousarray(response), width=_PIXELS)
    picture[_unseen(eye)] = _UNSEEN
    return picture


def _unseen(eye: Eye) -> NDArray[np.bool_]:
    """Where on a picture no ommatidium looks."""
    nothing = np.zeros((len(eye), 3), np.float32)
    return np.asarray(np.isnan(project(eye, nothing, width=_PIXELS, linear=True)).any(axis=-1))


def _eye(views: Views) -> Eye:
    """The eye as the store has it: where ommatidia look, how wide, in which eye."""
    inside = read_manifest(views.store)["groups"][views.eye]
    root = open_store(views.store)
    with reading(views.store, "a Zarr store"):
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
    with reading(views.store, "the lights of a data set"):
        found = [make_light(*one, bands) for one in lights_from(manifest["job"])]
        return [light for light in found if light is not None]
