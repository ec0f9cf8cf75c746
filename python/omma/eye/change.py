"""Eyes changed: rescaled, split in two, mirrored, put on a head, given other acceptance angles.

Eyes are values: each function returns a new one that keeps every property it does not change. What
CompoundRay's own scripts do differently is said at each.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import checked, positive
from omma.base.arrays import Floats
from omma.base.directions import angle_of_chord
from omma.base.poses import poses_from_angles
from omma.base.renamed import renamed_arguments
from omma.base.warn import warn_caller
from omma.eye.doubles import doubles
from omma.eye.files import changed_told

# What counts as in the middle: of the mean x of an eye of size 1, and of the mean of unit axes. And
# how far to the other side than it sits an eye looks that is hardly meant.
_MIDDLE, _LOOKS_ACROSS = 0.1, 0.3
# No animal's eye sits further from the middle of its head: the radius of the largest eyes.
_FARTHEST_M = 0.1


@checked
def merge_eyes(eyes: Iterable[Eye | tuple[Eye, ArrayLike]]) -> Eye:
    """All eyes of a head as one; ``eye_id`` numbers them from 0 in the order given.

    Args:
        eyes: each an `Eye`, or a pair (eye, head_from_eye) with where it sits in the head as a
            (4, 4) transform, m.

    Raises:
        omma.Error: an item is something else, or a transform is not usable.
    """
    return _core.merge_eyes(eyes)


@checked
def rescale_eye(
    eye: Eye, factor: float | None = None, *, mean_radius_m: float | None = None
) -> Eye:
    """The eye ``factor`` times as large about the origin of its frame: positions, focal offsets,
    facets and apertures.

    ``mean_radius_m`` instead of a factor makes the mean distance of the ommatidia from the origin
    that many metres, as CompoundRay's rescaler does (which leaves focal offsets as they are).
    Directions and angular sensitivities stay.

    Raises:
        omma.Error: neither or both given, not above 0, or a mean radius for an eye all of whose
            ommatidia are at the origin.

    Warns:
        UserWarning: numbers that no animal has, which the eye had not before.
    """
    if (factor is None) == (mean_radius_m is None):
        raise Error("rescale_eye: expected either factor or mean_radius_m")
    if mean_radius_m is not None:
        positive(mean_radius_m, "mean_radius_m")
        radius_m = float(np.linalg.norm(eye.position_m.astype(np.float64), axis=1).mean())
        if radius_m == 0:
            raise Error("mean_radius_m: all ommatidia are at the origin, no factor moves them")
        factor = mean_radius_m / radius_m
    assert factor is not None
    positive(factor, "factor")
    lengths = ("position_m", "focal_offset_m", "facet_diameter_m", "aperture_diameter_m")
    scaled = {name: getattr(eye, name).astype(np.float64) * factor for name in lengths}
    return changed_told(eye, eye.replace(**scaled))


@checked
def split_eye(eye: Eye, shift_m: float = 0.0, overlap_m: float = 0.0) -> Eye:
    """Split in two by the side on which the ommatidia sit: ``eye_id`` 0 is left, 1 is right.

    Left is x < 0. Ommatidia within ``overlap_m`` of the middle plane go to both eyes. Then the left
    eye is moved ``shift_m`` to the left, the right one as far to the right. The result lists the
    left eye first; `Eye.select` takes one of them.

    CompoundRay's splitter does the same, but drops what sits exactly in the middle where there is
    no overlap; here that goes to the right. It also mixes the two eyes in its file.

    Raises:
        omma.Error: a negative overlap, a shift that is not finite, nothing on one side.

    Warns:
        UserWarning: a shift of more than 10 cm.
    """
    if not np.isfinite(shift_m):
        raise Error(f"shift_m: expected a finite length, found {shift_m}")
    if not (np.isfinite(overlap_m) and overlap_m >= 0):
        raise Error(f"overlap_m: expected a length of at least 0, found {overlap_m}")
    x = eye.position_m[:, 0].astype(np.float64)
    left = np.flatnonzero(x < overlap_m)
    right = np.flatnonzero((x > -overlap_m) | (x == 0))
    for name, members in (("left", left), ("right", right)):
        if len(members) == 0:
            raise Error(
                f"split_eye: no ommatidium sits on the {name} (x from {x.min() * 1e3:.4g} to "
                f"{x.max() * 1e3:.4g} mm)"
            )
    both = np.concatenate([left, right])
    is_right = np.repeat([0, 1], [len(left), len(right)])
    position = eye.position_m[both].astype(np.float64)
    position[:, 0] += np.where(is_right == 1, shift_m, -shift_m)
    _tell_of_place(abs(shift_m), "split_eye: shift_m")
    return eye.take(both).replace(position_m=position, eye_id=is_right)


@checked
def mirror_eye(eye: Eye) -> Eye:
    """The mirror image of an eye, or of a head, left for right: x becomes -x.

    Angular sensitivities, microvilli and the offsets of receptors are mirrored too. ``eye_id``
    stays with the ommatidia: of a head whose eye 0 is the left one, eye 0 is the right one then.
    """
    return merge_eyes([(eye, np.diag([-1.0, 1.0, 1.0, 1.0]))]).replace(eye_id=eye.eye_id)


@renamed_arguments(right="eye")
@checked
def pair_of_eyes(eye: Eye) -> Eye:
    """A head with an eye and its mirror image: ``eye_id`` 0 is left, 1 is right, and the left eye
    comes first, whichever is given.

    The eye given is a left one where its ommatidia sit left of the midline, x < 0, in the mean.
    Where that is within a tenth of the eye's size, as of an eye in a frame of its own, its mean
    axis says it; where that is within 0.1 of the midline too, as of one that looks all around, it
    is taken for a right one.

    Example:
        >>> head = omma.eye.pair_of_eyes(omma.eye.generate_eye(50))
        >>> len(head)
        100

    Raises:
        omma.Error: a head that has eyes on both sides already.

    Warns:
        UserWarning: the eye sits on one side and looks to the other.
    """
    _expect_one_side(eye)
    image = mirror_eye(eye)
    left = is_left(eye)
    sits, looks = _sides(eye)
    if sits * looks < 0 and abs(looks) > _LOOKS_ACROSS:
        side, other = ("left", "right") if left else ("right", "left")
        warn_caller(
            f"pair_of_eyes: the eye sits on the {side} and looks to the {other}; it is taken for "
            f"the {side} one: place_on_head moves it",
            UserWarning,
        )
    return merge_eyes([eye, image] if left else [image, eye])


def _expect_one_side(eye: Eye) -> None:
    """omma.Error where an eye has several, some on the left and some on the right."""
    sides: dict[int, list[int]] = {-1: [], 1: []}
    for one in np.unique(eye.eye_id).tolist():
        sits, looks = _sides(eye.select(one))
        side = int(np.sign(sits or looks))
        if side:
            sides[side].append(one)
    if sides[-1] and sides[1]:
        left, right = (", ".join(map(str, sides[side][:3])) for side in (-1, 1))
        raise Error(
            "pair_of_eyes: expected an eye of one side, found a head with both: eye_id "
            f"{left} on the left and {right} on the right; eye.select takes one of them"
        )


def is_left(eye: Eye) -> bool:
    """Whether `pair_of_eyes` takes an eye for a left one."""
    sits, looks = _sides(eye)
    return sits < 0 or (sits == 0 and looks < 0)


def _sides(eye: Eye) -> tuple[float, float]:
    """Mean x of the ommatidia, over the eye's size, and of their axes; 0 in the middle."""
    position = eye.position_m.astype(np.float64)
    size = float(np.ptp(position, axis=0).max())
    mean = float(position[:, 0].mean())
    sits = mean if size == 0 else mean / size
    looks = float(eye.axis[:, 0].mean(dtype=np.float64))
    if size > 0 and abs(sits) < _MIDDLE:
        sits = 0.0
    return sits, looks if abs(looks) >= _MIDDLE else 0.0


