"""How the things of stimuli move, and frames that last while they do.

Between frames a renderer takes things to go straight and turn evenly, and to stand still before the
first. A stimulus knows better: where things jump it tells the renderer of just before and just
after, so that the way between is gone in no time, where they go round a bend of the bend, and of
what was before the first frame. These moments are not rendered, a renderer knows them as its past.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats
from omma.base.poses import Matrices
from omma.base.progress import Progress, share_of
from omma.base.velocities import poses_between, times_about, velocities_between
from omma.stimuli.shapes import roll

# Linear velocities, m/s, and angular ones, rad/s, of K things: (T, K, 3) each.
Motion = tuple[Floats, Floats]

# Before and after a time: how fast things move then.
MOMENT_S = 1e-4
# From just before a jump to just after it; besides that, so many steps of the time's precision,
# as the time of a jump has some roundings.
_JUMP_S, _JUMP_STEPS = 1e-12, 16
# Of all in one interval; and the transforms of what one frame still sees, 128 bytes each.
_MOST_JUMPS, _MOST_TRANSFORMS = 1 << 20, 1 << 22
_OTHERWISE = (
    "; without an impulse response, play it at more times and filter what comes by "
    "omma.photoreceptors.filter_frames"
)


def turning(speeds_deg_s: Floats, direction_deg: float) -> Motion:
    """Of one thing that turns about the origin by so many degrees a second (T,), as `drifted`."""
    axis = -roll(direction_deg)[:3, 1]
    angular = (np.radians(speeds_deg_s)[:, None] * axis)[:, None]
    return np.zeros_like(angular), angular


def motion_of(
    transforms: Callable[[Floats], Floats], times_s: Floats, ends_s: tuple[float, float]
) -> Motion:
    """Of things without jumps that move between two ends: their transforms' (T, K, 4, 4) from a
    moment before to one after, at an end on the inner side."""
    _, earlier, later, _ = times_about(times_s, MOMENT_S, ends_s)
    before, after = transforms(earlier), transforms(later)
    steps = np.repeat(later - earlier, before.shape[1])
    linear, angular = velocities_between(before.reshape(-1, 4, 4), after.reshape(-1, 4, 4), steps)
    shape = (*before.shape[:2], 3)
    return linear.reshape(shape), angular.reshape(shape)


def even_steps(step_s: float, first_s: float, last_s: float) -> Floats:
    """Times between the first and the last, so many seconds apart or less: growing.

    Raises:
        omma.Error: more than a million.
    """
    count = (last_s - first_s) / step_s
    if count > _MOST_JUMPS:
        raise Error(
            f"times_s: expected at most {_MOST_JUMPS:,} quarter turns of the stimulus within "
            f"{last_s - first_s:.3g} s of the impulse response, found {count:.3g}{_OTHERWISE}"
        )
    return np.asarray(np.linspace(first_s, last_s, int(count) + 2)[1:-1])


def half_turn_s(speed_deg_s: float) -> float:
    """The time in which something turns by 180°, s."""
    return float(180 / abs(speed_deg_s)) if speed_deg_s else np.inf


def whole_counts(starts: Floats | float, rate_hz: float, first_s: float, last_s: float) -> Floats:
    """When ``start + rate_hz t`` is a whole number, of one or many starts, after the first and not
    after the last time: growing.

    Raises:
        omma.Error: more often than a million times.
    """
    each, of = abs(rate_hz) * (last_s - first_s), np.atleast_1d(starts)[:, None]
    if each == 0:
        return np.empty(0)
    if each * len(of) > _MOST_JUMPS:
        raise Error(
            f"times_s: expected at most {_MOST_JUMPS:,} jumps of the stimulus, found "
            f"{each * len(of):.3g}{_OTHERWISE}"
        )
    least = np.ceil(of + rate_hz * (first_s if rate_hz > 0 else last_s))
    times = np.unique((least + np.arange(int(each) + 2) - of) / rate_hz)
    return np.asarray(times[(times > first_s) & (times <= last_s)])


@dataclass(frozen=True)
class Path:
    """Where a head and K things are at growing times (T,), s, and before them: the head stood
    still, the things moved.

    Args:
        times_s, poses: (T,) and (T, 4, 4), ``world_from_head``.
        start_s: from when on the first frame sees things.
        jumps_s: when anything jumps, growing, from then on.
        bends_s: when anything turns to another way, growing, from then on.
        transforms: of times (M,) to where things are, (M, K, 4, 4).
        things: K.
    """

    times_s: Floats
    poses: Matrices
    start_s: float
    jumps_s: Floats
    bends_s: Floats
    transforms: Callable[[Floats], Floats]
    things: int

    def render(
        self,
        render: Callable[..., NDArray[np.float32]],
        instances: list[int],
        progress: Progress | None,
    ) -> NDArray[np.float32]:
        """Responses (T, N, B), by as many calls of a renderer's ``render`` as it takes for none to
        have a jump or a bend within it."""
        moments = self._moments()
        counts = len(self.times_s)
        # A frame before which there is any is the first of a call.
        told = np.searchsorted(self.times_s, moments)
        firsts = np.union1d([0], told[(told > 0) & (told < counts)]).tolist()
        pieces = []
        for first, end in zip(firsts, [*firsts[1:], counts], strict=True):
            options: dict[str, Any] = {"times_s": self.times_s[first:end]}
            if counts:
                options["past"] = self._past(first, moments)
            if len(firsts) > 1:
                # Frames of noise that is new in every one count on from call to call by themselves.
                options["progress"] = share_of(progress, first / counts, end / counts)
            else:
                options["progress"] = progress
            piece = render(
                self.poses[first:end],
                instances=instances,
                transforms=self.transforms(self.times_s[first:end]),
                **options,
            )
            pieces.append(piece)
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    def _moments(self) -> Floats:
        """Those besides the times of frames that say how things move: the start, bends, and just
        before and just after each jump."""
        half = _JUMP_S + _JUMP_STEPS * np.spacing(np.abs(self.jumps_s))
        around = [self.jumps_s - half, self.jumps_s + half]
        moments = np.concatenate([[self.start_s], self.bends_s, *around])
        return np.setdiff1d(moments, self.times_s)

    def _past(self, first: int, moments: Floats) -> tuple[Matrices, Floats, Floats]:
        """What the frame still sees, and one time before that: poses, times and transforms."""
        now, seen_s = self.times_s[first], self.times_s[0] - self.start_s
        known = np.union1d(self.times_s[:first], moments)
        known = known[known < now]
        known = known[max(0, int(np.searchsorted(known, now - seen_s)) - 1) :]
        if len(known) * self.things > _MOST_TRANSFORMS:
            raise Error(
                f"times_s: expected at most {_MOST_TRANSFORMS:,} transforms within "
                f"{seen_s:.3g} s of the impulse response, found {len(known):,} times of "
                f"{self.things:,} things that move{_OTHERWISE}"
            )
        # The head stood still before the first time.
        poses = poses_between(self.poses, self.times_s, np.maximum(known, self.times_s[0]))
        return poses, known, self.transforms(known)
