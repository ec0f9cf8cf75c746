"""From how far an animal tells a target from what surrounds it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked
from omma.base.directions import direction
from omma.base.progress import Progress
from omma.base.values import value_class
from omma.base.warn import warn_caller
from omma.colour_vision.disc_views import DiscView
from omma.colour_vision.distance_search import Search
from omma.colour_vision.observer import Decision, Observer
from omma.colour_vision.scene_views import SceneView
from omma.colour_vision.targets import DiscTarget, SceneTarget
from omma.colour_vision.views import Looking, View
from omma.light.lights import Light
from omma.rendering.settings import Fixed
from omma.rendering.without_polarisation import tell_detection_without_polarisation

# Rays by which a distance is looked for, to a factor of two, and then until its standard error is
# small enough.
_FIRST, _MORE = Fixed(64), (Fixed(256), Fixed(2048), Fixed(16384))
# So many times as many are named where they are too few.
_MANY_MORE = 8


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Detection:
    """From how far a target is detected, as `detect` finds it.

    Attributes:
        distance_m: between target and the head's origin, the farthest at which the criterion is
            reached; 0 where it is at none, infinite where it still is at the farthest.
        standard_error_m: of that, from the rays; NaN where there is no such distance, infinite
            where too few rays meet the target there.
        diameter_rad: angular diameter of the target there; NaN where there is no such distance.
    """

    distance_m: float
    standard_error_m: float
    diameter_rad: float


@checked
def detect(
    eye: Eye,
    target: DiscTarget | SceneTarget,
    light: Light,
    observer: Observer | None = None,
    *,
    between_m: Sequence[float] = (0.01, 1000.0),
    sampling: Fixed | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Detection:
    """From how far an animal tells a target from what surrounds it, with an error bar.

    A disc or a thing in a scene is rendered for the eye at distances between which the answer is
    found by bisection, the same ommatidia always by the same rays. Each ommatidium looks from where
    its lens is. Far off, what is told falls with the distance. Near the head, where lenses a
    millimetre or two beside its middle count, others look at the target at each distance, or none
    may, as where both eyes look past it: there distances are looked at in steps of a factor of √2,
    and a target that is not told at one may be told farther off. The observer is ideal: it knows
    where the target would be, how large it is and of what colour. Animals are worse
    (docs/colours.md).

    Args:
        eye: an animal's, with receptors of which catches are known (`photon_catch`).
        target: what there is to detect.
        light: what it is lit by, in photons.
        observer: by what it is decided; None: `Observer()`.
        between_m: nearest and farthest distance that is looked at; at most 100,000 diameters.
        sampling: rays of an ommatidium, in each of 8 sets. None: 256, more until the standard
            error is half a percent of the distance, 16,384 at most. A target that fills a share f
            of the acceptance is met by f of them.
        seed: of the rays.
        progress: told of how many of the numbers of rays that may be needed are done with, at
            each distance; what it raises ends the work.

    Example:
        >>> eye = omma.species.honeybee_worker().eye
        >>> ahead = eye.take(np.flatnonzero(eye.axis[:, 2] < -0.9))
        >>> spot = omma.colour_vision.DiscTarget(0.02, reflectance=0.02, background=0.2)
        >>> green = omma.colour_vision.Observer(receptors=("green",), criterion=5.0)
        >>> found = omma.detect(ahead, spot, omma.light.uniform_sky(1e14), green)
        >>> 0.55 < found.distance_m < 0.57
        True

    Raises:
        omma.Error: an argument out of its range, an eye of which catches are not known, receptors
            or noise that the eye does not have, receptors that the ommatidia lack which count at
            the farthest distance, a target where no ommatidium looks.

    Warns:
        UserWarning: too few rays meet the target to give the distance an error; receptors that
            count tell directions of polarisation, of which the light of a scene has some (once a
            session).
    """
    observer = Observer() if observer is None else observer
    near, far = _ends(between_m)
    towards = direction(observer.azimuth_deg, observer.elevation_deg)
    seen_as = light, towards, observer.integration_time_s
    view: View
    if isinstance(target, DiscTarget):
        view = DiscView(eye, target, *seen_as)
    else:
        view = SceneView(eye, target, *seen_as)
    decision = Decision(eye, observer)
    # A disc and its ground are matte, and polarise nothing.
    if isinstance(target, SceneTarget):
        tell_detection_without_polarisation(light, decision.most_polarisation)
    far = min(far, view.farthest_m())
    if near >= far:
        raise Error(
            f"between_m: expected to begin before {far:g} m, 100,000 diameters of the target"
        )

    if not view.is_reached(near):
        raise Error(
            "observer: expected a direction that ommatidia of the eye look into, found azimuth "
            f"{observer.azimuth_deg:g}, elevation {observer.elevation_deg:g} degrees"
        )

    decision.expect_classes(eye, view, far)
    stages = (_FIRST, *(_MORE if sampling is None else (sampling,)))
    done = 0

    def by(rays: Fixed, nearest_m: float) -> Looking:
        return decision.looking(view, nearest_m, rays, seed)

    def excess(seen_by: Looking, distance_m: float) -> tuple[float, float]:
        if progress is not None:
            progress(done / len(stages))
        return decision.excess(seen_by, distance_m)

    search = Search((near, far), view.settled_m(), by, excess)
    begin = search.begin_m(_FIRST)
    for rays in stages[1:]:
        done += 1
        answer = search.answer(rays, begin)
        if answer.sure:
            break
        begin = answer.begin_m
    if progress is not None:
        progress(1.0)
    found, error = answer.distance_m, answer.standard_error_m
    if math.isinf(error):
        warn_caller(
            f"sampling: of 8 x {rays.samples} rays too few meet the target, or its edge, to tell "
            f"by how much {found:.3g} m is off (standard_error_m is infinite); ask for more, "
            f"sampling=omma.Fixed({_MANY_MORE * rays.samples})",
            UserWarning,
        )
    return Detection(found, error, _diameter_rad(target, found))


def _ends(between_m: Sequence[float]) -> tuple[float, float]:
    ends = array_of(between_m, "between_m", (2,))
    if not (0 < ends[0] < ends[1] <= 1e9 and ends[0] >= 1e-9):
        raise Error(f"between_m: expected two ascending distances from 1e-9 to 1e9 m, found {ends}")
    return float(ends[0]), float(ends[1])


def _diameter_rad(target: DiscTarget | SceneTarget, distance_m: float) -> float:
    if not 0 < distance_m < math.inf:
        return math.nan
    return 2 * math.atan2(target.diameter_m / 2, distance_m)
