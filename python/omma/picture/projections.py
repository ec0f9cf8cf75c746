"""Eyes laid out in pictures: which ommatidium a pixel shows, and responses painted that way.

docs/looking-at-eyes.md shows each projection and says which direction is where in it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, one_of, whole
from omma.picture.fields import default_ids
from omma.picture.kept_ids import Ids, kept_ids
from omma.picture.response_scale import is_rgb_below_0
from omma.picture.unseen import aspect_of, hatch, unseen

Picture = NDArray[np.uint8]
LinearPicture = NDArray[np.float32]

#: The names of all projections; with ``_ids`` added, a picture shows ids instead of responses.
PROJECTIONS: tuple[str, ...] = tuple(_core.projection_names())

_MOST_PIXELS = 1 << 30
_DEFAULT_WIDTH = 1024
# These have a pixel for each ommatidium, so that their width is that of the eye.
LISTS = ("single_dimension_fast", "raw_ommatidial_samples")


@checked
def projection_ids(
    eye: Eye,
    projection: str | None = None,
    width: int | None = None,
    height: int | None = None,
) -> Ids:
    """Which ommatidium each pixel shows: int32 (height, width), -1 for none.

    Without a projection the picture is equirectangular and empty where no ommatidium looks
    (`field_ids`); where two eyes see the same direction each is drawn apart (`side_by_side`).

    The map is made once for an eye, a projection and a size, and kept; it is read-only.

    Args:
        eye: the eye, or all eyes of a head. Eyes are told apart by ``eye_id``; a single one whose
            positions leave a wide gap around x = 0 counts as a left and a right one.
        projection: one of `omma.picture.PROJECTIONS`; an ending ``_ids`` makes no difference here.
        width, height: pixels, of each eye where they are drawn apart. The one left out follows from
            the other; 1024 wide where both are. ``single_dimension_fast`` and
            ``raw_ommatidial_samples`` are as wide as there are ommatidia.

    Example:
        >>> omma.picture.projection_ids(omma.eye.generate_eye(50), width=64).shape
        (32, 64)

    Raises:
        omma.Error: a projection that there is not, a size that makes no sense, an eye that the
            projection cannot show (``facets`` of an eye whose positions are one point, say).
    """
    width, height = projection_size(eye, projection, width, height)
    if projection is None:
        return default_ids(eye, width, height)
    plain = projection.removesuffix("_ids")
    return kept_ids(
        eye,
        (plain, width, height),
        lambda: _core.projection_ids(eye, plain, width, height),
    )


@checked
def project(
    eye: Eye,
    responses: ArrayLike | None,
    projection: str | None = None,
    width: int | None = None,
    height: int | None = None,
    *,
    gamma: float = 2.2,
    linear: bool = False,
) -> NDArray[Any]:
    """One pose's responses as a picture: uint8 RGB (height, width, 3), row 0 at the top.

    Args:
        eye: the eye that the responses are of.
        responses: (N, 3) or (1, N, 3), linear. ``raw_ommatidial_samples`` takes the radiance of
            each ray instead, see `Renderer.render_rays`: (N, S, 3) or (1, N, S, 3); its picture
            has a column for each ommatidium and a row for each sample. Projections that end in
            ``_ids`` take None.
        projection, width, height: as in `projection_ids`.
        gamma: display value = 255 * clamp(response) ** (1 / gamma); directions that no ommatidium
            sees are hatched, other pixels that show none are mid grey.
        linear: for programs: the responses themselves, float32 (height, width, 3), not clipped;
            NaN where there is no ommatidium.

    Returns:
        A picture as above, or for projections that end in ``_ids`` the ids as RGBA, see
        `encode_ids`.

    Raises:
        omma.Error: responses of another eye or, but for ``linear``, below 0 (no colour shows
            them), or arguments that make no sense.
    """
    if projection is not None and projection.endswith("_ids"):
        if linear:
            raise Error(f"linear: {projection} shows ids, not responses; see projection_ids")
        return _core.encode_ids(projection_ids(eye, projection, width, height))
    if projection == "raw_ommatidial_samples":
        rays = _rays_of_one_pose(eye, responses)
        samples = rays.shape[1]
        ids = projection_ids(eye, projection, width, samples if height is None else height)
        if len(ids) < samples:
            raise Error(f"height: expected at least the {samples} samples, found {len(ids)}")
        rows = np.arange(len(ids), dtype=np.int32)[:, np.newaxis]
        # Sample s of ommatidium i is the row i * samples + s of the flat array.
        ids = np.where((ids >= 0) & (rows < samples), ids * np.int32(samples) + rows, np.int32(-1))
        shown = rays.reshape(-1, rays.shape[2])
    else:
        shown = (one_pose if linear else displayed_pose)(eye, responses)
        ids = projection_ids(eye, projection, width, height)
    if linear:
        return paint_linear(ids, shown)
    return hatch(_core.paint(ids, shown, gamma), unseen(ids, projection))


def paint_linear(ids: Ids, responses: NDArray[np.float32]) -> LinearPicture:
    """Responses (N, 3) through an id map (height, width): float32 (height, width, 3), linear, not
    clipped; NaN where the id is -1."""
    nothing = np.full((1, responses.shape[1]), np.nan, np.float32)
    return np.concatenate([responses, nothing])[ids]


def projection_size(
    eye: Eye, projection: str | None, width: int | None = None, height: int | None = None
) -> tuple[int, int]:
    """Width and height of a projection's picture, with what is left out filled in; without a
    projection, of a panel of the default picture."""
    plain = None if projection is None else projection.removesuffix("_ids")
    if plain is not None:
        one_of(plain, PROJECTIONS, "projection", " (or one of them with _ids)")
    if len(eye) == 0:
        raise Error("eye: expected at least one ommatidium, found none")
    if width is not None:
        width = whole(width, "width", 1, _MOST_PIXELS)
    if height is not None:
        height = whole(height, "height", 1, _MOST_PIXELS)
    if plain in LISTS:
        return width or len(eye), height or 1
    aspect = aspect_of(plain)
    if width is None:
        width = _DEFAULT_WIDTH if height is None else height * aspect
    return width, height or max(1, width // aspect)


def one_pose(eye: Eye, responses: Any) -> NDArray[np.float32]:
    """``responses`` as float32 (N, 3) of one pose of this eye."""
    array = array_of(responses, "responses", dtype=np.float32)
    if array.ndim == 3 and len(array) == 1:
        array = array[0]
    expected = (len(eye), _core.rgb_bands)
    if array.shape != expected:
        raise Error(
            f"responses: expected shape {expected} (red, green, blue) of one pose, found "
            f"{array.shape}"
        )
    return array


def displayed_pose(eye: Eye, responses: Any) -> NDArray[np.float32]:
    """`one_pose` for a display, which has no colours for numbers below 0."""
    one = one_pose(eye, responses)
    if is_rgb_below_0(one):
        raise Error(
            f"responses: expected red, green and blue from 0 on, found {one.min():.3g}; "
            "plot_responses draws such numbers, one channel at a time, and project keeps them with "
            "linear=True"
        )
    return one


def _rays_of_one_pose(eye: Eye, rays: Any) -> NDArray[np.float32]:
    array = array_of(rays, "responses", dtype=np.float32)
    if array.ndim == 4 and len(array) == 1:
        array = array[0]
    good = array.ndim == 3 and array.shape[1] > 0
    if not good or (array.shape[0], array.shape[2]) != (len(eye), _core.rgb_bands):
        raise Error(
            f"responses: raw_ommatidial_samples takes the rays of one pose, shape ({len(eye)}, "
            f"samples, {_core.rgb_bands}), found {array.shape}"
        )
    return array
