"""Eyes from files and into them (docs/eyes.md)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from omma import _core
from omma._core import Error, Eye
from omma.base.addresses import expect_local
from omma.base.arguments import checked, one_of
from omma.base.files import PathLike, metres_per_unit
from omma.base.warn import warn_caller
from omma.eye.csv_files import MISSING_ACCEPTANCE, load_csv

# Kinds of angular sensitivity whose width is compared with what an eye states.
_MOST_KINDS = 8

# Files of the Open Compound Eye Standard.
OCES_SUFFIXES = (".gltf", ".glb")
# Files that eyes are written to.
EYE_SUFFIXES = (".csv", *OCES_SUFFIXES, ".eye")


@checked
def load_eye(
    path: PathLike,
    unit: str | float = "mm",
    *,
    head: str | int | None = None,
    missing_acceptance: str = "refuse",
) -> Eye:
    """Read an eye; the ending of the name says which format it is (docs/eyes.md).

    `.csv`: a line for each ommatidium, columns with names that say the unit; it keeps everything.
    Commas, semicolons or tabs are between the cells, by the header; decimals may have commas where
    these are not.
    `.gltf`, `.glb`: the Open Compound Eye Standard (glTF extension ``OCES_eyes``), with everything
    that Omma wrote. Anything else is an `.eye` file: position x y z, axis x y z, acceptance angle
    (rad), focal offset; spaces, tabs or commas; comments from ``#``; its frame is x right, y up, z
    forward, while `Eye` has forward along -Z.

    Args:
        unit: unit of lengths in an `.eye` file: "mm", "um", "m" or a number of metres. The other
            formats say theirs themselves.
        head: name or number of the head whose eyes are meant, where an OCES file has several.
        missing_acceptance: what becomes of ommatidia of a `.csv` file that have neither an
            acceptance angle (the cell is empty, NaN, NA, none or null, or there is no such column)
            nor a kernel: "refuse" them; "neighbours", the mean of the six with an acceptance angle,
            of the same eye, that look nearest; or "interommatidial", the mean angle to the (up to)
            six nearest axes of the same eye, which a table without any acceptance angles needs.
            Neither is a measurement. `set_acceptance` sets others.

    Raises:
        omma.Error: the file is missing or wrong; it names the file and says where in it.

    Warns:
        UserWarning: numbers that no animal has, mostly in another unit; acceptance angles of 0
            beside others; columns of a `.csv` file that look like positions, facet diameters or the
            like and have other names than those that are read; how many acceptance angles were
            filled, and by what.
    """
    metres = metres_per_unit(unit)
    if head is not None and Path(os.fsdecode(path)).suffix.lower() not in OCES_SUFFIXES:
        raise Error(f"{os.fsdecode(path)}: only .gltf and .glb files have heads to choose from")
    one_of(missing_acceptance, MISSING_ACCEPTANCE, "missing_acceptance")
    if _is_csv(path):
        eye = load_csv(path, missing_acceptance)
    elif missing_acceptance != "refuse":
        raise Error(f"{os.fsdecode(path)}: only .csv files can have gaps in acceptance angles")
    else:
        eye = _core.load_eye(path, metres, "" if head is None else str(head))
    warn_of_unusual(eye)
    return eye


def load_without_acceptance(path: PathLike, unit: str | float) -> Eye:
    """The eye of a file whose acceptance angles are to be replaced: those that a `.csv` file lacks
    are 0, and nothing is told of any."""
    if not _is_csv(path):
        return load_eye(path, unit)
    return made_told(load_csv(path, "0"), os.fsdecode(path))


def _is_csv(path: PathLike) -> bool:
    return Path(os.fsdecode(path)).suffix.lower() == ".csv"


def load_head(paths: Sequence[PathLike], unit: str | float = "mm") -> Eye:
    """The eye of a file, or one head of the eyes of several."""
    eyes = [load_eye(path, unit) for path in paths]
    return eyes[0] if len(eyes) == 1 else _core.merge_eyes(eyes)


def warn_of_unusual(eye: Eye, name: str = "") -> None:
    """Tell the caller of the package which numbers of an eye no animal has: slips of units,
    mostly. ``name`` is what it is called; by default its file's."""
    for sentence in slips_in(eye):
        warn_caller(f"{name or eye.path or 'eye'}: {sentence}", UserWarning)


def slips_in(eye: Eye) -> list[str]:
    """Sentences about numbers of an eye that cannot be meant, mostly."""
    return [
        *_core.unusual_of(eye),
        *_without_width(eye),
        *_other_width(eye),
        *_radians_as_degrees(eye),
        *_axes_in_radians(eye),
    ]


def _other_width(eye: Eye) -> list[str]:
    """What there is to tell of acceptance angles that are not the width of the angular sensitivity
    beside them: of a few kinds, as a waveguide's width takes a while."""
    kinds, first = np.unique(eye.acceptance_of, return_index=True)
    for ommatidium in first[kinds >= 0][:_MOST_KINDS].tolist():
        acceptance = eye.acceptance(ommatidium)
        stated = float(eye.acceptance_angle_rad[ommatidium])
        azimuths = [0.0] if acceptance.is_round else np.linspace(0, np.pi, 9)
        widths = [acceptance.width_rad(azimuth) for azimuth in azimuths]
        if stated <= 0 or min(widths) / 1.05 <= stated <= max(widths) * 1.05:
            continue
        return [
            f"the acceptance angle of ommatidium {ommatidium} is {np.degrees(stated):.3g}°, its "
            f"angular sensitivity ({acceptance.kernel}) is {np.degrees(max(widths)):.3g}° wide: "
            "responses are by the second, what is measured of the eye by the first"
        ]
    return []


