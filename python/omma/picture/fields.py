"""What an eye sees and what it does not, in equirectangular pictures; an eye's default picture.

The default picture is equirectangular, and empty where no ommatidium looks. Where two eyes of a
head see the same direction, one picture would hide what one of them sees: each eye then has a
picture of its own, from left to right as they look.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Eye
from omma.base.arguments import checked, whole
from omma.base.directions import direction
from omma.eye.field import MOST_GAP_SR
from omma.picture.kept_ids import Ids, kept_ids

_LARGEST_PIXELS = 1 << 15
# Eyes in one picture: spiders have eight. A head of more is drawn as one.
_MOST_APART = 8
# Across a sphere: 1°, finer than most ommatidia.
_OVERLAP_WIDTH, _OVERLAP_HEIGHT = 360, 180


@checked
def field_ids(eye: Eye, width: int = 1024, height: int = 512) -> Ids:
    """`equirectangular_ids` by axis, with -1 outside the eye's visual field: int32 (height, width).

    A direction counts as seen by the ommatidium with the nearest axis where it lies within that
    one's local interommatidial angle or its acceptance angle, whichever is larger. So the field
    ends about one facet beyond the last axis. Gaps in it that are smaller than an ommatidium's cell
    and than 1 % of the sphere lie between neighbours of a stretched lattice, and count as seen too.
    """
    return _field_ids(eye, width, height, False)


def side_by_side_ids(eye: Eye, width: int = 1024, height: int = 512) -> Ids:
    """Id map of `side_by_side`: indices into the whole head, -1 outside an eye's visual field."""
    return _field_ids(eye, width, height, True)


def default_ids(eye: Eye, width: int, height: int) -> Ids:
    """Id map of the default picture: `field_ids`, or `side_by_side_ids` where the fields of two
    eyes overlap; panels are ``width`` x ``height``."""
    return _field_ids(eye, width, height, eyes_overlap(eye))


def eyes_overlap(eye: Eye) -> bool:
    """Whether two eyes of a head see a direction in common, and are few enough to draw apart."""
    if len(np.unique(eye.eye_id)) > _MOST_APART:
        return False
    panels = _panels(side_by_side_ids(eye, _OVERLAP_WIDTH, _OVERLAP_HEIGHT), _OVERLAP_WIDTH)
    return bool(((panels >= 0).sum(axis=0) > 1).any())


def without_gaps(
    seen: NDArray[np.bool_], solid_angle_sr: NDArray[np.float64], least_sr: float
) -> NDArray[np.bool_]:
    """``seen`` (H, W) with the unseen patches of less than ``least_sr`` filled.

    solid_angle_sr: (H, W) or (H, 1), of each pixel. A patch goes on from the right edge of the
    picture to the left one, as directions do.
    """
    from scipy.ndimage import label

    patch, count = label(~seen)
    # Patches that touch across the seam are one: both have the lower number.
    first = np.arange(count + 1)
    for one, other in zip(patch[:, 0].tolist(), patch[:, -1].tolist(), strict=True):
        if one and other:
            low, high = sorted((int(first[one]), int(first[other])))
            first[first == high] = low
    patch = first[patch]
    size = np.bincount(
        patch.ravel(), np.broadcast_to(solid_angle_sr, seen.shape).ravel(), count + 1
    )
    return np.asarray(seen | (size[patch] < least_sr))


def largest_gap_sr(spacing_rad: NDArray[np.floating]) -> float:
    """The solid angle of the cells of an eye's widest ommatidia but for one in twenty, which may
    stand alone: (√3/2)·Δφ² of a hexagon, at most `MOST_GAP_SR`. ``spacing_rad`` is Δφ, (N,)."""
    known = spacing_rad[np.isfinite(spacing_rad)].astype(np.float64)
    if not len(known):
        return 0.0
    return min(float(np.sqrt(3) / 2 * np.percentile(known, 95) ** 2), MOST_GAP_SR)


def _field_ids(eye: Eye, width: int, height: int, apart: bool) -> Ids:
    width = whole(width, "width", 1, _LARGEST_PIXELS)
    height = whole(height, "height", 1, _LARGEST_PIXELS)
    return kept_ids(
        eye, ("field", apart, width, height), lambda: _make_field(eye, width, height, apart)
    )


def _make_field(eye: Eye, width: int, height: int, apart: bool) -> Ids:
    from scipy.spatial import cKDTree

    ids = _core.field_ids(eye, width, height, apart)
    if len(eye) < 3:
        return ids
    edges = np.sin(np.pi / 2 * np.linspace(1, -1, height + 1))
    each = (-np.diff(edges) * 2 * np.pi / width)[:, None]
    least = largest_gap_sr(eye.interommatidial_angle_rad())
    for panel in _panels(ids, width):
        gaps = without_gaps(panel >= 0, each, least) & (panel < 0)
        if gaps.any():
            row, column = np.nonzero(gaps)
            towards = direction((column + 0.5) / width * 360 - 180, 90 - (row + 0.5) / height * 180)
            members = np.unique(panel[panel >= 0])
            panel[gaps] = members[cKDTree(eye.axis[members]).query(towards)[1]]
    return ids


def _panels(ids: Ids, width: int) -> Ids:
    """The panels of pictures beside one another, as a view: (panels, H, width)."""
    panels: Ids = ids.reshape(len(ids), -1, width).transpose(1, 0, 2)
    return panels
