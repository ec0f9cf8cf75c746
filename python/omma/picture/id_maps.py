"""Pictures of responses. They only read responses; nothing here traces a ray.

All pictures are in the head's frame: azimuth -180° to 180° from left to right with straight ahead
in the middle and the animal's right to the right; elevation +90° at the top, -90° at the bottom.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import checked, whole
from omma.picture.fields import field_ids, side_by_side_ids
from omma.picture.kept_ids import Ids, kept_ids
from omma.picture.projections import Picture, displayed_pose, one_pose, projection_ids
from omma.picture.unseen import hatch

__all__ = [
    "Ids",
    "Picture",
    "encode_ids",
    "equirectangular",
    "equirectangular_ids",
    "field_ids",
    "one_pose",
    "paint",
    "projection_ids",
    "side_by_side",
    "side_by_side_ids",
]

_NO_LIMIT_RAD = 7.0
_LARGEST_PIXELS = 1 << 15


@checked
def encode_ids(ids: ArrayLike) -> NDArray[np.uint8]:
    """An id map (height, width) as an RGBA picture, uint8 (height, width, 4).

    The id is a 32-bit number, its highest byte in R, its lowest in A, as in CompoundRay's ``_ids``
    projections; -1 is 255, 255, 255, 255. Back again: ``picture.view('>i4')[..., 0]``.

    Raises:
        omma.Error: the ids are not two-dimensional whole numbers.
    """
    return _core.encode_ids(ids)


@checked
def paint(ids: ArrayLike, responses: ArrayLike, gamma: float = 2.2) -> NDArray[np.uint8]:
    """One pose's responses (N, 3) through an id map (height, width) as an 8-bit RGB picture
    (height, width, 3). Display value = 255 * clamp(response)^(1/gamma); id -1 is mid grey.

    The look-up and nothing else, for programs; `project` hatches what nobody sees.

    Raises:
        omma.Error: a wrong shape, an id over N, a gamma that is not over 0.
    """
    return _core.paint(ids, responses, gamma)


@checked
def equirectangular_ids(
    eye: Eye,
    width: int = 1024,
    height: int = 512,
    *,
    by: Literal["axis", "position"] = "axis",
    max_angle_deg: float | None = None,
) -> Ids:
    """Which ommatidium each pixel of an equirectangular picture shows: int32 (height, width).

    The map is made once and kept; it is read-only.

    Args:
        eye: the eye, or all eyes of a head.
        width, height: pixels.
        by: "axis" takes the ommatidium whose axis is nearest to the pixel's direction, "position"
            the one whose position, seen from the middle of all positions, is.
        max_angle_deg: where the nearest is farther than this the pixel is -1; None: no limit.

    Raises:
        omma.Error: a size, ``by`` or an angle that makes no sense.
    """
    width = whole(width, "width", 1, _LARGEST_PIXELS)
    height = whole(height, "height", 1, _LARGEST_PIXELS)
    if by not in ("axis", "position"):
        raise Error(f"by: expected 'axis' or 'position', found {by!r}")
    if len(eye) == 0:
        raise Error("eye: expected at least one ommatidium, found none")
    limit = _NO_LIMIT_RAD
    if max_angle_deg is not None:
        if not max_angle_deg >= 0:
            raise Error(f"max_angle_deg: expected 0 or more, found {max_angle_deg}")
        limit = float(np.radians(min(max_angle_deg, 360)))
    return kept_ids(
        eye,
        ("equirectangular", by, limit, width, height),
        lambda: _core.equirectangular_ids(eye, width, height, by == "position", limit),
    )


@checked
def equirectangular(
    eye: Eye,
    responses: ArrayLike,
    width: int = 1024,
    height: int = 512,
    *,
    gamma: float = 2.2,
    by: Literal["axis", "position"] = "axis",
    max_angle_deg: float | None = None,
) -> Picture:
    """One pose's responses as an equirectangular picture: uint8 RGB (height, width, 3).

    Args:
        eye: the eye that the responses are of.
        responses: (N, 3) or (1, N, 3), linear.
        width, height, by, max_angle_deg: as in `equirectangular_ids`; -1 is hatched.
        gamma: display value = 255 * clamp(response) ** (1 / gamma).

    Raises:
        omma.Error: responses of another eye or below 0, or arguments that make no sense.
    """
    one = displayed_pose(eye, responses)
    ids = equirectangular_ids(eye, width, height, by=by, max_angle_deg=max_angle_deg)
    return hatch(_core.paint(ids, one, gamma), ids < 0)


@checked
def side_by_side(
    eye: Eye,
    responses: ArrayLike,
    width: int = 1024,
    height: int = 512,
    *,
    gamma: float = 2.2,
) -> Picture:
    """The eyes of a head next to each other: uint8 RGB (height, number of eyes * width, 3).

    The eye that looks farther to the left is on the left. Each panel is an equirectangular picture
    of the whole sphere around the head that shows that eye's own ommatidia; what lies outside its
    visual field (see `field_ids`) is hatched. `framed` gives them borders and degrees.

    Args:
        eye: all eyes of the head, see `merge_eyes`.
        responses: (N, 3) or (1, N, 3), linear.
        width, height: pixels of one panel.
        gamma: as in `equirectangular`.

    Raises:
        omma.Error: responses of another eye or below 0, or arguments that make no sense.
    """
    one = displayed_pose(eye, responses)
    ids = side_by_side_ids(eye, width, height)
    return hatch(_core.paint(ids, one, gamma), ids < 0)
