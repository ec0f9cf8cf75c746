"""Tracks: where an animal walked, in the plane, as tracking gives it."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, one_of, positive
from omma.base.arrays import Floats
from omma.base.poses import warn_of_radians
from omma.base.tables import HEADINGS, TIMES, check_growing, read_table, say_units, stems_of
from omma.base.values import value_class
from omma.base.warn import warn_caller

# What becomes of frames in which a tracker lost the animal.
LOST = ("refuse", "leave_out")

_TIME, _PLACE, _HEADING = ("t_s",), ("x_m", "z_m"), ("heading_deg",)
_ANIMALS = {"id", "identity", "animal", "individual", "track"}
# Gaps between positions that are told, s, and how many of them.
_GAP_S, _MOST_NAMED = 1.0, 5
# Least growth of a whole number of steps by which a last one still counts.
_LAST = 1e-9


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Track:
    """Positions in the plane, one after another, for `walk_on`.

    Example:
        >>> track = omma.motion.Track(np.array([(0, 0), (0, -1), (1, -1)]))
        >>> len(track.at_speed(0.05, step_s=0.1).xz_m)
        401

    Raises:
        omma.Error: other shapes, numbers that are not finite, times that do not grow.

    Warns:
        UserWarning: the headings look like radians.
    """

    xz_m: Floats
    """(P, 2), m, the world's x and z."""
    heading_deg: Floats | None = None
    """(P,), yaw: 0 looks along -Z, 90 along +X. None: along the track."""
    times_s: Floats | None = None
    """(P,), s, growing. None: not known."""

    def __post_init__(self) -> None:
        given = {"xz_m": array_of(self.xz_m, "xz_m", (None, 2), finite=True)}
        for name in ("heading_deg", "times_s"):
            if getattr(self, name) is not None:
                given[name] = array_of(
                    getattr(self, name), name, (len(given["xz_m"]),), finite=True
                )
        if "heading_deg" in given:
            warn_of_radians(given["heading_deg"][:, None], "heading_deg")
        for name, values in given.items():
            object.__setattr__(self, name, values)
        if len(given["xz_m"]) == 0:
            raise Error("xz_m: expected a position or more, found none")
        if self.times_s is not None and not (np.diff(self.times_s) > 0).all():
            row = int(np.flatnonzero(np.diff(self.times_s) <= 0)[0]) + 1
            raise Error(
                f"times_s: expected times that grow, found times_s[{row}] {self.times_s[row]:.10g} "
                f"after {self.times_s[row - 1]:.10g}"
            )

    @checked
    def every(self, step_s: float) -> Track:
        """The same walk at equal steps of time, straight and at an even speed between positions.

        Raises:
            omma.Error: its times are not known.
        """
        if self.times_s is None:
            raise Error("times_s: expected a track with times; at_speed gives it some")
        step = positive(step_s, "step_s")
        first, last = self.times_s[[0, -1]]
        times = first + step * np.arange(int((last - first) / step + _LAST) + 1)
        return self._at(self.times_s, times, times)

    @checked
    def at_speed(self, speed_m_s: float, *, step_s: float) -> Track:
        """The same way walked at one speed, m/s, at equal steps of time from 0 on."""
        step, arc = positive(step_s, "step_s"), _arc(self.xz_m)
        stride = positive(speed_m_s, "speed_m_s") * step
        steps = np.arange(int(arc[-1] / stride + _LAST) + 1, dtype=np.float64)
        return self._at(arc, stride * steps, step * steps)

    def _at(self, known: Floats, asked: Floats, times_s: Floats) -> Track:
        track = Track(_between(asked, known, self.xz_m), None, times_s)
        if self.heading_deg is not None:  # what is odd about these was told when they were given
            heading = np.interp(asked, known, np.unwrap(self.heading_deg, period=360))
            object.__setattr__(track, "heading_deg", heading)
        return track


@checked
def load_track(path: str | os.PathLike[str], *, lost: str = "refuse") -> Track:
    """A track from a CSV file, one position a line.

    The first line names the columns: ``x_m,z_m``, with ``t_s``, ``heading_deg`` or both, in any
    order; semicolons and tabs may separate them, decimals have points or commas then. Empty lines,
    and what follows a ``#``, are passed over.

    Args:
        lost: what becomes of the lines of frames in which a tracker lost the animal, of which a
            cell is empty, NaN, NA, none or null: "refuse" them, or "leave_out", so that the animal
            goes straight from where it was last seen to where it is seen again.

    Raises:
        omma.Error: the file cannot be read, or a line is wrong; it names the line.

    Warns:
        UserWarning: lines were left out: how many, and where that leaves more than a second
            without a position; headings that look like radians.
    """
    name = os.fsdecode(path)
    one_of(lost, LOST, "lost")
    headers = [(*time, *_PLACE, *heading) for time in (_TIME, ()) for heading in ((), _HEADING)]
    columns, table, numbers = read_table(path, headers, "position", missing=True, remedy=_remedy)
    lines = np.asarray(numbers)
    known = np.asarray(np.isfinite(table).all(axis=1))
    if lost == "refuse" and not known.all():
        row = int(np.argmin(known))
        raise Error(
            f"{name}, line {lines[row]}, column {columns[int(np.isnan(table[row]).argmax())]}: "
            f"expected a finite number, found none; {np.sum(~known)} of {len(known)} positions "
            'lack one: lost="leave_out" leaves out frames in which the animal was lost'
        )
    if not known.any():
        raise Error(f"{name}: holds no position: each line lacks a number")
    times_s = dict(zip(columns, table.T, strict=True)).get("t_s")
    if times_s is not None:
        check_growing(name, times_s[known], lines[known])
    if not known.all():
        warn_caller(f"{name}: {_left_out(known, lines, times_s)}", UserWarning)
    of = dict(zip(columns, table[known].T, strict=True))
    return Track(np.column_stack([of["x_m"], of["z_m"]]), of.get("heading_deg"), of.get("t_s"))