@checked
def place_on_head(
    eye: Eye,
    position_m: ArrayLike = (0.0, 0.0, 0.0),
    *,
    yaw_deg: float = 0.0,
    pitch_deg: float = 0.0,
    roll_deg: float = 0.0,
) -> Eye:
    """The eye turned about the origin of its frame and then moved by ``position_m``.

    Turned by yaw (to the right), then pitch (upwards), then roll (to the right), each about the
    eye's own axes as they then are, as poses are.

    Raises:
        omma.Error: a position or angle that is none.

    Warns:
        UserWarning: a position more than 10 cm from the head's origin.
    """
    head_from_eye = poses_from_angles(position_m, (yaw_deg, pitch_deg, roll_deg))[0]
    _tell_of_place(float(np.linalg.norm(head_from_eye[:3, 3])), "place_on_head: position_m")
    return merge_eyes([(eye, head_from_eye)]).replace(eye_id=eye.eye_id)


def _tell_of_place(length_m: float, name: str) -> None:
    if length_m > _FARTHEST_M:
        warn_caller(
            f"{name}: {length_m:.4g} m is further than any animal's eye sits from the middle of "
            f"its head ({_FARTHEST_M:g} m); {length_m:.4g} mm would be {length_m * 1e-3:.4g} m",
            UserWarning,
        )


