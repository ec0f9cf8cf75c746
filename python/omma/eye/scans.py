"""Eyes from measurements: the spreadsheet of the Ommatidia Detecting Algorithm, and lenses and
crystalline cones marked in a scan.

Neither knows the head: ``ahead`` and ``up`` say which directions of the scan are the animal's.
Neither knows acceptance angles: they come from the interommatidial angles unless they are given.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats
from omma.base.files import PathLike, metres_per_unit
from omma.base.progress import Stage
from omma.base.values import value_class
from omma.eye.change import set_acceptance
from omma.eye.facets import facet_diameters_m
from omma.eye.files import made_told
from omma.eye.scan_pairs import (
    checked_outward,
    match_tips,
    off_the_midline,
    sphere_centre,
    split_eyes,
)
from omma.eye.scan_tables import ScanTable, read_points

__all__ = ["ImportedEye", "LensConeEye", "import_lens_cone", "import_oda"]


# Names in the Ommatidia Detecting Algorithm's ommatidial_data.csv (jpcurrea/ODA, analysis_tools.py,
# CTStack.measure_ommatidia) and in its forerunner's (jpcurrea/compound_eye_tools).
ODA_POSITION = (("x", "y", "z"), ("x_center", "y_center", "z_center"))
ODA_AXES = {"anatomical": "anatomical_axis", "approx": "approx_axis"}


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class ImportedEye:
    """An eye from a measurement, and what was assumed, left out or looks wrong, a sentence each."""

    eye: Eye
    notes: tuple[str, ...]


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class LensConeEye(ImportedEye):
    """An eye from lenses and cones: ommatidium i has lens ``lens[i]`` and cone ``cone[i]``.

    Attributes:
        lens, cone: (N,), indices of the points given.
        distance_m: (N,), from the tip of the cone to the lens.
        misfit_m: (N,), how far the tip is from where the neighbours' ones say it should be.
        doubtful: (N,) bool: another tip would fit as well, the misfit is over half the distance
            between tips.
        unmatched_lenses, unmatched_cones: indices of the points without a partner.
    """

    lens: NDArray[np.int64]
    cone: NDArray[np.int64]
    distance_m: Floats
    misfit_m: Floats
    doubtful: NDArray[np.bool_]
    unmatched_lenses: NDArray[np.int64]
    unmatched_cones: NDArray[np.int64]


@checked
def import_oda(
    path: PathLike,
    unit: str | float = "um",
    *,
    axis: str = "anatomical",
    acceptance_ratio: float = 1.0,
    acceptance_angle_rad: ArrayLike | None = None,
    ahead: ArrayLike = (0, 0, -1),
    up: ArrayLike = (0, 1, 0),
    progress: Stage | None = None,
) -> ImportedEye:
    """An eye from ``ommatidial_data.csv`` of the Ommatidia Detecting Algorithm (ODA-3D; Currea et
    al. 2023, Communications Biology).

    Its axes point into the eye, towards the centre, and are turned round. Facet diameters are its
    ``lens_diameter`` (the mean distance to the neighbours), or that of ``lens_area``. All other
    columns are kept under their names. Rows of the cluster of noise (``label`` 0 or less), which
    are no ommatidia, are left out.

    Args:
        unit: unit of the pixel size that ODA was given: "um", "mm", "m" or a number of metres.
        axis: "anatomical" (a line through the crystalline cone) or "approx" (across the surface).
            Ommatidia without an anatomical axis take the other.
        acceptance_ratio: acceptance angle over local interommatidial angle.
        acceptance_angle_rad: acceptance angles instead, (N,) or a number.
        ahead, up: (3,), where the animal's front and its upper side are in the scan.
        progress: called as progress(stage, finished fraction or None) now and then.

    Raises:
        omma.Error: the file cannot be read, lacks a column or has something else in it; it names
            line and column.

    Warns:
        UserWarning: numbers that no animal has, mostly of another unit than ``unit``.
    """
    name = os.fsdecode(path)
    metres = metres_per_unit(unit)
    if axis not in ODA_AXES:
        raise Error(f'axis: expected "anatomical" or "approx", found {axis!r}')
    tell = progress or (lambda stage, fraction: None)
    tell("reading the scan", None)
    table = ScanTable(name)
    names = next((names for names in ODA_POSITION if set(names) <= set(table.columns)), None)
    if names is None or not set(ODA_AXES.values()) & set(table.columns):
        raise Error(
            f"{name}, line 1: expected the columns of ODA's ommatidial_data.csv (x, y, z, "
            f"anatomical_axis, approx_axis), found {', '.join(table.columns)[:120]}"
        )
    notes: list[str] = []
    if "label" in table.columns:
        # measure_ommatidia in its analysis_tools.py: clusters have labels above 0; 0 and -1 are
        # points that are of none.
        noise = table.numbers("label") <= 0
        if noise.all():
            raise Error(f"{name}: expected labels above 0, found only those of noise")
        if noise.any():
            table.drop(noise)
            notes.append(
                f"Left out: {int(noise.sum())} rows of points that belong to no ommatidium (label "
                "0 or less)."
            )
    position = np.stack([table.numbers(column) for column in names], axis=1) * metres
    if not np.isfinite(position).all():
        raise Error(f"{name}: expected a position for every ommatidium, found nan")
    inward = _inward_axes(table, position, axis, notes)
    diameter = None
    if "lens_diameter" in table.columns:
        diameter = table.numbers("lens_diameter") * metres
    elif "lens_area" in table.columns:
        diameter = 2 * np.sqrt(table.numbers("lens_area") / np.pi) * metres
    used = {*names, *ODA_AXES.values(), "lens_diameter"}
    columns = {c: table.extra(c) for c in table.columns if c and c not in used}
    tell("measuring neighbours", None)
    head_from_scan = _rotation(ahead, up)
    eye = Eye(
        position @ head_from_scan.T,
        -inward @ head_from_scan.T,
        0.0 if acceptance_angle_rad is None else acceptance_angle_rad,
        columns=columns,
    )
    eye = _with_facets(eye, diameter, notes, name)
    if acceptance_angle_rad is None:
        eye = _with_assumed_acceptance(eye, acceptance_ratio, notes)
    return ImportedEye(eye, tuple(notes))


@checked
def import_lens_cone(
    lenses: PathLike | ArrayLike,
    cones: PathLike | ArrayLike,
    unit: str | float | None = None,
    *,
    allow_unmatched: bool = False,
    acceptance_ratio: float = 1.0,
    acceptance_angle_rad: ArrayLike | None = None,
    ahead: ArrayLike = (0, 0, -1),
    up: ArrayLike = (0, 1, 0),
    progress: Stage | None = None,
) -> LensConeEye:
    """An eye, or both of a head, from the lenses and the tips of the crystalline cones marked in a
    scan, in any order.

    Axes point from the tip to the lens, positions are the lenses, facet diameters come from the
    distances between them. Each lens gets one tip. The nearest one can be a neighbour's where
    ommatidia are skewed, so where the tips lie is first described by a smooth map of where the
    lenses lie (a polynomial of second order, fitted and matched in turn), and lenses and tips are
    matched one to one with the least sum of squared distances under that map.

    Points of both eyes of a head, apart from each other by more than four times their spacing, are
    matched eye by eye; ``eye_id`` is then 0 for the left eye and 1 for the right one, which ``up``
    and ``ahead`` tell apart. The origin stays that of the scan; where it is off the midline of
    both eyes, a note says by how much, as skew from the head's centre is measured from there.

    Args:
        lenses, cones: (N, 3) points, or text files with a point a line: columns x, y, z, which a
            header may name, what Imaris exports as positions (Position X, Position Y, Position Z,
            Unit, with or without the title above), or what napari saves of points in three
            dimensions (axis-0, axis-1, axis-2, which are z, y, x). Commas, semicolons, tabs or
            spaces are between the numbers; decimals may have commas where those are not.
        unit: "um", "mm", "m" or a number of metres; it goes before what a file says. None takes
            the unit that each file says, in a column Unit or behind the names (x_mm), else "um".
        allow_unmatched: as many lenses as cones are expected, in each eye. With this the points
            left over are reported in the result instead of being an error.
        acceptance_ratio, acceptance_angle_rad, ahead, up, progress: as in `import_oda`.

    Raises:
        omma.Error: a file cannot be read, there are fewer than 12 points, or not as many lenses as
            cones; points in more than two groups, or in two that are not left and right of each
            other: the error says what to do. Lenses and cones that are swapped: the axes of an eye
            point into the head and come together there. Where only one of the two holds, a note
            says so, and nothing is turned round.

    Warns:
        UserWarning: numbers that no animal has, mostly of another unit than ``unit``.
    """
    from scipy.spatial import cKDTree

    metres = None if unit is None else metres_per_unit(unit)
    tell = progress or (lambda stage, fraction: None)
    tell("reading the scan", None)
    lens = read_points(lenses, "lenses", metres)
    cone = read_points(cones, "cones", metres)
    head_from_scan = _rotation(ahead, up)
    lens_eye, cone_eye = split_eyes(lens, cone, head_from_scan[0])
    two = bool(lens_eye.any())
    pairs = []
    eyes = 2 if two else 1

    def matched(one: int, done: float) -> None:
        tell("matching lenses and cones", (one + done) / eyes)

    for one in range(eyes):
        members, tips = np.flatnonzero(lens_eye == one), np.flatnonzero(cone_eye == one)
        if len(members) != len(tips) and not allow_unmatched:
            raise Error(
                f"lenses and cones{(' of the left eye', ' of the right eye')[one] if two else ''}: "
                f"expected as many of each, found {len(members)} and {len(tips)}; "
                "allow_unmatched leaves out those without a partner"
            )
        matched_lens, matched_cone, missed = match_tips(
            lens[members],
            cone[tips],
            partial(matched, one),
        )
        apart = cKDTree(cone[tips]).query(cone[tips[matched_cone]], k=2)[0][:, 1]
        pairs.append((members[matched_lens], tips[matched_cone], missed, missed > apart / 2))
    which_lens, which_cone, misfit, doubtful = (
        np.concatenate(part)[np.argsort(np.concatenate([pair[0] for pair in pairs]))]
        for part in zip(*pairs, strict=True)
    )
    lens_position, tip = lens[which_lens], cone[which_cone]
    direction = lens_position - tip
    distance = np.linalg.norm(direction, axis=1)
    if (distance == 0).any():
        at = which_lens[np.argmin(distance)]
        raise Error(
            f"lens {at}: expected a cone's tip apart from it, found one at the same position"
        )
    notes = [
        f"Matched {len(distance):,} lenses and cones, {_spread(distance)} apart; tips are "
        f"{_spread(misfit)} from where their neighbours' say they should be."
    ]
    eye_id = lens_eye[which_lens]
    for one in range(eyes):
        members = eye_id == one
        of_eye = ("of the left eye ", "of the right eye ")[one] if two else ""
        notes += checked_outward(lens_position[members], tip[members], of_eye)
    if two:
        left, right = np.bincount(eye_id)
        notes.append(
            f"Two eyes that lie apart: {left:,} ommatidia of the left one (eye_id 0) and {right:,} "
            "of the right one (eye_id 1), as ahead and up say."
        )
    if doubtful.any():
        note = f"Doubtful: {int(doubtful.sum())} pairs, where another tip would fit as well"
        if doubtful.mean() > 0.05:
            # The map of one eye leaves hardly any, that of two eyes taken for one every sixth.
            note += (
                ": too many for marks of one eye. If they are of two eyes that touch, import each "
                "from points of its own and join them with merge_eyes"
            )
        notes.append(note + ".")
    left_lenses = np.setdiff1d(np.arange(len(lens)), which_lens)
    left_cones = np.setdiff1d(np.arange(len(cone)), which_cone)
    if len(left_lenses) or len(left_cones):
        notes.append(f"Left out: {len(left_lenses)} lenses and {len(left_cones)} cones.")
    tell("measuring neighbours", None)
    eye = Eye(
        lens_position @ head_from_scan.T,
        direction @ head_from_scan.T,
        0.0 if acceptance_angle_rad is None else acceptance_angle_rad,
        eye_id=eye_id,
        columns={
            "lens_to_cone_um": distance * 1e6,
            "misfit_um": misfit * 1e6,
            "doubtful": doubtful.astype(np.float64),
        },
    )
    if two:
        notes += off_the_midline(eye)
    name = os.fsdecode(lenses) if isinstance(lenses, (str, os.PathLike)) else "lenses and cones"
    eye = _with_facets(eye, None, notes, name)
    if acceptance_angle_rad is None:
        eye = _with_assumed_acceptance(eye, acceptance_ratio, notes)
    return LensConeEye(
        eye,
        tuple(notes),
        which_lens,
        which_cone,
        distance,
        misfit,
        doubtful,
        left_lenses,
        left_cones,
    )


def _spread(lengths_m: Floats) -> str:
    low, middle, high = np.percentile(lengths_m * 1e6, [0, 50, 100])
    return f"{low:.3g} to {high:.3g} µm (median {middle:.3g})"


def _inward_axes(table: ScanTable, position: Floats, axis: str, notes: list[str]) -> Floats:
    """Directions that point into the eye, of ODA's two kinds."""
    kinds = {
        kind: table.vectors(column) for kind, column in ODA_AXES.items() if column in table.columns
    }
    other = "approx" if axis == "anatomical" else "anatomical"
    chosen = kinds.get(axis, np.full_like(position, np.nan))
    missing = np.asarray(~np.isfinite(chosen).all(axis=1))
    if missing.any():
        if other in kinds:
            chosen = np.where(missing[:, None], kinds[other], chosen)
        notes.append(
            f"Assumed: {int(missing.sum())} ommatidia without an {ODA_AXES[axis]} look along their "
            f"{ODA_AXES[other]}."
        )
    size = np.linalg.norm(chosen, axis=1, keepdims=True)
    bad = np.asarray(~(np.isfinite(size[:, 0]) & (size[:, 0] > 0)))
    if bad.any():
        raise Error(f"{table.name}, line {table.lines[int(np.flatnonzero(bad)[0])]}: has no axis")
    chosen = chosen / size
    # ODA turns them towards the centre of the sphere fitted to the eye, its origin; the forerunner
    # leaves the anatomical one as it comes.
    centre = sphere_centre(position)
    towards = centre - position
    if "approx" in kinds:
        approx = kinds["approx"]
        towards = np.where(np.isfinite(approx).all(axis=1, keepdims=True), approx, towards)
    turned = (chosen * towards).sum(axis=1) < 0
    if turned.any():
        notes.append(f"Turned round: {int(turned.sum())} axes that point out of the eye.")
    return np.asarray(np.where(turned[:, None], -chosen, chosen))


