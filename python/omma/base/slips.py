"""Times, rates, angles and pictures that nobody means, mostly in another unit: the caller is told,
as nothing else is wrong with them. Those of eyes and optics are in the engine's `plausible.h`.

The ranges are assumed: wide ones around what is published and shown, so that a factor of 1,000, of
milliseconds, leaves them, or one of 57, of degrees.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.warn import warn_caller

# What: from, to, unit.
_RANGES: dict[str, tuple[float, float, str]] = {
    # Delays of motion detectors are some tens of milliseconds, high-passes some hundreds.
    "time constant": (1e-4, 5.0, "s"),
    # No photoreceptor is slower, or adds up light for longer.
    "impulse response": (0.0, 5.0, "s"),
    "integration time": (0.0, 5.0, "s"),
    # Of sensors and of neurons, milliseconds.
    "refractory time": (0.0, 1.0, "s"),
    # l/v of looming stimuli is some tens of milliseconds.
    "l/v": (1e-4, 10.0, "s"),
    "time of collision": (-60.0, 60.0, "s"),
    "frames per second": (1.0, 1e6, "Hz"),
    # A frame that lasts sees nothing of what was there a second ago.
    "time between frames": (0.0, 1.0, "s"),
    # As of the engine's, and of apertures.
    "acceptance angle": (math.radians(0.02), math.radians(60.0), "rad"),
    # Of gratings: a turn at most.
    "wavelength": (math.radians(0.02), math.tau, "rad"),
    # Of neighbours; compound eyes have 0.2° to some tens of degrees.
    "interommatidial angle": (math.radians(0.02), math.radians(60.0), "rad"),
    "angle between axes": (-math.radians(60.0), math.radians(60.0), "rad"),
    # Of acute zones and streaks; broader ones change nothing.
    "width of an acute zone": (0.0, math.tau, "rad"),
    # Microsaccades move axes by some degrees.
    "turn of an axis": (-math.radians(30.0), math.radians(30.0), "rad"),
    # Flies turn by some thousand degrees in a second.
    "angular velocity": (0.0, 100.0, "rad/s"),
    "direction": (-math.tau, math.tau, "rad"),
    # The sun's outside of the air is 2.2 at most.
    "irradiance": (0.0, 5.0, "W m⁻² nm⁻¹"),
    "diameter": (1e-6, 2e-2, "m"),
    "rhabdom length": (1e-6, 1e-2, "m"),
    "absorption": (1e2, 1e5, "per m"),
}
# What a number would be that is given in another unit: its factor, and how it is written.
_MEANT = {
    "rad": (math.pi / 180, "°"),
    "rad/s": (math.pi / 180, "°/s"),
    "m": (1e-6, " µm"),
    "per m": (1e6, " per µm"),
}


# Smaller pictures are made up, and a picture of twice its height is off by rounding at most.
_LEAST_PIXELS, _MOST_OFF = 16, 0.02


def warn_of_shape(shape: tuple[int, ...], name: str, hint: str = "") -> None:
    """Tell the caller of the package of a picture that is no whole sphere by its shape.

    Args:
        hint: what else can be done with such a picture, put behind the message.
    """
    height, width = shape[:2]
    if min(height, width) < _LEAST_PIXELS or abs(width / (2 * height) - 1) <= _MOST_OFF:
        return
    warn_caller(
        f"{name}: {width} x {height} pixels are stretched over the whole sphere, of which an "
        f"equirectangular picture is twice as wide as high{hint}",
        UserWarning,
    )


def warn_of_slip(what: str, value: ArrayLike, name: str) -> None:
    """Tell the caller of the package of a value, the largest of an array's, that lies outside of
    the range of what it is, and which one it would be in the unit that it seems to have."""
    low, high, unit = _RANGES[what]
    values = np.asarray(value, np.float64).ravel()
    beyond = values[~((values >= low) & (values <= high))]
    if len(beyond):
        found = float(beyond[np.argmax(np.abs(beyond))])
        warn_caller(
            f"{name}: {found:g} {unit} is unusual ({what}, {low:g} to {high:g} {unit})"
            f"{_meant(what, found)}",
            UserWarning,
        )


def refuse_slip(what: str, value: float, name: str) -> None:
    """omma.Error where a time is longer than any of what it is, which says which one it would be in
    milliseconds."""
    _, high, _ = _RANGES[what]
    if value > high:
        raise Error(
            f"{name}: expected seconds, at most {high:g}, found {value:g}{_meant(what, value)}"
        )


def _meant(what: str, value: float) -> str:
    """What a number outside of the range would be in the unit that it seems to have."""
    low, high, unit = _RANGES[what]
    if unit == "s" and low <= value * 1e-3 <= high:
        return f"; {value:g} ms would be {value * 1e-3:g} s"
    if unit == "Hz" and value > 0 and low <= 1 / value <= high:
        return f"; {value:g} s between frames would be {1 / value:g} Hz"
    if unit in _MEANT and low <= value * _MEANT[unit][0] <= high:
        factor, other = _MEANT[unit]
        return f"; {value:g}{other} would be {value * factor:.4g} {unit}"
    return ""
