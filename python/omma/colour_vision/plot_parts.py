"""What figures of colours are made of: outlines and their corners, a spectrum locus, marks."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, as_named
from omma.base.arrays import Floats
from omma.base.figures import COLOURS, GREY, INK, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Wavelengths (W,), nm, and what monochromatic lights of them do to the classes (W, N).
Spectrum = tuple[ArrayLike, ArrayLike]

_MARKS = "os^Dvp"
MOST_MARKS = len(_MARKS) * len(COLOURS)
_TICK_NM = 50  # between the wavelengths that are written beside a spectrum locus
_BESIDE_NM = 5  # over which the direction of a locus is taken
# Of what any animal may see; micrometres and metres are far off.
_LEAST_NM, _MOST_NM = 100.0, 5000.0


def draw_locus(panel: Axes, wavelength_nm: Floats, points: Floats) -> None:
    """A line with dots and their wavelengths, nm."""
    from matplotlib.patheffects import withStroke

    panel.plot(*points.T, color=GREY, linewidth=0.9, zorder=2)
    first = math.ceil(wavelength_nm.min() / _TICK_NM) * _TICK_NM
    middle = points.mean(axis=0)
    last = np.full(2, np.inf)
    for wanted in np.arange(first, wavelength_nm.max() + 1, _TICK_NM):
        before, at, after = (
            np.array([np.interp(one, wavelength_nm, along) for along in points.T])
            for one in (wanted - _BESIDE_NM, wanted, wanted + _BESIDE_NM)
        )
        # At the ends of the spectrum one class alone catches, and loci fall together: each dot has
        # its number, so that none is read at another.
        if np.hypot(*(at - last)) < 0.12:
            continue
        last = at
        panel.plot(*at, "o", color=GREY, markersize=2, zorder=2)
        # Across the locus, on the side of its middle.
        x, y = after - before
        across = np.array([-y, x]) if np.hypot(x, y) > 1e-9 else middle - at
        across = across if across @ (middle - at) >= 0 else -across
        across = 7 * across / max(float(np.hypot(*across)), 1e-9)
        panel.annotate(
            f"{wanted:g}", tuple(at), tuple(across), textcoords="offset points", ha="center",
            va="center", color=GREY, fontsize="x-small",
            path_effects=[withStroke(linewidth=2, foreground="white")],
        )  # fmt: skip


def locus_of(
    spectrum: Spectrum | None, space: Callable[[ArrayLike], Floats]
) -> tuple[Floats, Floats] | None:
    """Wavelengths in order, and their loci (W, axes)."""
    if spectrum is None:
        return None
    if not isinstance(spectrum, tuple) or len(spectrum) != 2:
        raise Error("spectrum: expected two arrays, of wavelengths and of what they do")
    wavelength_nm = array_of(spectrum[0], "spectrum", (None,))
    if not np.all(np.isfinite(wavelength_nm)) or len(wavelength_nm) < 2:
        raise Error("spectrum: expected at least two wavelengths, finite numbers in nm")
    low, high = wavelength_nm.min(), wavelength_nm.max()
    if low < _LEAST_NM or high > _MOST_NM:
        raise Error(
            f"spectrum: expected wavelengths of {_LEAST_NM:g} to {_MOST_NM:g} nm, found {low:g} to "
            f"{high:g}"
        )
    with as_named(excited="spectrum", catches="spectrum"):
        points = space(spectrum[1])
    if points.ndim != 2 or len(points) != len(wavelength_nm):
        raise Error(
            f"spectrum: expected a row for each of {len(wavelength_nm)} wavelengths, found shape "
            f"{np.shape(spectrum[1])}"
        )
    order = np.argsort(wavelength_nm, kind="stable")
    return wavelength_nm[order], points[order]


def outline(panel: Axes, corners: dict[str, Floats]) -> None:
    around = [*corners.values(), next(iter(corners.values()))]
    panel.plot(*np.array(around).T, color=INK, linewidth=0.8, zorder=1)
    name_corners(panel, corners)


def name_corners(panel: Axes, corners: dict[str, Floats]) -> None:
    for name, at in corners.items():
        far = float(np.hypot(*at))
        away = at / far if far > 1e-9 else np.array([1.0, 1.0])
        panel.annotate(
            plain(name), tuple(at), tuple(3 * away), textcoords="offset points",
            ha="center" if abs(away[0]) < 0.3 else "left" if away[0] > 0 else "right",
            va="center" if abs(away[1]) < 0.3 else "bottom" if away[1] > 0 else "top",
        )  # fmt: skip


def ring(panel: Axes, radius: float) -> None:
    turn = np.linspace(0, 2 * math.pi, 181)
    panel.plot(
        radius * np.cos(turn), radius * np.sin(turn), color=GREY, linewidth=0.3, alpha=0.6, zorder=0
    )
    panel.annotate(f"{radius:g}", (0, -radius), color=GREY, fontsize="xx-small", ha="left")


def mark(k: int) -> Any:
    return {
        "color": COLOURS[k % len(COLOURS)],
        "marker": _MARKS[(k // len(COLOURS) + k) % len(_MARKS)],
        "markersize": 4,
        "markeredgecolor": "white",
        "markeredgewidth": 0.4,
        "zorder": 3,
    }


def named(given: Sequence[str], name: str, count: int) -> list[str]:
    if isinstance(given, str) or not all(isinstance(one, str) for one in given):
        raise Error(f"{name}: expected a sequence of names, found {given!r:.40}")
    if len(given) != count:
        raise Error(f"{name}: expected {count} names, found {len(given)}")
    return list(given)
