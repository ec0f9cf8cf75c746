"""How heads and things move along a path of poses: linear and angular velocities."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.poses import Matrices, as_poses
from omma.base.warn import warn_caller

# So many times faster than before and after is a jump: what goes on steadily, or turns round at a
# moment, is not faster in its middle than on both sides.
_JUMP = 10.0

# So near to half a turn, either way is as short as angles of six digits say.
_HALF_TURN_RAD = 1e-5


@checked
def velocities_from_poses(
    poses: ArrayLike | tuple[ArrayLike, ArrayLike], times_s: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Linear velocities (P, 3), m/s, and angular ones (P, 3), rad/s, of a frame along its path.

    In the world's frame, the angular one right-handed about its vector. Between two poses the frame
    goes straight and turns evenly (slerp), by the shorter way; at a pose the velocity is that
    before and that after it, each weighted by the time of the other, and at the ends the one there
    is. Poses of things, ``world_from_node``, are as good as poses of heads. How a frame grows or is
    stretched is not in them.

    Args:
        poses: (P, 4, 4), two or more, or (positions (P, 3), quaternions (P, 4)).
        times_s: (P,), s, growing.

    Example:
        >>> poses = omma.poses_from_angles([(0, 0, 0), (0, 0, -0.1)], [(0, 0, 0), (1, 0, 0)])
        >>> linear, angular = omma.velocities_from_poses(poses, [0, 0.01])
        >>> linear[0].tolist(), np.degrees(angular[0]).round(3).tolist()
        ([0.0, 0.0, -10.0], [0.0, -100.0, 0.0])

    Raises:
        omma.Error: fewer than two poses, times that do not grow, another shape, a pose that
            flattens.

    Warns:
        UserWarning: half a turn from one pose to the next, which may go either way.
    """
    matrices = as_poses(poses)
    count = len(matrices)
    if count < 2:
        raise Error(f"poses: expected two or more, found {count}")
    times = array_of(times_s, "times_s", (count,))
    steps = np.diff(times)
    if not (np.isfinite(times).all() and (steps > 0).all()):
        raise Error("times_s: expected finite times that grow, found others")
    if not np.isfinite(matrices).all():
        raise Error("poses: expected finite numbers")
    linear = np.diff(matrices[:, :3, 3], axis=0) / steps[:, None]
    turns = _nearest_turns(matrices)
    turned = _rotation_vectors(turns[:-1], turns[1:])
    _warn_of_half_turns(turned)
    angular = turned / steps[:, None]
    return _at_poses(linear, steps), _at_poses(angular, steps)


