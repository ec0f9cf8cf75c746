"""How what responses have beside the mean of their rays changes with the eye: the discs of sun and
moon, and what ommatidia aim at, which rays leave out as they would find it by chance
(src/physics/block/eye_discs.h, aimed_rays.h).

It is the same points on the same discs for any eye, weighed by its sensitivity, and so is smooth in
widths and axes: central differences of eyes that are a little wider, narrower or turned, with the
same random numbers, are its derivatives.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from omma._core import Eye
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.base.poses import Matrices
from omma.rendering.call import Call, Prepared
from omma.rendering.settings import Fixed

# Steps by the width w: a difference is then off by (8 ln 2 ϑ/w · 0.005)²/6 of itself at the angle ϑ
# from the axis, 0.05 % at 2 w; axes are single precision, so that steps are no shorter than this.
_STEP_PER_WIDTH = 0.005
_LEAST_STEP_RAD = 3e-5


@dataclass(frozen=True)
class Beside:
    """What ommatidia see beside their rays in some frames of one pose each."""

    renderer: Prepared
    poses: Matrices
    first_frames: Sequence[int]
    """Of each pose; it has as many frames from there on as there are in `seen`."""
    seen: Floats
    """(P, frame, N, C)."""

    def by_width(self) -> Floats:
        """(P, frame, N, C), its derivative by acceptance angles, per rad."""
        eye = self.renderer.eye
        step = _steps(eye)
        around = []
        for sign in (1, -1):
            width = (eye.acceptance_angle_rad + sign * step).astype(np.float32)
            around.append(self._seen_by(eye.replace(acceptance_angle_rad=width)))
        return self._slopes(around, step)

    def by_axis(self) -> Floats:
        """(P, frame, N, C, 3), its derivative by axes, in the head's frame and across each axis."""
        eye = self.renderer.eye
        step = _steps(eye)
        axis = eye.axis.astype(np.float64)
        slope = np.zeros((*self.seen.shape, 3))
        for across in _across(axis):
            around = []
            for sign in (1, -1):
                turned = normalized(axis + sign * step[:, None] * across).astype(np.float32)
                around.append(self._seen_by(eye.replace(axis=turned)))
            slope += self._slopes(around, step)[..., None] * across[:, None, :]
        return slope

    def _seen_by(self, eye: Eye) -> Floats:
        """What another eye sees, by the same random numbers."""
        renderer = self.renderer.with_eye(eye, Fixed(1))
        seen = np.empty(self.seen.shape, np.float32)
        for pose, first, frames in zip(self.poses, self.first_frames, seen, strict=True):
            call = Call.of(renderer, np.repeat(pose[None], len(frames), axis=0), {}, first)
            call.render(call.new_frames(), beside_rays=frames)
        return seen.astype(np.float64)

    def _slopes(self, around: list[Floats], step: Floats) -> Floats:
        """(P, frame, N, C), from what is seen one step on and one step back.

        How many points there are on a disc, and whether an ommatidium aims at a thing at all, is
        chosen by what it may add, so that another width or axis may choose otherwise: a jump, of
        which the rays have the other side. On the side of the jump there is no difference to take.
        """
        on, back = around[0] - self.seen, self.seen - around[1]
        most = np.maximum(np.maximum(around[0], around[1]), self.seen)
        safe = np.where(most > 0, most, 1.0)
        smaller = np.where(np.abs(on) < np.abs(back), on, back)
        # Of a Gaussian the two differ by their square, and by its curvature, 8 ln 2 (step/width)².
        per_width = (step / self.renderer.eye.acceptance_angle_rad)[:, None]
        smooth = 4 * smaller**2 / safe + (8 * per_width**2 + 1e-6) * most
        jumps = np.abs(on - back) > smooth
        slope: Floats = np.where(jumps, smaller, 0.5 * (on + back)) / step[:, None]
        return slope


def _steps(eye: Eye) -> Floats:
    """(N,), rad."""
    steps: Floats = np.maximum(
        _STEP_PER_WIDTH * eye.acceptance_angle_rad.astype(np.float64), _LEAST_STEP_RAD
    )
    return steps


def _across(axis: Floats) -> Iterator[Floats]:
    """Two unit vectors (N, 3) across each axis and each other."""
    least = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    first = normalized(np.cross(axis, least))
    yield first
    yield np.cross(axis, first)
