"""Photons that receptors catch in light of absolute units, and what microvilli make of its
polarisation.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Floats
from omma.base.slips import warn_of_slip
from omma.base.warn import warn_caller
from omma.light.lights import Light
from omma.receptors.rhabdoms import rhabdom_share
from omma.receptors.sensitivity import (
    of_each_sensitivity,
    ommatidium_of_receptor,
    receptor_optical_sensitivity,
    sensitivity_integral_nm,
)
from omma.receptors.solid_angles import Field

# The largest response of a world without a light: of dim pictures, and of those with suns.
_RELATIVE = 1e-6, 100.0
# Of a white surface in the light: darker than anything that is lit by it.
_FAR_BELOW = 1e-8
_SIDES = (*np.eye(3), *-np.eye(3))


@checked
def photon_catch(
    eye: Eye,
    responses: ArrayLike,
    light: Light,
    *,
    integration_time_s: ArrayLike,
    field: Field = "acceptance",
) -> Floats:
    """Photons that each receptor absorbs in a time: (..., R).

    N = f (π/4) D² Ω t ∫ L (1 - exp(-k a l)) dλ from 300 to 700 nm (after Land 1981; Warrant and
    Nilsson 1998), with the diameter D of the facet, or of a superposition eye's aperture, the solid
    angle Ω of the acceptance, the rhabdom's absorption k and length l, the pigment's absorbance a,
    and the receptor's share f of the rhabdom's cross-section (`rhabdom_share`): published numbers
    are of whole rhabdoms, f = 1. Of `Acceptance.lens_rhabdom` what does not get into the rhabdom is
    taken off (`Acceptance.coupling_efficiency`); what the lens and what is before the rhabdom
    absorb is not. Of a receptor with a table, its largest sensitivity stands for 1 - exp(-kl).

    Args:
        responses: (..., R), what receptors answer: radiance weighted by their sensitivity, as
            `receptor_matrix` makes of bands. All 1: photons for each unit of a response.
        light: what the world was lit by; it must be in photons.
        integration_time_s: over which a receptor adds up: a number, or one for each receptor (R,),
            as `omma.species.Species.integration_time_s`, a full width at half maximum; or
            `ImpulseResponse.integration_time_s`, 1/∫ h², 1.5 to 1.6 times as long, for the noise
            that a filter leaves.
        field: "acceptance": Ω = ∫ S dω, of the acceptance by which responses are rendered. "land":
            Ω = (π/4) Δρ², as in published catches, 0.69 of a Gaussian's.

    Example:
        >>> bee = omma.species.bumblebee(assume="honeybee_worker")
        >>> eye, light = bee.eye, omma.light.uniform_sky(1e17)
        >>> matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
        >>> seen = (matrix @ light.radiance((0, 1, 0))[0])[eye.receptor_type]
        >>> time_s = bee.integration_time_s
        >>> omma.receptors.photon_catch(eye, seen, light, integration_time_s=time_s).shape
        (77232,)

    Raises:
        omma.Error: light in watts, responses of another number of receptors, an eye without
            receptors, or one in which the facet of a receptor or its absorption or length is not
            known, or which has a type without sensitivity from 300 to 700 nm; responses that are
            negative or not finite; another word for ``field``, or a compoundray, which has no solid
            angle.

    Warns:
        UserWarning: receptors whose acceptance angle is 0 catch nothing; an integration time above
            5 s; responses so far below the light that they look relative, as of a world without a
            light.
    """
    if light.unit != "photons":
        raise Error(f"light: expected one in photons, as catches are, found {light.unit}")
    # Land's S for light at the pigment's peak has the factor 1 - exp(-kl).
    sensitivity = receptor_optical_sensitivity(eye, monochromatic=True, field=field)
    if len(sensitivity) == 0 or np.any(np.isnan(sensitivity)):
        raise Error(_what_lacks(eye))
    none = np.flatnonzero(sensitivity == 0)
    if len(none):
        warn_caller(
            f"photon_catch: {len(none):,} of {len(sensitivity):,} receptors, of ommatidium "
            f"{ommatidium_of_receptor(eye)[none[0]]} first, catch no photons, as their acceptance "
            "angle is 0: one ray without width",
            UserWarning,
        )
    time_s = _times(integration_time_s, len(sensitivity))
    answers = array_of(responses, "responses")
    if answers.shape[-1:] != sensitivity.shape:
        raise Error(_which_responses(eye, answers.shape))
    bad = np.argwhere(~(np.isfinite(answers) & (answers >= 0)))
    if len(bad):
        where = ", ".join(map(str, bad[0]))
        raise Error(
            f"responses: expected finite numbers from 0 on, found {answers[tuple(bad[0])]:g} at "
            f"[{where}]"
        )
    _warn_of_relative(answers, light)
    per_type = np.array(of_each_sensitivity(eye.receptor_types, sensitivity_integral_nm))
    per_response = sensitivity * rhabdom_share(eye) * per_type[eye.receptor_type] * time_s
    return np.asarray(answers * per_response)


def _warn_of_relative(responses: Floats, light: Light) -> None:
    """Tell of responses that look like those of a world without a light, of pictures and colours
    from 0 to 1. A moonless night is of some 1e10 photons, and the darkest surface in it of far more
    than 100."""
    most = float(responses.max(initial=0.0))
    if not _RELATIVE[0] <= most <= _RELATIVE[1] or np.all(responses == 1):
        return
    white = max(float(np.max(sum(light.irradiance(side)))) for side in _SIDES) / np.pi
    if most < _FAR_BELOW * white:
        warn_caller(
            f"responses: up to {most:.3g}, where a white surface in this light has {white:.3g}: "
            "they look relative, and photons would be too few by as much; was this world lit by "
            "`light`, omma.World(scene, light=light)?",
            UserWarning,
        )


def _times(integration_time_s: ArrayLike, count: int) -> Floats:
    if not isinstance(integration_time_s, list | tuple) and np.ndim(integration_time_s) == 0:
        time_s = positive(integration_time_s, "integration_time_s")  # type: ignore[arg-type]
        warn_of_slip("integration time", time_s, "integration_time_s")
        return np.asarray(time_s)
    times = array_of(integration_time_s, "integration_time_s")
    if times.shape != (count,):
        raise Error(
            f"integration_time_s: expected one number or {count}, one for each receptor, found "
            f"shape {times.shape}"
        )
    if not (np.all(np.isfinite(times)) and np.all(times > 0)):
        raise Error(f"integration_time_s: expected numbers above 0, found {times.min():g}")
    warn_of_slip("integration time", float(times.max()), "integration_time_s")
    return times


def _which_responses(eye: Eye, shape: tuple[int, ...]) -> str:
    """What responses are to be, and what those that were found may be."""
    said = f"responses: expected shape (..., {len(eye.receptor_type)}), one for each receptor"
    found = shape[-1:]
    if found == (len(eye.receptor_types),):
        return f"{said}, found {shape}, one for each type: take responses[..., eye.receptor_type]"
    if found == (len(eye),):
        return f"{said}, found {shape}, one for each ommatidium: take those of render_receptors"
    return f"{said}, found {shape}"


def _what_lacks(eye: Eye) -> str:
    """Which numbers of an eye are not known, whose eye it is, and what to do."""
    import omma.species.animals  # species lie above this subpackage: for these words alone

    lacks = []
    facets = int(np.count_nonzero((eye.facet_diameter_m == 0) & (eye.aperture_diameter_m == 0)))
    if facets:
        lacks.append(f"facet_diameter_m of {facets} of {len(eye)} ommatidia")
    for what in ("absorption_per_m", "length_m"):
        names = list(dict.fromkeys(t.name for t in eye.receptor_types if getattr(t, what) == 0))
        if names:
            some = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
            lacks.append(f"{what} of the receptors {some}")
    if not eye.receptor_types:
        lacks.append("any receptors")
    animals = omma.species.with_catches()
    donor, name = animals[0], omma.species.animals.name_of(eye)
    way_out = (
        f"omma.species.assume_rhabdoms(eye, {donor!r})"
        if name is None else
        f"omma.species.{name}(assume={donor!r}).eye"
    )  # fmt: skip
    return (
        f"eye: expected what photons are counted by; {name or 'it'} lacks {'; '.join(lacks)}. "
        f"Render with {way_out}, which takes what lacks from an animal that has it "
        f"({', '.join(animals)}) and says so; or give ReceptorType the absorption_per_m and "
        "length_m that you know"
    )


@checked
def polarisation_weights(eye: Eye) -> tuple[Floats, Floats]:
    """How much each receptor sees of polarisation, and along which angle: m (R,) and φ (R,), rad.

    Of light with the Stokes vector (I, Q, U) in the ommatidium's frame, a receptor sees
    I + m (Q cos 2φ + U sin 2φ), m = (PS - 1)/(PS + 1) of its polarisation sensitivity PS: the more
    the nearer the electric vector is to its microvilli, at φ from up towards the right. The mean
    over all angles is I.

    Raises:
        omma.Error: the eye has no receptors.
    """
    if not eye.receptor_types:
        raise Error("eye: expected one with receptors, found none")
    modulation, angle = type_polarisation(eye)
    return modulation[eye.receptor_type], angle[eye.receptor_type]


def type_polarisation(eye: Eye) -> tuple[Floats, Floats]:
    """The same of each receptor type: m (T,) and φ (T,), rad."""
    types = eye.receptor_types
    ratio = np.array([one.polarisation_sensitivity for one in types])
    return (ratio - 1) / (ratio + 1), np.array([one.microvillus_angle_rad for one in types])