@checked
def join_eyes(eyes: Sequence[Eye]) -> Eye:
    """All eyes of several, which may be heads, as one head; ``eye_id`` numbers them in order.

    `merge_eyes` takes each item as one eye.

    Raises:
        omma.Error: none given.
    """
    if not eyes:
        raise Error("join_eyes: expected at least one eye, found none")
    return merge_eyes([eye.select(int(one)) for eye in eyes for one in np.unique(eye.eye_id)])


@checked
def set_acceptance(
    eye: Eye,
    *,
    angle_rad: float | None = None,
    factor: float | None = None,
    ratio: float | None = None,
    non_overlapping: bool = False,
    compoundray_maximal: bool = False,
) -> Eye:
    """The eye with other acceptance angles, all round Gaussians; exactly one rule says which.

    - ``angle_rad``: this angle for all.
    - ``factor``: the present angles times this.
    - ``ratio``: this times the local interommatidial angle Δφ, the mean angle to the (up to) six
      nearest axes of the same eye: Δρ = ratio · Δφ. Of doubles and copies, as `measure_eye` names
      them, one counts.
    - ``non_overlapping``: the angle to the nearest axis of the same eye. Cones of half that angle
      around each axis touch at most: of all rules that look at the nearest neighbour only, the
      widest that never overlaps.
    - ``compoundray_maximal``: 2 (d - e/2), where d is the angle to the nearest axis and e the angle
      from that neighbour to its own nearest axis: the rule of CompoundRay's adjuster, with which
      its eyes of variable acceptance were made. Equal to ``non_overlapping`` where two axes are
      each other's nearest; wider elsewhere, where cones may then overlap.

    Raises:
        omma.Error: none or several rules, a number out of range, two axes of one eye that are the
            same (for the rules that look at the nearest), an eye of one ommatidium.

    Warns:
        UserWarning: numbers that no animal has, which the eye had not before.
    """
    given = [angle_rad is not None, factor is not None, ratio is not None]
    if sum([*given, non_overlapping, compoundray_maximal]) != 1:
        raise Error(
            "set_acceptance: expected exactly one of angle_rad, factor, ratio, non_overlapping, "
            "compoundray_maximal"
        )
    if angle_rad is not None:
        angle = np.full(len(eye), float(angle_rad))
    elif factor is not None:
        angle = eye.acceptance_angle_rad.astype(np.float64) * positive(factor, "factor")
    elif ratio is not None:
        between = _interommatidial_rad(eye)
        _check_neighbours(between, "interommatidial angle")
        angle = between * positive(ratio, "ratio")
    else:
        nearest, angle = _nearest_axis(eye)
        _check_neighbours(angle, "angle to the nearest axis")
        if compoundray_maximal:
            angle = 2 * (angle - angle[nearest] / 2)
    return changed_told(eye, eye.replace(acceptance_angle_rad=angle))


def _interommatidial_rad(eye: Eye) -> Floats:
    # Of doubles, exact copies among them, the first alone.
    axis = eye.axis.astype(np.float64)
    double_of = doubles(eye.position_m.astype(np.float64), axis, eye.eye_id)
    single = np.flatnonzero(double_of < 0)
    between = np.zeros(len(eye))
    between[single] = eye.take(single).interommatidial_angle_rad()
    return np.where(double_of < 0, between, between[double_of])


def _check_neighbours(angle: Floats, what: str) -> None:
    if not np.all(angle > 0):
        worst = int(np.argmin(angle))
        raise Error(
            f"set_acceptance: the {what} of ommatidium {worst} is 0: it has no neighbour, or one "
            "with the same axis"
        )


def _nearest_axis(eye: Eye) -> tuple[NDArray[np.intp], Floats]:
    # Of the same eye: index (N,) and angle (N,), 0 for the only ommatidium of an eye. The angle
    # from the distance of the tips, as the arc cosine loses small angles.
    axis = eye.axis.astype(np.float64)
    nearest = np.arange(len(eye))
    for one in np.unique(eye.eye_id):
        members = np.flatnonzero(eye.eye_id == one)
        if len(members) == 1:
            continue
        for start in range(0, len(members), 512):
            rows = members[start : start + 512]
            cosine = axis[rows] @ axis[members].T
            cosine[np.arange(len(rows)), np.arange(start, start + len(rows))] = -2
            nearest[rows] = members[np.argmax(cosine, axis=1)]
    chord = np.linalg.norm(axis - axis[nearest], axis=1)
    return nearest, angle_of_chord(chord)