def _rotation(ahead: ArrayLike, up: ArrayLike) -> Floats:
    """(3, 3), head from scan."""
    vectors = []
    for name, value in (("ahead", ahead), ("up", up)):
        vector = array_of(value, name)
        if vector.shape != (3,) or not np.isfinite(vector).all() or not np.linalg.norm(vector) > 0:
            raise Error(f"{name}: expected three numbers that are not all 0, found {value!r}")
        vectors.append(vector / np.linalg.norm(vector))
    front, top = vectors
    right = np.cross(front, top)
    if not np.linalg.norm(right) > 1e-6:
        raise Error(f"up: expected a direction across ahead, found {up!r}")
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, front), -front])


def _with_facets(eye: Eye, diameter_m: Floats | None, notes: list[str], name: str) -> Eye:
    """The eye with facets of these diameters, or as wide as neighbours are apart."""
    spacing = facet_diameters_m(eye)
    if diameter_m is None:
        diameter_m = spacing
        notes.append("Facet diameters are the mean distances to the neighbours.")
    else:
        unknown = ~(np.isfinite(diameter_m) & (diameter_m > 0))
        diameter_m = np.where(unknown, spacing, diameter_m)
        if unknown.any():
            notes.append(f"Facet diameters of {int(unknown.sum())} ommatidia are from distances.")
    return made_told(eye.replace(facet_diameter_m=diameter_m), name)


def _with_assumed_acceptance(eye: Eye, ratio: float, notes: list[str]) -> Eye:
    notes.append(f"Assumed: acceptance angles are {ratio:g} times the interommatidial angle.")
    return set_acceptance(eye, ratio=ratio)
