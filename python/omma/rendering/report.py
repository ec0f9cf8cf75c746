"""What a render with an error to reach spent, and who did not reach it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from omma.base.values import value_class
from omma.rendering.settings import ToError

# Ommatidia that are named where many missed the error.
_NAMED = 8


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class SamplingReport:
    """Rays and standard errors of a render with `omma.ToError`.

    Errors are estimated from the rays themselves, mostly a little too large. They tell nothing of
    what an ommatidium's rays and those around it all missed: of those that reached the error about
    one true error in 200 is more than twice it, see docs/sampling.md.
    """

    rays: NDArray[np.int32]
    """Rays spent, (P, N)."""
    standard_error: NDArray[np.float32]
    """Estimated standard error of each response, (P, N, C), radiance."""
    error: float
    """Standard error that was to be reached, radiance; 0: a relative one alone."""
    relative_error: float = 0.0
    """The same as a fraction of each response; the larger of both counts."""
    wanted: NDArray[np.float32] | None = None
    """Where there is a relative error: the standard error each response was to reach, (P, N, C)."""

    @property
    def total_rays(self) -> int:
        """Rays of all ommatidia at all poses."""
        return int(self.rays.sum(dtype=np.int64))

    @property
    def mean_rays(self) -> float:
        """Rays per ommatidium and pose."""
        return self.total_rays / max(1, self.rays.size)

    @property
    def missed(self) -> NDArray[np.int64]:
        """Whose estimate is larger than was asked for: (M, 2), pose and ommatidium. They had all
        rays, or more do not help, as of what baked light errs by."""
        wanted = np.float32(self.error) if self.wanted is None else self.wanted
        return np.argwhere((self.standard_error > wanted).any(axis=-1))

    def __str__(self) -> str:
        spent = SpentRays(self.error, self.relative_error)
        spent.add(self, 0)
        return f"{spent.rays_text()}; {spent.missed_text()}"


def report_of(
    target: ToError,
    responses: NDArray[np.float32],
    standard_error: NDArray[np.float32],
    rays: NDArray[np.int32],
) -> SamplingReport:
    """What a render to an error came to."""
    error, relative = target.error or 0.0, target.relative_error or 0.0
    wanted = None
    if relative > 0:
        wanted = np.maximum(np.float32(error), np.float32(relative) * np.abs(responses))
    return SamplingReport(rays, standard_error, error, relative, wanted)


@dataclass
class SpentRays:
    """What reports of the pieces of one render come to."""

    error: float
    relative_error: float = 0.0
    poses: int = 0
    responses: int = 0
    """Ommatidia times poses."""
    total: int = 0
    least: int = 0
    most: int = 0
    missed: int = 0
    """Responses that did not reach the error."""
    first_missed: list[tuple[int, int]] = field(default_factory=list)
    """The first of them: pose and ommatidium."""

    def add(self, report: SamplingReport, first_pose: int) -> None:
        """Add the report of the poses from ``first_pose`` on."""
        rays, missed = report.rays, report.missed
        if rays.size > 0:
            least = int(rays.min())
            self.least = min(self.least, least) if self.responses else least
            self.most = max(self.most, int(rays.max()))
        self.poses += len(rays)
        self.responses += rays.size
        self.total += report.total_rays
        self.missed += len(missed)
        for pose, ommatidium in missed[: max(0, _NAMED - len(self.first_missed))].tolist():
            self.first_missed.append((first_pose + pose, ommatidium))

    def rays_text(self) -> str:
        """Rays spent, in words."""
        mean = self.total / max(1, self.responses)
        return f"{self.total:,} rays, {mean:,.1f} an ommatidium ({self.least:,} to {self.most:,})"

    def target_text(self) -> str:
        """The error that was to be reached, in words."""
        targets = [f"{self.error:g}"] if self.error > 0 else []
        if self.relative_error > 0:
            targets.append(f"{100 * self.relative_error:g} % of the response")
        return " or ".join(targets)

    def missed_text(self) -> str:
        """Who did not reach the error, in words."""
        target = self.target_text()
        if self.missed == 0:
            return f"all {self.responses:,} responses reached {target} (estimated)"
        named = ", ".join(
            f"{ommatidium} (pose {pose})" if self.poses > 1 else str(ommatidium)
            for pose, ommatidium in self.first_missed
        )
        more = ", ..." if self.missed > len(self.first_missed) else ""
        which = "ommatidium" if self.missed == 1 else "ommatidia"
        return (
            f"{self.missed:,} of {self.responses:,} responses did not reach {target} "
            f"(estimated): {which} {named}{more}"
        )
