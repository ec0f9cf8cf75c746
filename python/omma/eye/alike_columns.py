"""Columns of eyes' CSV files whose names look like what is read, under names that are not: they are
kept as extra columns, and the eye goes without.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

_LENGTH = r"(_?(nm|um|microns?|micromet(er|re)s?|mm|cm|m|met(er|re)s?))?"
_ANGLE = r"(_?(deg(rees?)?|rad(ians?)?))?"
_OF_FACET = r"((facet|lens|cornea|corneal|ommatidium|ommatidial|ommatidia)_?)"
_POSITION = (
    rf"({_OF_FACET}|(pos|position|coord|coordinates?|loc|location|cent(er|re|roid)|nodal_point)_?)?"
)
_DIRECTION = r"(optical_)?(axis|dir|direction|normal|view|viewing|viewing_direction|n|d)_?"


@dataclass(frozen=True)
class _Alike:
    """A quantity, names that look like it, and how its columns are called."""

    what: str
    pattern: str  # of a whole name as `_plain` writes it
    read: str  # the beginning of the names that are read
    called: str
    least: int = 1  # columns of such names that are no coincidence


# Names are assumed: what people call these, in tables and papers.
_OPTIONAL = (
    _Alike("positions", rf"{_POSITION}[xyz]{_LENGTH}", "position_",
           "position_x_um, position_y_um, position_z_um (or _mm, _m)", 2),
    _Alike("acceptance angles",
           rf"(acceptance(_angles?)?|delta_?rho|d_?rho|fwhm|half_?widths?){_ANGLE}",
           "acceptance_angle_", "acceptance_angle_deg (or _rad)"),
    _Alike("facet diameters", rf"({_OF_FACET}?diam(eters?)?|(facet|lens)_(size|width)s?){_LENGTH}",
           "facet_diameter_", "facet_diameter_um (or _mm, _m)"),
    _Alike("apertures", rf"(aperture|pupil)s?(_diam(eters?)?)?{_LENGTH}", "aperture_diameter_",
           "aperture_diameter_um (or _mm, _m)"),
    _Alike("numbers of eyes", r"(eye|side|which_eye|eye_(side|number|nr|no))", "eye_id",
           "eye_id (0, 1, ...)"),
)  # fmt: skip
_AXES = (_Alike("axes", rf"{_DIRECTION}[xyz]", "axis_", "axis_x, axis_y, axis_z", 2),)
_ANGLES = (
    _Alike("azimuths", rf"(az|azim|azimuth|lon|longitude){_ANGLE}", "azimuth_",
           "azimuth_deg (or _rad)"),
    _Alike("elevations", rf"(el|elev|elevation|lat|latitude){_ANGLE}", "elevation_",
           "elevation_deg (or _rad)"),
)  # fmt: skip
_ACCEPTANCE = _OPTIONAL[1:2]


def left_unread(names: Sequence[str]) -> list[str]:
    """A sentence for each quantity that a table lacks and that columns of it look like."""
    return [
        f"{'columns' if len(alike) > 1 else 'column'} {', '.join(alike)} not read: "
        f"{'they look' if len(alike) > 1 else 'it looks'} like {kind.what}, of which the table has "
        f"none; call {'them' if len(alike) > 1 else 'it'} {kind.called}, or column:{alike[0]} "
        "where something else is meant"
        for kind, alike in _found(names, _OPTIONAL)
    ]


def instead_of_needed(names: Sequence[str]) -> str:
    """Which columns look like those that an eye must have, for the end of an error; or ""."""
    needed: tuple[_Alike, ...] = _ACCEPTANCE
    if not _reads_any(names, _ANGLES):
        needed = _AXES + needed
    if not _reads_any(names, _AXES):
        needed = _ANGLES + needed
    return "".join(
        f"; {', '.join(alike)} may be its {kind.what}: {kind.called}"
        for kind, alike in _found(names, needed)
    )


def _reads_any(names: Sequence[str], kinds: Sequence[_Alike]) -> bool:
    return any(name.startswith(kind.read) for kind in kinds for name in names)


def _found(names: Sequence[str], kinds: Sequence[_Alike]) -> list[tuple[_Alike, list[str]]]:
    found = []
    for kind in kinds:
        if any(name.startswith(kind.read) for name in names):
            continue
        alike = [name for name in names if re.fullmatch(kind.pattern, _plain(name))]
        if len(alike) >= kind.least:
            found.append((kind, alike))
    return found


def _plain(name: str) -> str:
    """In small letters, with one underscore for whatever separates words."""
    plain = name.lower().replace("\u00b5", "u").replace("\u03bc", "u").replace("δ", "delta_")
    return re.sub(r"[\s_.()\[\]/-]+", "_", plain.replace("ρ", "rho")).strip("_")