def _remedy(columns: tuple[str, ...]) -> str:
    """What to do about a file whose columns are others: those of GPS loggers, maps and trackers in
    three dimensions."""
    stems, whole = stems_of(columns), {*_PLACE} <= {*columns}
    units = {one: "t_s" for one in TIMES} | {"x": "x_m", "z": "z_m"}
    units |= {one: "heading_deg" for one in HEADINGS}
    said = []
    if not whole and any(one.startswith(("lat", "east", "north")) for one in stems):
        del units["z"]
        if any(one.startswith("lat") for one in stems):
            said.append("project latitude and longitude to metres first, as to UTM")
        said.append("x_m is the easting and z_m the northing's negative, in metres")
    elif "y" in stems and "z" in stems:
        del units["z"]
        said.append(_which_is_height(stems["y"], stems["z"]))
    elif "y" in stems:
        y = stems["y"]
        said.append(
            f"z_m leads south: it is {y}, in metres, where that grows downwards, as in videos from "
            "above, and its negative where it grows northwards, as on maps"
        )
    other = say_units(columns, units)
    if other:
        said.append(other)
    frame = stems.get("frame") or stems.get("frames")
    if frame and not {*stems} & {*TIMES}:
        said.append(f"t_s is {frame} divided by the frames of a second")
    many = _of_many_animals(columns)
    if many:
        said.append(f"a track is of one animal: one file for each, of {', '.join(many)}")
    more = [one for one in columns if one not in (*_TIME, *_PLACE, *_HEADING)]
    if whole and more and not said:
        said.append(f"leave out {', '.join(more)}")
    return "; ".join(said)


def _of_many_animals(columns: tuple[str, ...]) -> list[str]:
    """Columns that tell animals apart: their names, or x of each of them."""
    names = [one for one in columns if one.removesuffix("_id") in _ANIMALS]
    numbered = [one for one in columns if re.fullmatch(r"x_?\d+(_\w+)?", one)]
    return names or (numbered if len(numbered) > 1 else [])


def _which_is_height(y: str, z: str) -> str:
    """What z_m is of a track that has y and z, either of which may be the height."""
    return (
        f"z_m is horizontal, in metres south of the origin: where {z} is height, z_m is the "
        f"negative of {y}, and the height is left out; where {y} is height, leave it out"
        + ("" if z == "z_m" else f", and z_m is {z}")
    )


def _left_out(known: NDArray[np.bool_], lines: NDArray[np.int64], times_s: Floats | None) -> str:
    """What was left out of a track, in words."""
    text = f"left out {np.sum(~known)} of {len(known)} positions, which lack a number"
    kept = np.flatnonzero(known)
    text += _at_ends(kept, len(known))
    after = np.flatnonzero(np.diff(kept) > 1)
    if times_s is None:
        runs = np.diff(kept)[after] - 1
        longest = f"; without t_s, at most {runs.max()} in a row" if len(runs) > 0 else ""
        return text + longest
    wide = [one for one in after if times_s[kept[one + 1]] - times_s[kept[one]] > _GAP_S]
    gaps = [
        f"lines {lines[kept[one]]} to {lines[kept[one + 1]]} "
        f"({times_s[kept[one + 1]] - times_s[kept[one]]:.3g} s)"
        for one in wide[:_MOST_NAMED]
    ]
    if not gaps:
        return text
    more = f" and {len(wide) - len(gaps)} more" if len(wide) > len(gaps) else ""
    return f"{text}; more than {_GAP_S:g} s without a position: {', '.join(gaps)}{more}"


def _at_ends(kept: NDArray[np.int64], count: int) -> str:
    """How many of the lines that were left out are before the first that is kept, or after the
    last."""
    ends = ((int(kept[0]), "first"), (count - 1 - int(kept[-1]), "last"))
    said = [f"the {which} {number}" for number, which in ends if number > 0]
    return f", {' and '.join(said)} among them" if said else ""


def heading_along(xz_m: Floats, chord_m: float) -> Floats:
    """(P,), degrees: which way a track (P, 2) goes, by chords of so much of its length around each
    position; where that has no length, as on standing still, as it went before."""
    arc = _arc(xz_m)
    ends = [_between(arc + side * chord_m / 2, arc, xz_m) for side in (-1, 1)]
    way = ends[1] - ends[0]
    goes = np.hypot(*way.T) > 1e-9 * chord_m
    if not goes.any():
        raise Error("track: expected positions that differ, or heading_deg")
    before = np.maximum.accumulate(np.where(goes, np.arange(len(way)), -1))
    x, z = way[np.where(before < 0, np.argmax(goes), before)].T
    return np.asarray(np.degrees(np.arctan2(x, -z)))


def _arc(xz_m: Floats) -> Floats:
    """(P,), m: how far along the track each position is."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(xz_m, axis=0).T))])


def _between(asked: Floats, known: Floats, xz_m: ArrayLike) -> Floats:
    x, z = np.asarray(xz_m).T
    return np.column_stack([np.interp(asked, known, x), np.interp(asked, known, z)])
