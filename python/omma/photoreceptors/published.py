"""Impulse responses of animals, as published."""

from __future__ import annotations

import functools
from typing import Literal

import numpy as np

from omma.base.arguments import checked, one_of
from omma.photoreceptors.gain_control import (
    POST_LATENCY_S,
    POST_POWER,
    POST_TIME_S,
    PRE_ORDER,
    PRE_TIME_S,
)
from omma.photoreceptors.impulse_response import ImpulseResponse

Name = Literal["bumblebee green", "bumblebee blue", "bumblebee ultraviolet", "blowfly"]

# Full widths at half maximum in bright light, s.
_BUMBLEBEE = {
    "bumblebee green": 7.9e-3,
    "bumblebee blue": 9.8e-3,
    "bumblebee ultraviolet": 12.3e-3,
}
# An assumption, near the 0.24 and 0.27 of a hover fly; it gives the time to the peak.
_ASSUMED_SIGMA = 0.3


@checked
def published_response(name: Name) -> ImpulseResponse:
    """The impulse response of an animal's photoreceptors in bright light.

    "bumblebee green", "bumblebee blue", "bumblebee ultraviolet": *Bombus terrestris*, log-normals
    with the published full widths at half maximum, 7.9, 9.8 and 12.3 ms (Skorupski and Chittka
    2010, J Neurosci 30:3896, abstract). Their σ of 0.3 is an assumption, and with it the times to
    the peak (11.0, 13.6 and 17.1 ms).

    "blowfly": *Calliphora vicina*, what the model of van Hateren and Snippe has besides adaptation:
    three low-pass filters of 1.69 ms and t¹¹ exp(-t/0.535 ms), a millisecond late (see
    `van_hateren_snippe`). A table with its peak at 11.2 ms and a width of 7.4 ms.

    Raises:
        omma.Error: another name.
    """
    one_of(name, [*_BUMBLEBEE, "blowfly"], "name")
    if name == "blowfly":
        return _blowfly()
    half = np.sinh(_ASSUMED_SIGMA * np.sqrt(2 * np.log(2)))
    return ImpulseResponse.howard(float(_BUMBLEBEE[name] / (2 * half)), _ASSUMED_SIGMA)


@functools.cache
def _blowfly() -> ImpulseResponse:
    step = 1e-5
    times = np.arange(0.0, 0.05, step)
    before = times ** (PRE_ORDER - 1) * np.exp(-times / PRE_TIME_S)
    after = (times / POST_TIME_S) ** POST_POWER * np.exp(-times / POST_TIME_S)
    values = np.convolve(before, after)[: len(times)]
    # A knot in ten: straight lines between them are off by 1e-4 of the peak.
    return ImpulseResponse.table((times + POST_LATENCY_S)[::10], values[::10])
