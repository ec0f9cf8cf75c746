"""Flies: Drosophila and the blowfly Calliphora, both with pale and yellow ommatidia.

The rhabdomeres of a fly's ommatidium lie apart and look in different directions: R1 to R6 along the
axes of six neighbours, R7 and R8 along its own (`fly_receptors` of `omma.eye.superposition`). The
cartridges pool those that look the same way: `pool` with `neural_superposition_wiring`.
"""

from __future__ import annotations

import math

from omma._core import Acceptance, Eye
from omma.base.arrays import Floats
from omma.base.progress import Stage
from omma.eye.change import mirror_eye
from omma.eye.facets import acceptance_from_facets
from omma.species._receptors import with_fly_receptors
from omma.species._shape import angle_from, blended, laid, on_ellipsoid, oval, smooth_step
from omma.species.facts import number

_DROSOPHILA = "drosophila"
_CALLIPHORA = "calliphora"


def build_drosophila(progress: Stage | None) -> list[Eye]:
    """The left and the right eye, grown anew."""
    right = _drosophila_eye("ommatidia", progress)
    left = mirror_eye(_drosophila_eye("ommatidia_left", progress))
    return [left.replace(eye_id=0), right]


def _drosophila_eye(count: str, progress: Stage | None) -> Eye:
    least, largest = (
        number(_DROSOPHILA, f"{which}_interommatidial_angle") for which in ("least", "largest")
    )

    def angle_at(from_middle: Floats) -> Floats:
        # Such a course, in such a field, has the scan's percentiles and number of lenses.
        edge = smooth_step(from_middle, math.radians(20), math.radians(95))
        return blended(least, largest, edge)

    axis = laid(
        _DROSOPHILA,
        lambda directions: angle_at(angle_from(directions, 80, 0)),
        None,
        lambda directions: angle_from(directions, 80, 0) < math.radians(105),
        progress,
        count,
    )
    eye = on_ellipsoid(
        _DROSOPHILA, axis, (80, 0), "median_facet_diameter", angle_at=angle_at
    ).replace(
        acceptance=Acceptance.gaussian(number(_DROSOPHILA, "acceptance_angle")),
        columns={"region": ["eye"] * len(axis)},
    )
    peaks = ("rh1_peak", "rh3_peak", "rh5_peak", "rh4_peak", "rh6_peak")
    return with_fly_receptors(eye, _DROSOPHILA, peaks)


def build_calliphora(progress: Stage | None) -> list[Eye]:
    """The right eye, grown anew."""
    ahead, lateral = (
        number(_CALLIPHORA, f"{where}_interommatidial_angle") for where in ("least", "lateral")
    )

    def angle_at(from_ahead: Floats) -> Floats:
        return blended(ahead, lateral, smooth_step(from_ahead, 0.0, math.radians(110)))

    axis = laid(
        _CALLIPHORA,
        lambda directions: angle_at(angle_from(directions, 0, 0)),
        None,
        oval((-10, 165), (-85, 88)),
        progress,
    )
    eye = on_ellipsoid(_CALLIPHORA, axis, (0, 0), "facet_diameter", angle_at=angle_at)
    eye = acceptance_from_facets(
        eye,
        wavelength_nm=number(_CALLIPHORA, "rh1_peak"),
        rhabdom_diameter_m=number(_CALLIPHORA, "rhabdomere_diameter"),
        f_number=number(_CALLIPHORA, "f_number"),
    ).replace(columns={"region": ["eye"] * len(axis)})
    peaks = ("rh1_peak", "r7_pale_peak", "r8_pale_peak", "r7_yellow_peak", "r8_yellow_peak")
    length = number(_CALLIPHORA, "rhabdomere_length")
    eye = with_fly_receptors(eye, _CALLIPHORA, peaks, length_m=length)
    return [eye]
