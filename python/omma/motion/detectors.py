"""Arrays of Hassenstein-Reichardt detectors: each compares two ommatidia, one of them delayed.

Of the first and the second of a pair, both arms are delayed by a low-pass, each is multiplied by
the undelayed other, and the products are subtracted (Hassenstein & Reichardt 1956, Z Naturforsch
11b:513; Reichardt 1961, in Sensory Communication, ed. Rosenblith, MIT Press, 303):

    R = late(first) now(second) - now(first) late(second)

which is above 0 on average where patterns move from the first to the second.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye
from omma.base.arguments import Shape, array_of, checked, whole
from omma.base.arrays import Floats, Ints
from omma.base.slips import warn_of_slip
from omma.base.values import value_class
from omma.motion.filters import FilterStep, filter_step
from omma.motion.pairs import displacements_rad, neighbour_pairs

# Least ratio of the eigenvalues of an ommatidium's pair directions (35°): below it, its pairs lie
# so nearly along one line that motion across it is not measured.
_LEAST_SPREAD = 0.1


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class DetectorState:
    """What detectors remember from frame to frame, of each ommatidium (N,) or (N, B).

    frame: the last frame, radiance; slow: its low-pass, which the high-pass takes away (0 where
    there is none); late: the delayed arm. filters: (tau_s, high_pass_tau_s, frame_rate_hz) of the
    detectors whose it is; None: of any, nothing is compared.
    """

    frame: Floats
    slow: Floats
    late: Floats
    filters: tuple[float, float | None, float] | None = None


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class DetectorArray:
    """E detectors over N ommatidia, for frames at a fixed rate; `detector_array` makes one.

    Attributes:
        count: N.
        pairs: (E, 2), first and second ommatidium of each detector.
        displacement_rad: (E, 2, 2), where the second looks, seen from the first, [:, 0], and the
            first from the second, [:, 1]: right and up in the frame of who looks, rad.
        tau_s: time constant of the delay.
        frame_rate_hz: of the frames.
        high_pass_tau_s: time constant of the high-pass before both arms; None: there is none.
    """

    count: int
    pairs: Ints
    displacement_rad: Floats
    tau_s: float
    frame_rate_hz: float
    high_pass_tau_s: float | None = None

    def __post_init__(self) -> None:
        whole(self.count, "count", 1, 2**31 - 1)
        pairs = array_of(self.pairs, "pairs", (None, 2), np.int64)
        _check_pairs(pairs, self.count)
        name = "displacement_rad"
        where = array_of(self.displacement_rad, name, (len(pairs), 2, 2), finite=True)
        object.__setattr__(self, "pairs", pairs)
        object.__setattr__(self, name, where)
        self._filters  # noqa: B018  (checks the time constants)

    def __len__(self) -> int:
        """How many detectors there are."""
        return len(self.pairs)

    @checked
    def step(self, state: DetectorState | None, frame: ArrayLike) -> tuple[DetectorState, Floats]:
        """The outputs at a frame, from what was remembered at the one before.

        Args:
            state: what the last call returned, of detectors with the same time constants and frame
                rate; None at the first frame, before which the world is taken to have always been
                as it shows it.
            frame: responses (N,) or (N, B), bands each for itself; or of B environments that step
                together.

        Returns:
            (state, outputs): outputs (E,) or (E, B), radiance squared.

        Raises:
            omma.Error: a wrong shape, numbers that are not finite, or the state of detectors with
                other time constants or another frame rate.
        """
        now = array_of(frame, "frame", [(self.count,), (self.count, "B")], finite=True)
        # A copy: the caller may render the next frame into the same array.
        after = self._at_rest(now.copy()) if state is None else self._next(state, now.copy())
        direct = after.frame - after.slow
        first, second = self.pairs.T
        outputs = after.late[first] * direct[second] - direct[first] * after.late[second]
        return after, outputs

    @checked
    def run(self, responses: ArrayLike) -> Floats:
        """The outputs at each of many frames, the same bits as frame by frame with `step`.

        Args:
            responses: (T, N) or (T, N, B), bands each for itself.

        Returns:
            (T, E) or (T, E, B), radiance squared; 0 at the first frame.

        Raises:
            omma.Error: a wrong shape, or numbers that are not finite.
        """
        shapes: list[Shape] = [("T", self.count), ("T", self.count, "B")]
        frames = array_of(responses, "responses", shapes, dtype=None)
        outputs = np.empty((len(frames), len(self), *frames.shape[2:]))
        state = None
        for t, frame in enumerate(frames):
            state, outputs[t] = self.step(state, frame)
        return outputs

    @checked
    def vectors(self, outputs: ArrayLike, *, axis: int | None = None) -> Floats:
        """The local motion at each ommatidium, from the outputs of its own detectors.

        It is the vector m that fits them best, R = m·d, d being the way from the first to the
        second in the ommatidium's own frame, in units of its detectors' mean length; a detector
        counts for both of its ommatidia. Its direction is that in which coarse patterns move across
        their stripes, its length the output of a detector that lies that way; it is no velocity.

        Args:
            outputs: (..., E, ...), of `step` or `run`.
            axis: which axis of them is that of detectors. None: the last, or the one before it
                where that has E and the last, of bands or environments, has not.

        Returns:
            (..., N, ..., 2): right and up, radiance squared. NaN where an ommatidium's pairs do not
            lie in two directions.

        Raises:
            omma.Error: another number of outputs; as many bands or environments as detectors, and
                no axis said.
        """
        given = array_of(outputs, "outputs")
        if given.ndim == 0:
            raise Error("outputs: expected an array with an axis of detectors, found one number")
        if axis is None:
            axis = self._axis_of(given)
        axis = whole(axis, "axis", -given.ndim, given.ndim - 1)
        if given.shape[axis] != len(self):
            raise Error(
                f"outputs: expected {len(self)} along axis {axis}, found {given.shape[axis]}"
            )
        moved = np.moveaxis(given, axis, 0)
        which, weight = self._fits
        total = np.zeros((self.count, *moved.shape[1:], 2))
        rest = (1,) * (moved.ndim - 1)
        for k in range(which.shape[1]):
            one = moved[which[:, k]]
            total += weight[:, k].reshape(self.count, *rest, 2) * one[..., None]
        return np.moveaxis(total, 0, axis if axis >= 0 else axis - 1)

    def _axis_of(self, outputs: Floats) -> int:
        fits = [axis for axis in (-1, -2)[: outputs.ndim] if outputs.shape[axis] == len(self)]
        if not fits:
            raise Error(
                f"outputs: expected {len(self)} detectors along the last axis or the one before "
                f"it, found shape {outputs.shape}"
            )
        if len(fits) > 1:
            raise Error(
                f"axis: expected -1 or -2, which axis is that of {len(self)} detectors, as both "
                f"are so long, found None for outputs of shape {outputs.shape}"
            )
        return fits[0]

    def _at_rest(self, frame: Floats) -> DetectorState:
        # As if the frame had stood still for ever.
        none = np.zeros_like(frame)
        if self.high_pass_tau_s is None:
            return DetectorState(frame, none, frame, self._own)
        return DetectorState(frame, frame, none, self._own)

    def _next(self, then: DetectorState, frame: Floats) -> DetectorState:
        if then.filters is not None and tuple(then.filters) != self._own:
            raise Error(
                f"state: expected that of detectors with {_words(self._own)}, found that of "
                f"detectors with {_words(then.filters)}"
            )
        if then.frame.shape != frame.shape:
            raise Error(f"frame: expected shape {then.frame.shape} as before, found {frame.shape}")
        f = self._filters
        high, rise = then.frame - then.slow, frame - then.frame
        slow = then.slow + f.slow_gain * high + f.slow_rise * rise
        late = then.late + f.late_gain * (high - then.late) + f.late_more * high
        late += f.late_rise * rise
        return DetectorState(frame, slow, late, self._own)

    @property
    def _own(self) -> tuple[float, float | None, float]:
        high = None if self.high_pass_tau_s is None else float(self.high_pass_tau_s)
        return float(self.tau_s), high, float(self.frame_rate_hz)

    @cached_property
    def _filters(self) -> FilterStep:
        return filter_step(self.tau_s, self.high_pass_tau_s, self.frame_rate_hz)

    @cached_property
    def _fits(self) -> tuple[Ints, Floats]:
        # Of each ommatidium its detectors (N, K), filled up with 0, and the weights (N, K, 2) with
        # which their outputs are added, 0 where filled up.
        owner = self.pairs.T.ravel()
        detector = np.tile(np.arange(len(self)), 2)
        # Seen from the second, the way on is away from the first.
        step = np.concatenate([self.displacement_rad[:, 0], -self.displacement_rad[:, 1]])
        order = np.argsort(owner, kind="stable")
        owner, detector, step = owner[order], detector[order], step[order]
        slot = np.arange(len(owner)) - np.searchsorted(owner, owner)
        which = np.zeros((self.count, slot.max() + 1), np.int64)
        steps = np.zeros((*which.shape, 2))
        which[owner, slot], steps[owner, slot] = detector, step
        length = np.hypot(steps[..., 0], steps[..., 1])
        members = np.maximum((length > 0).sum(axis=1), 1)
        mean = length.sum(axis=1) / members
        inverse, spread = _inverse(steps / np.where(length > 0, length, 1)[..., None])
        steps = steps / np.where(mean > 0, mean, 1)[:, None, None]
        inverse, _ = _inverse(steps)
        weight = np.einsum("nij,nkj->nki", inverse, steps)
        weight[spread < _LEAST_SPREAD] = np.nan
        return which, weight


@checked
def detector_array(
    eye: Eye,
    tau_s: float,
    frame_rate_hz: float,
    *,
    pairs: ArrayLike | None = None,
    high_pass_tau_s: float | None = None,
) -> DetectorArray:
    """Hassenstein-Reichardt detectors between ommatidia of an eye.

    Between frames responses are taken as straight lines; for such inputs the filters are exact.

    Args:
        eye: whose responses the frames are.
        tau_s: time constant of the first-order low-pass that delays, s.
        frame_rate_hz: frames a second.
        pairs: (E, 2), first and second ommatidium of each detector, whose preferred direction is
            from the first to the second. None: all neighbours (`neighbour_pairs`).
        high_pass_tau_s: time constant of a first-order high-pass before both arms, which takes
            away the mean light. None: there is none.

    Example:
        >>> eye = omma.eye.generate_eye(200)
        >>> detectors = omma.motion.detector_array(eye, 0.035, 500)
        >>> bool(detectors.run(np.ones((3, 200))).any())  # nothing moves
        False

    Raises:
        omma.Error: pairs of ommatidia that there are not, time constants that are not above 0 or
            no match for the frame rate, an eye without a hexagonal lattice and no pairs given.

    Warns:
        UserWarning: time constants above 5 s, or a frame rate below 1 Hz.
    """
    if pairs is None:
        chosen = neighbour_pairs(eye)
    else:
        chosen = array_of(pairs, "pairs", (None, 2), np.int64)
        _check_pairs(chosen, len(eye))
    where = displacements_rad(eye, chosen)
    made = DetectorArray(len(eye), chosen, where, tau_s, frame_rate_hz, high_pass_tau_s)
    for name in ("tau_s", "high_pass_tau_s"):
        if getattr(made, name) is not None:
            warn_of_slip("time constant", getattr(made, name), name)
    warn_of_slip("frames per second", made.frame_rate_hz, "frame_rate_hz")
    return made


def _words(filters: tuple[float, float | None, float]) -> str:
    names = ("tau_s", "high_pass_tau_s", "frame_rate_hz")
    return ", ".join(f"{name} {value}" for name, value in zip(names, filters, strict=True))


def _check_pairs(pairs: Ints, count: int) -> None:
    if len(pairs) == 0:
        raise Error("pairs: expected at least one, found none")
    wrong = np.flatnonzero((pairs < 0).any(axis=1) | (pairs >= count).any(axis=1))
    if len(wrong):
        raise Error(
            f"pairs: expected ommatidia from 0 to {count - 1}, found {pairs[wrong[0]].tolist()}"
        )
    same = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
    if len(same):
        raise Error(f"pairs: expected two ommatidia, found {pairs[same[0]].tolist()}")


def _inverse(steps: Floats) -> tuple[Floats, Floats]:
    # Of the sum of squares of vectors (N, K, 2): its inverse (N, 2, 2) and the ratio of its
    # eigenvalues, the smaller to the larger; 0 and any inverse where they lie in a line.
    square = np.einsum("nki,nkj->nij", steps, steps)
    a, b, c = square[:, 0, 0], square[:, 0, 1], square[:, 1, 1]
    middle, half = (a + c) / 2, np.hypot((a - c) / 2, b)
    ratio = np.maximum(middle - half, 0) / np.where(middle > 0, middle + half, 1)
    determinant = a * c - b * b
    adjugate = np.stack([np.stack([c, -b], axis=-1), np.stack([-b, a], axis=-1)], axis=-2)
    return adjugate / np.where(determinant > 0, determinant, 1)[:, None, None], ratio
