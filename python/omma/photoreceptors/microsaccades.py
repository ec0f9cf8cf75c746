"""Rhabdomeres that move when light changes, and with them the axes of the ommatidia."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, positive, within
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.base.slips import refuse_slip, warn_of_slip
from omma.photoreceptors.adaptation import light_of
from omma.photoreceptors.filters import filter_frames
from omma.photoreceptors.impulse_response import ImpulseResponse

# Beyond a quarter turn an axis would look at the back of its own eye.
_WIDEST_RAD = np.pi / 2
# Tables have slopes, not steps: how long one takes, s.
_SLOPE_S = 1e-6
# Axes and up vectors in single precision are known to about 1e-7.
_UNIT = 1e-4


@checked
def microsaccades_rad(
    light: ArrayLike,
    frame_rate_hz: float,
    *,
    dark: float,
    decade_rad: float = np.radians(1.0),
    largest_rad: float = np.radians(4.0),
    latency_s: float = 8e-3,
    rise_s: float = 0.1,
    return_s: float = 0.5,
) -> Floats:
    """By which angle photoreceptors turn their axes when light changes, over time: (F, ...), rad.

    A step of light by a factor of ten turns an axis by ``decade_rad``: nothing for ``latency_s``,
    evenly up in ``rise_s``, evenly back in ``return_s``. Steps add up in the logarithm of light,
    log10(1 + L/dark); darkening turns the other way. Times are those by which Juusola et al. 2017
    (eLife 6:e26117) simulate *Drosophila*'s R1-R6, whose rhabdomeres set out 8 to 20 ms after a
    flash, are furthest 70 to 200 ms later and shift receptive fields by 0.5 to 4.0°, with the
    logarithm of light; the angle per decade is an assumption.

    Args:
        light: (F, ...), frames first, from 0 on, in any unit; of which photoreceptors one by one
            are moved. Before the first frame light was as it is in it.
        frame_rate_hz: frames per second; the logarithm goes in straight lines between frames.
        dark: light from which on it counts by its logarithm, in the unit of ``light``.
        decade_rad: the angle for ten times the light; 0 for none.
        largest_rad: the largest angle either way.
        latency_s, rise_s, return_s: the time course, s.

    Raises:
        omma.Error: light that is negative or not finite, no frames, times or angles out of range.

    Warns:
        UserWarning: angles above 30°, mostly degrees.
    """
    given = light_of(light, "light")
    if given.ndim == 0 or len(given) == 0:
        raise Error("light: expected frames along the first axis, found none")
    decades = np.log10(1 + given / positive(dark, "dark"))
    for name, angle in (("decade_rad", decade_rad), ("largest_rad", largest_rad)):
        warn_of_slip("turn of an axis", within(angle, name, 0.0, _WIDEST_RAD), name)
    within(latency_s, "latency_s", 0.0, 1.0)
    for name, value in (("rise_s", rise_s), ("return_s", return_s)):
        refuse_slip("impulse response", positive(value, name), name)
    rise = _even(latency_s, latency_s + rise_s)
    fall = _even(latency_s + rise_s, latency_s + rise_s + return_s)
    # A step answered by a triangle is light averaged over its rise, less that over its fall.
    turned = filter_frames(decades, frame_rate_hz, rise) - filter_frames(
        decades, frame_rate_hz, fall
    )
    return np.asarray(np.clip(decade_rad * turned, -largest_rad, largest_rad))


def _even(start_s: float, end_s: float) -> ImpulseResponse:
    """The mean over a time that begins late."""
    slope = min(_SLOPE_S, (end_s - start_s) / 4)
    return ImpulseResponse.table(
        [start_s, start_s + slope, end_s - slope, end_s], [0.0, 1.0, 1.0, 0.0]
    )


@checked
def displace_axes(
    axis: ArrayLike, up: ArrayLike, angle_rad: ArrayLike, towards_rad: ArrayLike
) -> Floats:
    """Axes turned by an angle each: (..., N, 3), of length 1.

    Args:
        axis: (N, 3), as ``eye.axis``.
        up: (N, 3), as ``eye.up``.
        angle_rad: (..., N), by how much, rad, as of `microsaccades_rad`; negative the other way.
        towards_rad: to where, a number or (N,): 0 up, π/2 to the right of the ommatidium as it
            looks out. Receptive fields go against the rhabdomeres, as a lens turns images round;
            in flies those go to the front, so that axes go to the back: mirror images in the left
            and the right eye (Kemppainen et al. 2022, PNAS 119:e2109717119).

    Example:
        >>> eye = omma.eye.generate_eye(100)
        >>> turned = omma.photoreceptors.displace_axes(eye.axis, eye.up, np.full(100, 0.02), 0.0)
        >>> moved = eye.replace(axis=turned, up=eye.up)

    Raises:
        omma.Error: vectors that are not of length 1 or not across each other, angles of another
            number or not finite.

    Warns:
        UserWarning: turns above 30°, or a direction of more than a turn, mostly degrees.
    """
    looking, upwards = array_of(axis, "axis", (None, 3)), array_of(up, "up", (None, 3))
    count = len(looking)
    if len(upwards) != count:
        raise Error(f"up: expected {count} vectors as axis has, found {len(upwards)}")
    for name, vectors in (("axis", looking), ("up", upwards)):
        if not np.all(np.abs(np.sum(vectors**2, axis=1) - 1) < _UNIT):
            raise Error(f"{name}: expected vectors of length 1")
    if not np.all(np.abs(np.sum(looking * upwards, axis=1)) < _UNIT):
        raise Error("up: expected vectors across the axes")
    angle = array_of(angle_rad, "angle_rad", (..., count), finite=True)
    towards = array_of(towards_rad, "towards_rad", [(), (count,)], finite=True)
    warn_of_slip("turn of an axis", angle, "angle_rad")
    warn_of_slip("direction", towards, "towards_rad")
    right = np.cross(looking, upwards)
    across = np.cos(towards)[..., None] * upwards + np.sin(towards)[..., None] * right
    turned = np.cos(angle)[..., None] * looking + np.sin(angle)[..., None] * across
    return normalized(turned)
