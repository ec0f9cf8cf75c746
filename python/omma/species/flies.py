"""Flies: Drosophila and the blowfly Calliphora, both with pale and yellow ommatidia.

The rhabdomeres of a fly's ommatidium lie apart and look in different directions: R1 to R6 along the
axes of six neighbours, R7 and R8 along its own (`omma.eye.fly_receptors`). The cartridges pool
those that look the same way: `omma.eye.pool` with `omma.eye.neural_superposition_wiring`.
"""

from __future__ import annotations

import math

from omma._core import Acceptance, Eye
from omma.eye.change import mirror_eye
from omma.eye.facets import acceptance_from_facets
from omma.species._receptors import with_fly_receptors
from omma.species._shape import (
    Floats,
    Progress,
    angle_from,
    blended,
    laid,
    on_ellipsoid,
    oval,
    smooth_step,
    species,
)
from omma.species.facts import Species, number

_DROSOPHILA = "drosophila"
_CALLIPHORA = "calliphora"


def drosophila(progress: Progress | None = None) -> Species:
    """A female fruit fly, *Drosophila melanogaster*.

    Lenses (857 right, 852 left), angles (median 4.9°, 5-95 %: 3.8-9.5°) and the spacing of lenses:
    computed from the micro-CT of Zhao et al. 2025, Nature, s41586-025-09276-5. Acceptance:
    Gonzalez-Bellido et al. 2011, at second hand. Rhodopsins: Salcedo et al. 1999, J Neurosci
    19:10716. Pale and yellow ommatidia 30:70 at random. R1 to R6 in neural
    superposition. Assumed: the smooth course of the angle from the eye's middle to its edge, the
    field of view, the surface.
    """
    right = _drosophila_eye("ommatidia", progress)
    left = mirror_eye(_drosophila_eye("ommatidia_left", progress))
    return species(_DROSOPHILA, "Drosophila melanogaster", right, left.replace(eye_id=0))


def _drosophila_eye(count: str, progress: Progress | None) -> Eye:
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


def calliphora(progress: Progress | None = None) -> Species:
    """A female blowfly, *Calliphora*.

    Facet 25 µm, F-number 2.2, rhabdomere 1.4-2.0 µm: the model fly of Stavenga 2004, J Exp Biol
    207:1703, from which the acceptance functions are computed (mode and diffraction). R7 and R8,
    and pale to yellow 2:3: Smola & Meffert 1979, J Comp Physiol 133:41. About 4,500 facets: a
    picture's caption. Assumed: all angles between axes, the field of view, the surface.
    """
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
    return species(_CALLIPHORA, "Calliphora vicina", eye)
