"""Eyes changed: rescaled, split in two, mirrored, put on a head, given other acceptance angles, or
read from old files.

Eyes are values: each function returns a new one that keeps every property it does not change. What
CompoundRay's own scripts do differently is said at each.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import checked, positive
from omma.base.arrays import Floats
from omma.base.directions import angle_of_chord
from omma.base.files import PathLike, metres_per_unit, open_text
from omma.base.poses import poses_from_angles
from omma.base.renamed import renamed_arguments
from omma.base.values import value_class
from omma.base.warn import warn_caller
from omma.eye.files import slips_in

# What counts as in the middle: of the mean x of an eye of size 1, and of the mean of unit axes. And
# how far to the other side than it sits an eye looks that is hardly meant.
_MIDDLE, _LOOKS_ACROSS = 0.1, 0.3


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
    return eye.replace(**{name: getattr(eye, name).astype(np.float64) * factor for name in lengths})


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
    return eye.take(both).replace(position_m=position, eye_id=is_right)


@checked
def mirror_eye(eye: Eye) -> Eye:
    """The mirror image of an eye, left for right: x becomes -x.

    Angular sensitivities, microvilli and the offsets of receptors are mirrored too.
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

    Warns:
        UserWarning: the eye sits on one side and looks to the other.
    """
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
    """
    head_from_eye = poses_from_angles(position_m, (yaw_deg, pitch_deg, roll_deg))[0]
    return merge_eyes([(eye, head_from_eye)]).replace(eye_id=eye.eye_id)


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
      nearest axes of the same eye: Δρ = ratio · Δφ.
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
        between = eye.interommatidial_angle_rad().astype(np.float64)
        _check_neighbours(between, "interommatidial angle")
        angle = between * positive(ratio, "ratio")
    else:
        nearest, angle = _nearest_axis(eye)
        _check_neighbours(angle, "angle to the nearest axis")
        if compoundray_maximal:
            angle = 2 * (angle - angle[nearest] / 2)
    return eye.replace(acceptance_angle_rad=angle)


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


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class ConvertedEye:
    """An eye from an old file, and what was assumed, dropped or looks wrong, a sentence each."""

    eye: Eye
    columns: int
    notes: tuple[str, ...]


@checked
def convert_eye(path: PathLike, unit: str | float = "mm", *, degrees: bool = False) -> ConvertedEye:
    """Read an `.eye` file of another age, with 7, 8 or 9 columns; `omma.save_eye` writes it anew.

    Columns 1 to 7 are position x y z, axis x y z and acceptance angle in all of them. Today's files
    have the focal offset as column 8. CompoundRay's early files have 7: no offset, rays start at
    the position, so it becomes 0. Of 9 columns the first 8 are taken for today's, which is how
    CompoundRay reads such a file; the ninth is dropped. Its meaning is not on record.

    Args:
        unit: unit of lengths: "mm", "um", "m" or a number of metres.
        degrees: column 7 holds degrees, as some early tools expected, instead of radians.

    Raises:
        omma.Error: the file cannot be read, a line has another number of columns than the first or
            something that is no number, or what the columns say is no eye.
    """
    name = os.fsdecode(path)
    table = _read_table(name)
    columns = table.shape[1]
    if columns not in (7, 8, 9):
        raise Error(f"{name}, line 1: expected 7, 8 or 9 columns, found {columns}")
    notes = list(_column_notes(table))
    angle = np.radians(table[:, 6]) if degrees else table[:, 6]
    if degrees:
        notes.append("Assumed: the acceptance angles of column 7 are degrees; written as radians.")
    elif angle.max() > 2 * np.pi:
        raise Error(
            f"{name}: expected acceptance angles (column 7) from 0 to 2 pi rad, found "
            f"{angle.max():.6g}; are they degrees?"
        )
    elif angle.max() > 1:
        notes.append(
            f"Assumed: the acceptance angles of column 7 are radians. The largest is "
            f"{angle.max():.4g} rad ({np.degrees(angle.max()):.4g}°): if they are degrees, "
            "say so when converting."
        )
    offset = table[:, 7] if columns > 7 else np.zeros(len(table))
    metres = metres_per_unit(unit)
    turned = np.array([1, 1, -1])  # the file's z points ahead, ours backwards
    try:
        eye = Eye(
            table[:, 0:3] * turned * metres,
            table[:, 3:6] * turned,
            angle,
            offset * metres,
        )
    except Error as error:
        raise Error(f"{name}: {error}") from None
    notes += [f"{sentence}." for sentence in slips_in(eye)]
    return ConvertedEye(eye, columns, tuple(notes))


def _column_notes(table: Floats) -> tuple[str, ...]:
    columns = table.shape[1]
    if columns == 7:
        return (
            "Assumed: focal offset 0 (the file has 7 columns and no offset): rays start at the "
            "positions.",
        )
    if columns == 8:
        return ("Nothing to convert: the file has today's 8 columns already.",)
    ninth = table[:, 8]
    values = (
        f"all {ninth[0]:.6g}"
        if np.ptp(ninth) == 0
        else f"{ninth.min():.6g} to {ninth.max():.6g}, {len(np.unique(ninth))} different"
    )
    return (
        f"Lost: column 9 ({values}); today's format cannot hold it.",
        "Assumed: columns 7 and 8 are acceptance angle and focal offset, as CompoundRay reads a "
        "file of 9 columns.",
    )


def _read_table(name: str) -> Floats:
    rows: list[list[float]] = []
    first = 0
    for number, line in enumerate(open_text(name), start=1):
        words = line.split("#")[0].replace(",", " ").split()
        if not words:
            continue
        first = first or number
        if rows and len(words) != len(rows[0]):
            raise Error(
                f"{name}, line {number}: expected {len(rows[0])} columns as in line {first}, "
                f"found {len(words)}"
            )
        rows.append([_number(word, f"{name}, line {number}") for word in words])
    if not rows:
        raise Error(f"{name}: expected at least one ommatidium, found none")
    return np.array(rows)


def _number(word: str, where: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise Error(f"{where}: expected a finite number, found {word!r:.24}")
    return value
