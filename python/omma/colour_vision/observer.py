"""Who decides whether there is a target: what an observer makes of photons with the target and
without it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye
from omma.base.arguments import array_of, one_of, positive, whole, within
from omma.base.arrays import Floats
from omma.base.slips import warn_of_slip
from omma.base.values import value_class
from omma.base.warn import warn_caller
from omma.colour_vision.noise_limited import distance_of_many, distance_of_one, expect_fractions
from omma.colour_vision.views import Looking, Nearest, Seen, View
from omma.receptors.sensitivity import ommatidium_of_receptor
from omma.rendering.settings import Fixed

By = Literal["photons", "achromatic", "colour"]

# By how much of itself a sum of photons is changed, for the slope of a distance by it.
_STEP = 1e-4


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Observer:
    """Who decides whether there is a target, and by what.

    Attributes:
        by: "photons": an ideal observer who knows what to look for, d' over all receptors
            (`d_prime`). "colour": the distance by receptor noise between what a few ommatidia catch
            and what they would catch of the ground (`noise_limited_distance`, with photon noise).
            "achromatic": the same of one receptor type (`achromatic_distance`).
        criterion: of d', or in just-noticeable differences.
        integration_time_s: over which photons are counted.
        receptors: names of the receptor types that count, such as ("green",); for "achromatic" the
            one that does. (): all of them, for "colour" those that these ommatidia have. Types of
            one name are one class, as a fly's R1 in all of its ommatidia.
        dark_per_s: photons that each receptor counts in darkness, added to those of the target and
            to those of the ground.
        noise: e of each class of receptors of the eye, in the order of their first types, as
            `class_noise` gives it, for all but "photons"; (): 0.1 of each. That of one class is at
            most 1.
        ommatidia: over how many catches are summed, for all but "photons": at each distance those
            that look nearest to the target's middle from where their lenses are; of an eye with
            fewer all, with a warning.
        azimuth_deg, elevation_deg: where in the head's field the target is kept.

    Raises:
        omma.Error: a number out of its range.

    Warns:
        UserWarning: an integration time above 5 s.
    """

    by: By = "photons"
    criterion: float = 1.0
    integration_time_s: float = 0.03
    receptors: tuple[str, ...] = ()
    dark_per_s: float = 0.0
    noise: tuple[float, ...] = ()
    ommatidia: int = 7
    azimuth_deg: float = 0.0
    elevation_deg: float = 0.0

    def __post_init__(self) -> None:
        one_of(self.by, ("photons", "achromatic", "colour"), "by")
        for name in ("criterion", "integration_time_s"):
            object.__setattr__(self, name, positive(getattr(self, name), name))
        warn_of_slip("integration time", self.integration_time_s, "integration_time_s")
        for name, low, high in (
            ("dark_per_s", 0.0, 1e30),
            ("azimuth_deg", -360.0, 360.0),
            ("elevation_deg", -90.0, 90.0),
        ):
            object.__setattr__(self, name, within(getattr(self, name), name, low, high))
        object.__setattr__(self, "ommatidia", whole(self.ommatidia, "ommatidia", 1, 1 << 30))
        names = self.receptors
        if (
            isinstance(names, str)
            or not isinstance(names, Sequence)
            or not all(isinstance(one, str) for one in names)
        ):
            raise Error(f"receptors: expected a sequence of names, found {names!r:.40}")
        object.__setattr__(self, "receptors", tuple(names))
        if self.by == "achromatic" and len(names) != 1:
            raise Error(f"receptors: expected the one that is achromatic, found {tuple(names)}")
        noise = array_of(self.noise, "noise", (None,))
        if not np.all((noise > 0) & (noise < 1e9)):
            raise Error("noise: expected finite numbers above 0")
        expect_fractions(noise)
        object.__setattr__(self, "noise", tuple(noise.tolist()))


class Decision:
    """What an observer makes of what an eye sees of a target.

    ``most_polarisation`` is the largest polarisation sensitivity among the receptors that count.
    """

    def __init__(self, eye: Eye, observer: Observer) -> None:
        self._observer = observer
        types = eye.receptor_types  # a list made anew each time, of thousands for a fly
        of_types = [one.name for one in types]
        names = list(dict.fromkeys(of_types))
        number = {name: k for k, name in enumerate(names)}
        self._class_of_type = np.array([number[name] for name in of_types], np.int64)
        for name in observer.receptors:
            one_of(name, names, "receptors")
        if observer.noise and len(observer.noise) != len(names):
            raise Error(
                f"noise: expected {len(names)}, one for each class of receptors of the eye "
                f"({', '.join(names):.200}), found {len(observer.noise)}"
            )
        counts = [not observer.receptors or name in observer.receptors for name in names]
        self._counts = np.array(counts, bool)
        self._noise = np.array(observer.noise or [0.1] * len(names))
        self._names = names
        self._nearest: dict[int, Nearest] = {}
        used = [types[k] for k in np.unique(eye.receptor_type).tolist()]
        counted = [one for one in used if not observer.receptors or one.name in observer.receptors]
        self.most_polarisation = max((one.polarisation_sensitivity for one in counted), default=1.0)
        if observer.by != "photons" and len(eye) < observer.ommatidia:
            warn_caller(
                f"observer: expected {observer.ommatidia} ommatidia, over which catches are "
                f"summed, found {len(eye)}: the distance is by these",
                UserWarning,
            )

    def expect_classes(self, eye: Eye, view: View, farthest_m: float) -> None:
        """Raise `omma.Error` where the ommatidia that count at the farthest distance lack a class
        of receptors that does."""
        if self._observer.by == "photons" or not self._observer.receptors:
            return
        nearest = eye.take(view.nearest(self._observer.ommatidia, farthest_m))
        there = self._class_of_type[nearest.receptor_type]
        for k in np.flatnonzero(self._counts):
            if k not in there:
                raise Error(
                    f"ommatidia: expected some with the receptor {self._names[k]}, found none of "
                    f"the {self._observer.ommatidia} that look nearest to the target at "
                    f"{farthest_m:g} m; more ommatidia may have it"
                )

    def looking(self, view: View, nearest_m: float, sampling: Fixed, seed: int) -> Looking:
        """Those whose responses count, at this distance and beyond, by so many rays."""
        if self._observer.by == "photons":
            return view.through(view.reached(nearest_m), sampling, seed)
        key = sampling.samples
        if key not in self._nearest:
            self._nearest[key] = Nearest(view, self._observer.ommatidia, sampling, seed)
        return self._nearest[key]

    def excess(self, target: Looking, distance_m: float) -> tuple[float, float]:
        """By how much d' or the distance of colours is more than the criterion at a distance, and
        its standard error from the rays; infinite, where they are too few to tell."""
        seen = target.at(distance_m)
        found, slope = self._told(seen)
        # Receptors of an ommatidium share its rays, and err together.
        together = np.bincount(ommatidium_of_receptor(seen.eye), slope * seen.error)
        error = float(np.sqrt(np.sum(together**2))) if seen.enough else math.inf
        return found - self._observer.criterion, error

    def _told(self, seen: Seen) -> tuple[float, Floats]:
        """What is told, and how it changes with what the target adds to each receptor."""
        classes = self._class_of_type[seen.eye.receptor_type]
        if self._observer.by != "photons":
            return self._noise_limited(classes, seen)
        dark = self._observer.dark_per_s * self._observer.integration_time_s
        counts = self._counts[classes]
        variance = seen.background + seen.added / 2 + dark
        safe = np.where(variance > 0, variance, 1.0)
        # As of `d_prime`, without what errors of the rays add to squares.
        terms = (seen.added**2 - seen.error**2) / safe
        found = math.sqrt(max(float(terms[counts].sum()), 0.0))
        slope = seen.added / safe - (seen.added / safe) ** 2 / 4
        return found, np.where(counts, slope, 0.0) / (found or math.inf)

    def _noise_limited(self, classes: NDArray[np.integer], seen: Seen) -> tuple[float, Floats]:
        """Of catches summed by class of receptors."""
        count = len(self._names)
        ground: Floats = np.bincount(classes, seen.background, minlength=count).astype(np.float64)
        added: Floats = np.bincount(classes, seen.added, minlength=count).astype(np.float64)
        there = np.bincount(classes, minlength=count)
        used = self._counts if self._observer.receptors else there > 0
        if np.any(there[used] == 0):
            # Nearer than where it is sure that a class is there it may be missing: nothing is told.
            return 0.0, np.zeros(len(classes))
        self._expect_photons(used, ground)
        dark = self._observer.dark_per_s * self._observer.integration_time_s
        ground = ground + dark * there

        def distance(more: Floats) -> Floats:
            # A target that gives no light at all has no logarithm.
            seen = np.maximum(ground + more, 1e-9 * ground)[..., used]
            if self._observer.by == "colour":
                return distance_of_many(
                    seen, ground[used], self._noise[used], signal="log", photon_noise=True
                )
            noise = float(self._noise[used][0])
            return distance_of_one(seen[..., 0], ground[used][0], noise, photon_noise=True)

        found = float(distance(added))
        step = _STEP * ground * np.eye(count)
        rise = distance(added + step) - distance(added - step)
        slope = np.divide(rise, 2 * _STEP * ground, out=np.zeros(count), where=used)
        return found, slope[classes]

    def _expect_photons(self, used: NDArray[np.bool_], ground: Floats) -> None:
        dark = np.flatnonzero(used & ~(ground > 0))
        if len(dark):
            raise Error(
                f"target: expected photons of its ground in {self._names[dark[0]]}, found none in "
                f"those of the {self._observer.ommatidia} that look nearest to the target: give "
                "the ground a reflectance above 0, and light that they see"
            )
