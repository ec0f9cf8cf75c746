"""What a Hassenstein-Reichardt detector answers to a drifting grating, in closed form.

For a sine grating of contrast C around the mean light I, wavelength λ, drifting at f = ω/2π, and
two ommatidia Δφ apart, the output has the mean (Reichardt 1961; Buchner 1976, Biol Cybern 24:85;
Borst & Egelhaaf 1989, Trends Neurosci 12:297)

    R = I² C² M² sin(2π Δφ/λ) ωτ/(1 + ω²τ²)

M being the modulation transfer of an ommatidium.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import arrays_of, checked, positive, within
from omma.base.arrays import Floats
from omma.base.slips import warn_of_slip
from omma.motion.filters import filter_step, transfer

# Of a Gaussian of full width Δρ at half maximum: M = exp(-π²/(4 ln 2) (Δρ/λ)²).
_GAUSSIAN = math.pi**2 / (4 * math.log(2))


@checked
def grating_response(
    contrast: ArrayLike,
    wavelength_rad: ArrayLike,
    frequency_hz: ArrayLike,
    separation_rad: ArrayLike,
    tau_s: float,
    *,
    high_pass_tau_s: float | None = None,
    acceptance_angle_rad: float = 0.0,
    mean: float = 1.0,
    frame_rate_hz: float | None = None,
) -> Floats:
    """The mean output of a detector that sees a drifting sine grating, in the steady state.

    A high-pass multiplies it by (ωτ_H)²/(1 + (ωτ_H)²). Arrays are broadcast.

    Args:
        contrast: of the grating, (largest - least)/(largest + least), 0 to 1.
        wavelength_rad: its spatial period.
        frequency_hz: periods a second that pass; above 0 where it drifts from the first ommatidium
            to the second. The velocity is frequency times wavelength.
        separation_rad: from the axis of the first to that of the second, along the drift.
        tau_s: time constant of the delay.
        high_pass_tau_s: that of the high-pass before both arms; None: there is none.
        acceptance_angle_rad: full width at half maximum of a Gaussian ommatidium.
        mean: the grating's mean light, above 0.
        frame_rate_hz: None: of continuous responses. Else of responses sampled so often, as
            `DetectorArray` filters them: straight lines in between.

    Example:
        >>> one = omma.motion.grating_response(1.0, 0.4, 1.0, 0.1, 1 / (2 * np.pi))
        >>> bool(abs(one - 0.5) < 1e-12)  # sin(2π/4) times 1/(1 + 1)
        True

    Raises:
        omma.Error: a number out of its range, or shapes that do not go together.

    Warns:
        UserWarning: time constants above 5 s or below 0.1 ms; wavelengths above a turn, separations
            and acceptance angles above 60°, or angles below 0.02°, mostly degrees.
    """
    contrasts, wavelengths, frequencies, separations = arrays_of(
        contrast=contrast,
        wavelength_rad=wavelength_rad,
        frequency_hz=frequency_hz,
        separation_rad=separation_rad,
    )
    beyond = contrasts[~((contrasts >= 0) & (contrasts <= 1))]
    if len(beyond):
        raise Error(f"contrast: expected 0 to 1 (not per cent), found {beyond[0]:g}")
    for name, given in (("frequency_hz", frequencies), ("separation_rad", separations)):
        if np.isnan(given).any():
            raise Error(f"{name}: expected numbers, found nan")
    if not np.all(wavelengths > 0):
        raise Error(f"wavelength_rad: expected numbers above 0, found {np.min(wavelengths):g}")
    tau = _time_constant(tau_s, "tau_s")
    width = within(acceptance_angle_rad, "acceptance_angle_rad", 0, math.tau)
    warn_of_slip("wavelength", wavelengths, "wavelength_rad")
    warn_of_slip("angle between axes", separations, "separation_rad")
    if width > 0:
        warn_of_slip("acceptance angle", width, "acceptance_angle_rad")
    light = within(mean, "mean", 0, 1e150)
    if light == 0:
        raise Error("mean: expected a number above 0, to which the contrast is relative, found 0")
    high_pass = None
    if high_pass_tau_s is not None:
        high_pass = _time_constant(high_pass_tau_s, "high_pass_tau_s")
    with np.errstate(over="ignore", invalid="ignore"):
        omega = math.tau * frequencies
        if frame_rate_hz is None:
            high = np.ones_like(omega, np.complex128)
            if high_pass is not None:
                slow = 1j * omega * high_pass
                high = slow / (1 + slow)
            late = high / (1 + 1j * omega * tau)
        else:
            step = filter_step(tau, high_pass, frame_rate_hz)
            high, late = transfer(step, omega / frame_rate_hz)
        seen = light * contrasts * np.exp(-_GAUSSIAN * (width / wavelengths) ** 2)
        phase = np.sin(math.tau * separations / wavelengths)
        found = seen**2 * phase * -(late * np.conj(high)).imag
    return np.asarray(found)


@checked
def best_frequency_hz(tau_s: float, high_pass_tau_s: float | None = None) -> float:
    """The temporal frequency that a detector answers most to, whatever the wavelength.

    Without a high-pass 1/(2π τ); with one it is higher.

    Args:
        tau_s, high_pass_tau_s: time constants of the delay and of the high-pass before both arms.

    Example:
        >>> round(omma.motion.best_frequency_hz(0.035), 2)
        4.55

    Raises:
        omma.Error: a number that is not above 0.

    Warns:
        UserWarning: time constants above 5 s or below 0.1 ms.
    """
    delay = _time_constant(tau_s, "tau_s")
    if high_pass_tau_s is None:
        return 1 / (math.tau * delay)
    # Where the derivative of ω³/((1 + ω²τ²)(1 + ω²τ_H²)) is 0, ω in units of the shorter's inverse.
    short, long = sorted((delay, _time_constant(high_pass_tau_s, "high_pass_tau_s")))
    ratio = (short / long) ** 2
    squared = (1 + ratio + math.sqrt((1 + ratio) ** 2 + 12 * ratio)) / 2
    return math.sqrt(squared) / (math.tau * short)


def _time_constant(value: float, name: str) -> float:
    found = positive(value, name)
    warn_of_slip("time constant", found, name)
    return found
