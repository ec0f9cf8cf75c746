"""Tracks: where an animal walked, in the plane, as tracking gives it."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Floats
from omma.base.tables import read_table
from omma.base.values import value_class

_TIME, _PLACE, _HEADING = ("t_s",), ("x_m", "z_m"), ("heading_deg",)
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
        for name, values in given.items():
            object.__setattr__(self, name, values)
        if len(given["xz_m"]) == 0:
            raise Error("xz_m: expected a position or more, found none")
        if self.times_s is not None and not (np.diff(self.times_s) > 0).all():
            row = int(np.flatnonzero(np.diff(self.times_s) <= 0)[0]) + 1
            raise Error(
                f"times_s: expected times that grow, found {self.times_s[row]:g} in row {row}"
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
        heading = self.heading_deg
        if heading is not None:
            heading = np.interp(asked, known, np.unwrap(heading, period=360))
        return Track(_between(asked, known, self.xz_m), heading, times_s)


@checked
def load_track(path: str | os.PathLike[str]) -> Track:
    """A track from a CSV file, one position a line.

    The first line names the columns: ``x_m,z_m``, with ``t_s``, ``heading_deg`` or both, in any
    order; semicolons and tabs may separate them, decimals have points or commas then. Empty lines,
    and what follows a ``#``, are passed over; rows of frames without a position must be left out.

    Raises:
        omma.Error: the file cannot be read, or a line is wrong; it names the line.
    """
    name = os.fsdecode(path)
    headers = [(*time, *_PLACE, *heading) for time in (_TIME, ()) for heading in ((), _HEADING)]
    columns, table, _ = read_table(path, headers, "position")
    of = dict(zip(columns, table.T, strict=True))
    try:
        return Track(np.column_stack([of["x_m"], of["z_m"]]), of.get("heading_deg"), of.get("t_s"))
    except Error as error:
        raise Error(f"{name}: {error}") from None


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