def made_told(eye: Eye, name: str) -> Eye:
    """The eye, which is made of what ``name`` says; the caller of the package is told which of its
    numbers no animal has."""
    for sentence in _core.unusual_of(eye):
        warn_caller(f"{name}: {sentence}", UserWarning)
    return eye


def changed_told(before: Eye, changed: Eye) -> Eye:
    """The changed eye; the caller of the package is told which of its numbers no animal has, as
    where an eye is made, but for those that it had before."""
    known = slips_in(before)
    for sentence in slips_in(changed):
        if sentence not in known:
            warn_caller(f"{changed.path or 'eye'}: {sentence}", UserWarning)
    return changed


def _without_width(eye: Eye) -> list[str]:
    """What there is to tell of acceptance angles of 0 beside others, which are gaps of a table,
    mostly. Where all are 0, rays are meant."""
    none = (eye.acceptance_angle_rad == 0) & (eye.acceptance_of < 0)
    if not none.any() or none.all():
        return []
    return [
        f"the acceptance angle of {np.count_nonzero(none):,} of {len(eye):,} ommatidia is 0, that "
        f"of number {none.argmax()} first: each is one ray without width, which catches no photons"
    ]


def _radians_as_degrees(eye: Eye) -> list[str]:
    """What there is to tell of acceptance angles below those of any animal (0.24 degrees, of
    dragonflies: Land 1997, Annu Rev Entomol 42:147) that as radians would fit between ommatidia."""
    stated = eye.acceptance_angle_rad[(eye.acceptance_angle_rad > 0) & (eye.acceptance_of < 0)]
    apart = eye.interommatidial_angle_rad()
    apart = apart[np.isfinite(apart) & (apart > 0)]
    if not (len(stated) and len(apart)):
        return []
    width_deg, apart_deg = np.degrees(np.median(stated)), np.degrees(np.median(apart))
    meant_deg = np.degrees(width_deg)
    if not (width_deg < 0.2 and 0.2 < meant_deg / apart_deg < 5):
        return []
    return [
        f"acceptance angles are about {width_deg:.2g}°, less than any animal's, and ommatidia "
        f"{apart_deg:.2g}° apart; {width_deg:.2g} rad would be {meant_deg:.2g}°"
    ]


def _axes_in_radians(eye: Eye) -> list[str]:
    """What there is to tell of many axes within 3.2 degrees of ahead that lie so near to each other
    as no animal's do beside its acceptance angles: azimuths and elevations were radians. And of
    such whose acceptance angles are below those of any animal (`_radians_as_degrees`): all were."""
    if len(eye) < 20:
        return []
    azimuth_deg = np.degrees(np.arctan2(eye.axis[:, 0], -eye.axis[:, 2]))
    elevation_deg = np.degrees(np.arcsin(np.clip(eye.axis[:, 1], -1, 1)))
    farthest_deg = float(max(np.abs(azimuth_deg).max(), np.abs(elevation_deg).max()))
    if np.abs(azimuth_deg).max() > 3.2 or np.abs(elevation_deg).max() > 1.6:
        return []
    apart_deg = float(np.degrees(np.median(eye.interommatidial_angle_rad())))
    width_deg = float(np.degrees(np.median(eye.acceptance_angle_rad)))
    if not (apart_deg > 0 and farthest_deg > 0.5):
        return []
    if 0 < width_deg < 0.2:
        return [
            f"all axes lie within {farthest_deg:.2g}° of ahead, and acceptance angles are about "
            f"{width_deg:.2g}°, less than any animal's: all may be radians under names of degrees"
        ]
    if width_deg <= 8 * apart_deg:
        return []
    return [
        f"all axes lie within {farthest_deg:.2g}° of ahead, {apart_deg:.2g}° apart, and acceptance "
        f"angles are {width_deg / apart_deg:.2g} times as wide: azimuths and elevations may be "
        "radians under names of degrees"
    ]


@checked
def eye_file_heads(path: PathLike) -> list[str]:
    """The names of the heads in an OCES file (`.gltf`, `.glb`) that are enabled; none where a glTF
    file has no eyes.

    Raises:
        omma.Error: the file is missing or wrong.
    """
    return _core.eye_file_heads(path)


@checked
def save_eye(path: PathLike, eye: Eye, unit: str | float = "mm", *, lossy: bool = False) -> None:
    """Write an eye, in the format that the ending of the name says; `load_eye` reads it back.

    `.csv`, `.gltf` and `.glb` keep everything, to the last bit. An `.eye` file, with lengths in
    ``unit``, holds position, axis, acceptance angle and focal offset only.

    Args:
        lossy: write an `.eye` file although the eye has more than it can hold, which is then lost.
            `eye_file_losses` says what.

    Raises:
        omma.Error: another ending; the file cannot be written; it cannot hold all of the eye and
            ``lossy`` is not said: the error names what would be lost.

    Warns:
        UserWarning: for each thing that is lost.
    """
    _core.save_eye(expect_local(path, "an eye"), eye, metres_per_unit(unit), lossy)
    for loss in eye_file_losses(path, eye):
        warn_caller(f"{os.fsdecode(path)}: lost: {loss}", UserWarning)


@checked
def eye_file_losses(path: PathLike, eye: Eye) -> list[str]:
    """What of an eye a file of that name cannot hold, a few words each; empty where all is
    kept.
    """
    return _core.eye_file_losses(path, eye)