def velocities_between(
    before: Matrices, after: Matrices, step_s: float | NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Linear velocities (P, 3), m/s, and angular ones (P, 3), rad/s, in the world, of frames that
    go straight and turn evenly from ``before`` to ``after``, (P, 4, 4), in ``step_s``, one or (P,);
    0 where that is 0.
    """
    steps = np.broadcast_to(np.asarray(step_s, np.float64), len(before))[:, None]
    rate_hz = np.divide(1.0, steps, out=np.zeros_like(steps), where=steps > 0)
    linear = (after[:, :3, 3] - before[:, :3, 3]) * rate_hz
    turns = _rotation_vectors(_nearest_turns(before), _nearest_turns(after))
    return linear, turns * rate_hz


def times_about(
    times_s: NDArray[np.float64], step_s: float, ends_s: tuple[float, float]
) -> NDArray[np.float64]:
    """Two times before and two after each of some (P,), from 2 steps before to 2 after: (4, P).

    None are beyond the end, of a motion that begins and ends, on whose side a time is; at an end
    and between them they are those of the motion. Instead of two before or after of which there is
    no room for both there is the nearer one twice.
    """
    first, last = ends_s
    # Ends are rounded to float32 in files, and times are sums.
    begins, stops = (abs(end) * 2.0**-23 + 1e-3 * step_s for end in ends_s)
    is_early, is_late = times_s < first - begins, times_s > last + stops
    low = np.where(is_early, -np.inf, np.where(is_late, last, first))
    high = np.where(is_late, np.inf, np.where(is_early, first, last))
    at = np.clip(times_s, low, high)
    before, after = np.maximum(at - step_s, low), np.minimum(at + step_s, high)
    two_before = np.where(at - 2 * step_s >= low, at - 2 * step_s, before)
    two_after = np.where(at + 2 * step_s <= high, at + 2 * step_s, after)
    return np.stack([two_before, before, after, two_after])


def velocities_about(
    places: NDArray[np.float64], times_s: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The same of moments, from where frames are (4, P, 4, 4) at the `times_about` them (4, P).

    What is far faster from just before a moment to just after than on either side has jumped, and
    has the velocity of the two sides, or of the one that there is.
    """
    steps = np.diff(times_s, axis=0)
    parts = [velocities_between(places[k], places[k + 1], steps[k]) for k in range(3)]
    sides = np.sum(steps[::2] > 0, axis=0)[:, None]
    linear, angular = (
        _without_jumps(before, across, after, sides)
        for before, across, after in zip(*parts, strict=True)
    )
    return linear, angular


def _without_jumps(
    before: NDArray[np.float64],
    across: NDArray[np.float64],
    after: NDArray[np.float64],
    sides: NDArray[np.integer],
) -> NDArray[np.float64]:
    """Of velocities (P, 3), where so many sides (P, 1) are known; those that are not are 0."""
    speeds = [np.linalg.norm(one, axis=1, keepdims=True) for one in (before, across, after)]
    jumps = (sides > 0) & (speeds[1] > _JUMP * np.maximum(speeds[0], speeds[2]))
    return np.where(jumps, (before + after) / np.maximum(sides, 1), across)


def is_stretched(matrices: Matrices, tolerance: float = 1e-5) -> bool:
    """Whether frames (P, 4, 4) change their size or shape on their way, by more than a share of it:
    the default is what matrices of six digits leave."""
    stretch = np.swapaxes(_nearest_turns(matrices), 1, 2) @ matrices[:, :3, :3]
    size = np.abs(stretch).max(initial=0)
    return bool((np.abs(stretch - stretch[:1]) > tolerance * size).any())


def _nearest_turns(matrices: Matrices) -> NDArray[np.float64]:
    """Nearest orthogonal matrices (P, 3, 3): scale and shear removed, reflections kept."""
    u, size, v = np.linalg.svd(matrices[:, :3, :3])
    if not (size > 0).all():
        flat = int(np.flatnonzero(~(size > 0).all(axis=1))[0])
        raise Error(f"poses: pose {flat} flattens what it places")
    return np.asarray(u @ v)


def _rotation_vectors(
    before: NDArray[np.float64], after: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Rotation vectors (P, 3), rad, in the world, from one turn to another."""
    from scipy.spatial.transform import Rotation

    step = after @ np.swapaxes(before, 1, 2)
    if not (np.linalg.det(step) > 0).all():
        raise Error("poses: expected a path along which none or all mirror")
    return np.asarray(Rotation.from_matrix(step).as_rotvec())


def _warn_of_half_turns(turned: NDArray[np.float64]) -> None:
    """Tell the caller of the package of turns (P, 3), rad, of which either way is as short."""
    half = np.flatnonzero(np.linalg.norm(turned, axis=1) > np.pi - _HALF_TURN_RAD)
    if len(half) > 0:
        more = f" and {len(half) - 1} more" if len(half) > 1 else ""
        warn_caller(
            f"poses: half a turn from pose {half[0]} to pose {half[0] + 1}{more}, which may go "
            "either way: the angular velocity there is one of two; put poses in between",
            UserWarning,
        )


def _at_poses(between: NDArray[np.float64], steps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Velocities at poses (P, 3) from those between them."""
    before, after = steps[:-1, None], steps[1:, None]
    inner = (between[:-1] * after + between[1:] * before) / (before + after)
    return np.concatenate([between[:1], inner, between[-1:]])


def poses_between(
    matrices: Matrices, times_s: NDArray[np.float64], wanted_s: NDArray[np.float64]
) -> Matrices:
    """Where a frame that is at ``matrices`` (P, 4, 4) at growing times (P,) is at others (M,), none
    outside of these: (M, 4, 4). As the engine has it, positions and stretches go straight, turns
    evenly."""
    if (matrices == matrices[0]).all():
        return np.tile(matrices[:1], (len(wanted_s), 1, 1))
    from scipy.spatial.transform import Rotation

    before = np.clip(np.searchsorted(times_s, wanted_s, "right") - 1, 0, len(times_s) - 2)
    share = (wanted_s - times_s[before]) / (times_s[before + 1] - times_s[before])
    turns = _nearest_turns(matrices)
    step = Rotation.from_rotvec(
        share[:, None] * _rotation_vectors(turns[before], turns[before + 1])
    )
    stretch = np.swapaxes(turns, 1, 2) @ matrices[:, :3, :3]
    whole = share[:, None, None]
    between = np.tile(np.eye(4), (len(wanted_s), 1, 1))
    straight = (1 - whole) * stretch[before] + whole * stretch[before + 1]
    between[:, :3, :3] = step.as_matrix() @ turns[before] @ straight
    between[:, :3, 3] = matrices[before, :3, 3] * (1 - share[:, None])
    between[:, :3, 3] += matrices[before + 1, :3, 3] * share[:, None]
    # Those that are given keep their bits.
    given = np.searchsorted(times_s, wanted_s)
    same = times_s[given] == wanted_s
    between[same] = matrices[given[same]]
    return between
