"""Frames that are held from one refresh to the next, as receptors see them that take their time.

A frame stands still while it is held, so that ∫ h(τ) L(t - τ) dτ is a sum over the frames that h
sees: each as it stands, times the integral of h over the time for which it was there. No delay is
drawn for it, whatever the number of rays. Where the head moves meanwhile, rays draw theirs within
the time of the frame alone.
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
from omma.base.velocities import poses_between
from omma.photoreceptors import ImpulseResponse

Counts = NDArray[np.int64]

# A time that is a refresh but for rounding counts as after it.
ROUNDING = 1e-6
# That one time may see, and that are worked on together.
_MOST_REFRESHES = 1 << 20
# Delays at which a moving head's way is told, evenly over the impulse response.
_NODES = 129


@dataclass(frozen=True)
class _Spans:
    """What some times (T,) see, one row for each frame of each: S of them."""

    of_time: Counts
    key: Counts
    frame: Counts
    until_s: Floats
    since_s: Floats
    weight: Floats


@dataclass(frozen=True)
class Held:
    """Frames of a display and a head at growing times (T,), s, and before them, when it stood.

    Args:
        times_s, poses: (T,) and (T, 4, 4), ``world_from_head``.
        response: h.
        refresh_hz: at times k / refresh_hz another frame may come.
        frames: from counts k (M,) to the numbers of the frames that are shown from then on, (M,).
        transforms: from numbers of frames (M,) to where things are, (M, K, 4, 4).
        repeated: whether a frame that comes again is seen by the same rays.
    """

    times_s: Floats
    poses: Matrices
    response: ImpulseResponse
    refresh_hz: float
    frames: Callable[[Counts], Counts]
    transforms: Callable[[Counts], Floats]
    repeated: bool

    def render(
        self,
        render: Callable[..., NDArray[np.float32]],
        instances: list[int],
        progress: Progress | None,
    ) -> NDArray[np.float32]:
        """Responses (T, N, B), by a call of a renderer's ``render`` for each frame that is seen by
        a head at rest, and for each that one time sees of a head on its way.

        Raises:
            omma.Error: more than a million refreshes in what one time sees.
        """
        count, seen = len(self.times_s), self.response.duration_s * self.refresh_hz + 2
        if seen > _MOST_REFRESHES:
            raise Error(
                f"times_s: expected at most {_MOST_REFRESHES:,} refreshes within "
                f"{self.response.duration_s:.3g} s of the impulse response, found {seen:.3g}"
            )
        together = int(_MOST_REFRESHES // seen)
        pieces = [
            self._render_some(
                render, instances, slice(first, min(first + together, count)),
                share_of(progress, first / count, min(first + together, count) / count),
            )
            for first in range(0, count, together)
        ]  # fmt: skip
        if not pieces:
            none = self.transforms(np.empty(0, np.int64))
            return render(self.poses, times_s=[], instances=instances, transforms=none)
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    def _render_some(
        self,
        render: Callable[..., NDArray[np.float32]],
        instances: list[int],
        some: slice,
        progress: Progress | None,
    ) -> NDArray[np.float32]:
        spans = self._spans(some)
        rows = np.lexsort((spans.of_time, spans.key))
        starts = np.flatnonzero(np.append(True, np.diff(spans.key[rows]) != 0))
        alike = np.split(rows, starts[1:])
        total: Floats | None = None
        for done, same in enumerate(alike):
            piece = render(
                **self._view(spans, int(same[0])),
                instances=instances,
                transforms=self.transforms(spans.frame[same[:1]]),
                progress=share_of(progress, done / len(alike), (done + 1) / len(alike)),
            )[0]
            if total is None:
                total = np.zeros((some.stop - some.start, *piece.shape))
            for row in same:
                total[spans.of_time[row] - some.start] += spans.weight[row] * piece
        assert total is not None
        return total.astype(np.float32)

    def _spans(self, some: slice) -> _Spans:
        """What these times see; rows of one key are seen alike."""
        found = [self._seen_at(float(time_s)) for time_s in self.times_s[some]]
        sizes = [len(one[0]) for one in found]
        counts, frames, until_s, since_s, weight = (
            np.concatenate(part) for part in zip(*found, strict=True)
        )
        of_time = np.repeat(np.arange(some.start, some.stop), sizes)
        now = self.times_s[of_time]
        # The poses between which the head was; before the first time it stood still.
        changed = np.append(False, (self.poses[1:] != self.poses[:-1]).any(axis=(1, 2)))
        stand = np.cumsum(changed)
        last = len(stand) - 1
        before = np.clip(np.searchsorted(self.times_s, now - since_s, "right") - 1, 0, last)
        after = np.clip(np.searchsorted(self.times_s, now - until_s), 0, last)
        alike = np.stack([stand[after], frames if self.repeated else counts], -1)
        _, key = np.unique(alike, axis=0, return_inverse=True)
        key = np.asarray(key.reshape(-1), np.int64)
        moving = stand[before] != stand[after]
        key[moving] = key.max(initial=0) + 1 + np.arange(np.count_nonzero(moving))
        return _Spans(of_time, key, frames, until_s, since_s, weight)

    def _seen_at(self, time_s: float) -> tuple[Counts, Counts, Floats, Floats, Floats]:
        """Of each frame that is seen at a time, the oldest first: the count of its refresh, its
        number, since when it is gone and since when it was there, s, and how much it counts."""
        first_s = time_s - self.response.duration_s
        first, last = (int(np.floor(one * self.refresh_hz + ROUNDING)) for one in (first_s, time_s))
        counts = np.arange(first, last + 1)
        frames = self.frames(counts)
        begins = np.flatnonzero(np.append(True, frames[1:] != frames[:-1]))
        counts, frames = counts[begins], frames[begins]
        since_s = np.clip(time_s - counts / self.refresh_hz, 0, self.response.duration_s)
        since_s[0] = self.response.duration_s
        until_s = np.append(since_s[1:], 0.0)
        reached = self.response.cumulative(since_s)
        # What h has left after it ends goes to the oldest, as of a renderer.
        reached[0] = 1.0
        weight = reached - self.response.cumulative(until_s)
        seen = weight != 0
        return counts[seen], frames[seen], until_s[seen], since_s[seen], weight[seen]

    def _view(self, spans: _Spans, row: int) -> dict[str, Any]:
        """Pose, time and past with which a renderer sees what the head met while a frame was held.

        The renderer draws delays τ from all of h. It is told of a head that is, τ before the frame,
        where the true one was at the delay that h reaches at the same share of the frame's time.
        """
        delays = np.linspace(self.response.duration_s, 0.0, _NODES)
        reached = self.response.cumulative(delays)
        share = reached / reached[0]
        until, since = spans.until_s[row], spans.since_s[row]
        low, high = self.response.cumulative(np.array([until, since]))
        true = np.clip(self.response.quantile(low + share * (high - low)), until, since)
        when = np.maximum(self.times_s[spans.of_time[row]] - true, self.times_s[0])
        poses = poses_between(self.poses, self.times_s, when)
        view: dict[str, Any] = {"poses": poses[-1:], "times_s": [0.0]}
        if not (poses == poses[-1]).all():
            view["past"] = (poses[:-1], -delays[:-1])
        return view
