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
from omma.base.values import value_class
from omma.colour_vision.noise_limited import achromatic_distance, noise_limited_distance
from omma.colour_vision.views import Looking, Seen, View
from omma.receptors.sensitivity import ommatidium_of_receptor

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
        receptors: names of the receptor types that count for "photons", such as ("green",), (): all
            of them; for "achromatic" the one that does.
        dark_per_s: photons that each receptor counts in darkness.
        noise: e of each receptor type of the eye, in their order, as `class_noise` gives it, for
            all but "photons"; (): 0.1 of each.
        ommatidia: over how many that look nearest to the target catches are summed, for all but
            "photons".
        azimuth_deg, elevation_deg: where in the head's field the target is kept.

    Raises:
        omma.Error: a number out of its range.
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
        object.__setattr__(self, "noise", tuple(noise.tolist()))


class Decision:
    """What an observer makes of what an eye sees of a target."""

    def __init__(self, eye: Eye, observer: Observer) -> None:
        self._observer = observer
        names = [one.name for one in eye.receptor_types]
        for name in observer.receptors:
            one_of(name, names, "receptors")
        if observer.noise and len(observer.noise) != len(names):
            raise Error(
                f"noise: expected {len(names)}, one for each receptor type of the eye, found "
                f"{len(observer.noise)}"
            )
        counts = [not observer.receptors or name in observer.receptors for name in names]
        self._counts = np.array(counts, bool)
        self._noise = np.array(observer.noise or [0.1] * len(names))
        self._names = names

    def ommatidia(self, view: View, nearest_m: float) -> NDArray[np.intp]:
        """Whose responses count, at this distance and beyond."""
        if self._observer.by != "photons":
            return view.nearest(self._observer.ommatidia)
        return view.reached(nearest_m)

    def excess(self, target: Looking, distance_m: float) -> tuple[float, float]:
        """By how much d' or the distance of colours is more than the criterion at a distance, and
        its standard error from the rays; infinite, where they are too few to tell."""
        seen = target.at(distance_m)
        found, slope = self._told(target.eye, seen)
        # Receptors of an ommatidium share its rays, and err together.
        together = np.bincount(ommatidium_of_receptor(target.eye), slope * seen.error)
        error = float(np.sqrt(np.sum(together**2))) if seen.enough else math.inf
        return found - self._observer.criterion, error

    def _told(self, eye: Eye, seen: Seen) -> tuple[float, Floats]:
        """What is told, and how it changes with what the target adds to each receptor."""
        if self._observer.by != "photons":
            return self._noise_limited(eye.receptor_type, seen)
        dark = self._observer.dark_per_s * self._observer.integration_time_s
        counts = self._counts[eye.receptor_type]
        variance = seen.background + seen.added / 2 + dark
        safe = np.where(variance > 0, variance, 1.0)
        # As of `d_prime`, without what errors of the rays add to squares.
        terms = (seen.added**2 - seen.error**2) / safe
        found = math.sqrt(max(float(terms[counts].sum()), 0.0))
        slope = seen.added / safe - (seen.added / safe) ** 2 / 4
        return found, np.where(counts, slope, 0.0) / (found or math.inf)

    def _noise_limited(self, types: NDArray[np.integer], seen: Seen) -> tuple[float, Floats]:
        """Of catches summed by receptor type."""
        count = len(self._names)
        ground: Floats = np.bincount(types, seen.background, minlength=count).astype(np.float64)
        added: Floats = np.bincount(types, seen.added, minlength=count).astype(np.float64)
        used = np.full(count, True) if self._observer.by == "colour" else self._counts
        for name, photons in zip(np.array(self._names)[used], ground[used], strict=True):
            if not photons > 0:
                raise Error(
                    f"ommatidia: expected photons of the ground in every receptor type, found none "
                    f"in {name} of the {self._observer.ommatidia} that look nearest to the target; "
                    "more ommatidia may have them"
                )
        dark = self._observer.dark_per_s * self._observer.integration_time_s
        ground = ground + dark * np.bincount(types, minlength=count)

        def distance(more: Floats) -> Floats:
            # A target that gives no light at all has no logarithm.
            seen = np.maximum(ground + more, 1e-9 * ground)[..., used]
            if self._observer.by == "colour":
                return noise_limited_distance(seen, ground, self._noise, photon_noise=True)
            noise = float(self._noise[used][0])
            return achromatic_distance(seen[..., 0], ground[used][0], noise, photon_noise=True)

        found = float(distance(added))
        step = _STEP * ground * np.eye(count)
        slope = (distance(added + step) - distance(added - step)) / (2 * _STEP * ground)
        return found, np.where(used, slope, 0.0)[types]
