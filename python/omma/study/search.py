"""How many rays per steradian a scene needs: its worst position, and the scatter of responses
there.

CompoundRay's protocol (Millward, Maddock, Mangan, eLife 2022, 73893): the position where the light
in one of twelve ommatidia of 1 sr varies most is searched for, and there the number of rays at
which the standard deviation falls under a share of full scale.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Scene
from omma.base.arguments import checked, whole
from omma.base.poses import as_poses, numbers, poses_from_quaternions
from omma.base.progress import Stage
from omma.base.values import value_class
from omma.rendering.renderer import Renderer
from omma.study.variance import (
    FULL_SCALE,
    OURS,
    Array,
    Measure,
    Method,
    further_seed,
    icosahedral_eye,
    response_variances,
    scene_renderer,
)

# Repeats for a curve, spread over seeds, because one seed has few patterns of many rays.
_REPEATS, _SEEDS = 1024, 8
_KEPT, _OFFSPRING, _ROUNDS = 16, 8, 8
_MOST_RAYS = 1 << 16
# Rays of an estimate whose scatter is searched for, where they are not drawn one by one.
_SEARCH_RAYS = 64
# Single rays that the variance is taken from in the end.
_LAST_RAYS = 8192


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Box:
    """Positions between two corners, m."""

    low_m: tuple[float, float, float]
    high_m: tuple[float, float, float]


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Cylinder:
    """Positions in an upright cylinder: centre of its base, radius, height, m."""

    base_m: tuple[float, float, float]
    radius_m: float
    height_m: float


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class MinimumSamples:
    """What `minimum_samples` found.

    ``relative_error`` is the standard error of ``rays_per_sr`` as a share of it, at the
    position found; how much worse a position the search has missed is not in it.
    ``script_rays_per_sr`` is where CompoundRay's script stops on average, for its measure: it adds
    one ray at a time and stops at the first set of 1,000 frames that happens to be under the limit,
    which is early. ``spread`` is the largest standard deviation among the ommatidia there for
    estimates of ``spread_rays`` rays. Rays (K,) and standard deviations (K,) are the curve it is
    read from.
    """

    method: Method
    measure: Measure
    limit: float
    rays_per_sr: int
    relative_error: float
    script_rays_per_sr: int | None
    pose: Array
    ommatidium: int
    spread: float
    spread_rays: int
    rays: NDArray[np.int64]
    standard_deviations: Array
    poses_rendered: int
    rays_traced: int
    seconds: float


@checked
def minimum_samples(
    scene: Scene | Renderer,
    where: Box | Cylinder | ArrayLike,
    *,
    fraction: float = 0.01,
    method: Method = OURS,
    measure: Measure = "linear",
    poses: int = 4096,
    seed: int = 0,
    threads: int = 0,
    progress: Stage | None = None,
) -> MinimumSamples:
    """Rays per steradian at which responses scatter by no more than a share of full scale.

    The position of the largest scatter is looked for first: ``poses`` poses spread evenly over
    ``where`` and all orientations, the best of which are measured again and better, twice; then 8
    rounds in which the best 16 (of few, a sixteenth) and 8 smaller and smaller changes of each are
    rendered anew; then the best of those left, with most repeats. Scatter is that of single rays
    where points are random, as in CompoundRay's script; else that of estimates of 64 rays, because
    what evenly spread rays leave depends on how fine the scene is, too. At that pose the standard
    deviation, the largest of the twelve ommatidia's, is measured against the number of rays. Of
    random points and linear responses one standard deviation is enough: σ/√N.

    Nothing keeps the eye from being inside an object or under the ground: say where it can be.

    Args:
        scene: what there is to see, or a renderer of it.
        where: positions to search, or poses (P, 4, 4) of a path, whose positions are taken.
        fraction: of full scale, over 0.
        method: angular sensitivity and points.
        measure: as in `response_variances`.
        poses: of the first stage.
        seed: of the samples and of the search.
        threads: 0 takes all.
        progress: called with a stage and its finished share.

    Raises:
        omma.Error: an argument is out of its range, or 65,536 rays per steradian are not enough.
    """
    whole(seed, "seed", 0, (1 << 64) - 1)
    if not 0 < fraction < 1:
        raise Error(f"fraction: expected over 0 and under 1, found {fraction}")
    start = time.perf_counter()
    limit = fraction * FULL_SCALE[measure] if measure in FULL_SCALE else 0.0
    tally = _Tally(scene_renderer(scene, threads), method, measure, seed, progress)
    single = method.points == "random"
    pose, variance = _worst_pose(tally, where, whole(poses, "poses", 1, 1 << 20), single)
    spread = float(np.sqrt(variance.max()))
    if single and measure == "linear":
        needed, error = max(1.0, (spread / limit) ** 2), (2 / (_LAST_RAYS - 1)) ** 0.5
        counts = 2 ** np.arange(0, int(np.ceil(np.log2(needed))) + 2, dtype=np.int64)
        deviations = spread / np.sqrt(counts)
        script = None
    else:
        counts, deviations = _curve(tally, pose, limit)
        needed, error, script = _crossing(counts, deviations, limit)
    return MinimumSamples(
        method=method,
        measure=measure,
        limit=limit,
        rays_per_sr=int(np.ceil(needed)),
        relative_error=error,
        script_rays_per_sr=script if measure == "compoundray" and single else None,
        pose=pose,
        ommatidium=int(variance.argmax()),
        spread=spread,
        spread_rays=1 if single else _SEARCH_RAYS,
        rays=counts,
        standard_deviations=deviations,
        poses_rendered=tally.poses,
        rays_traced=tally.rays,
        seconds=time.perf_counter() - start,
    )


class _Tally:
    """Measures variances of the icosahedral eye and counts what it took."""

    def __init__(
        self,
        base: Renderer,
        method: Method,
        measure: Measure,
        seed: int,
        progress: Stage | None,
    ) -> None:
        self.base, self.method, self.measure = base, method, measure
        self.seed, self.progress = seed, progress
        self.eye = icosahedral_eye()
        self.calls = self.poses = self.rays = 0

    def variances(self, poses: Array, rays: int, repeats: int, stage: str, seeds: int = 1) -> Array:
        self.calls += 1  # each call draws samples of its own
        self.poses += len(poses)
        self.rays += len(poses) * rays * repeats * len(self.eye)
        progress = self.progress
        return response_variances(
            self.base,
            self.eye,
            poses,
            rays=rays,
            repeats=repeats,
            method=self.method,
            measure=self.measure,
            seed=further_seed(self.seed, 1000 * self.calls),
            seeds=seeds,
            progress=None if progress is None else lambda done: progress(stage, done),
        )


def _worst_pose(
    tally: _Tally, where: Box | Cylinder | ArrayLike, count: int, single: bool
) -> tuple[Array, Array]:
    """Pose (4, 4) of the largest scatter and the variances of the ommatidia (12,) there."""
    rays, few, many, last = (1, 64, 1024, _LAST_RAYS) if single else (_SEARCH_RAYS, 8, 64, 512)
    rng = np.random.default_rng(tally.seed)
    points = _spread_points(count)
    fractions, turns = points[:, :3], _uniform_quaternions(points[:, 3:])

    def measure(repeats: int, stage: str) -> Array:
        poses = poses_from_quaternions(_positions(where, fractions), turns)
        largest: Array = tally.variances(poses, rays, repeats, stage).max(axis=1)
        return largest

    kept = min(_KEPT, -(-count // 16))
    # Successive halving: the best quarter, then the best eighth of those, each measured four times
    # as well.
    for heat, keep in enumerate((4, 32, count)):
        variance = measure(few * 4**heat, f"Surveying, heat {heat + 1} of 3")
        best = np.argsort(-variance)[: max(kept, count // keep)]
        fractions, turns = fractions[best], turns[best]
    step = 0.1
    for number in range(_ROUNDS):
        parents = np.repeat(np.arange(kept), _OFFSPRING)
        moved = fractions[parents] + step * rng.normal(size=(len(parents), 3))
        turned = _turned(turns[parents], 3 * step * rng.normal(size=(len(parents), 3)))
        # Parents are measured again, so that none survives by one lucky sample.
        fractions = np.concatenate([fractions, moved.clip(0, 1)])
        turns = np.concatenate([turns, turned])
        best = np.argsort(-measure(many, f"Refining, round {number + 1} of {_ROUNDS}"))[:kept]
        fractions, turns = fractions[best], turns[best]
        step *= 0.7
    worst = int(measure(last, "Comparing the worst").argmax())
    # Measured again with other samples: the largest of several estimates is biased high.
    pose = poses_from_quaternions(_positions(where, fractions[worst, None]), turns[worst])
    return pose[0], tally.variances(pose, rays, last, "Comparing the worst", _SEEDS)[0]


def _positions(where: Box | Cylinder | ArrayLike, fractions: Array) -> Array:
    """Positions (n, 3), m, of points (n, 3) of the unit cube, evenly spread if those are."""
    if isinstance(where, Box):
        low, high = numbers([where.low_m, where.high_m], "box", 3)
        if not (low <= high).all():
            raise Error(f"box: expected the lower corner first, found {where.low_m} {where.high_m}")
        inside: Array = low + fractions * (high - low)
        return inside
    if isinstance(where, Cylinder):
        base = numbers(where.base_m, "cylinder", 3)[0]
        if not (where.radius_m >= 0 and where.height_m >= 0):
            found = f"{where.radius_m} and {where.height_m}"
            raise Error(f"cylinder: expected a radius and a height of 0 or more, found {found}")
        radius, angle = where.radius_m * np.sqrt(fractions[:, 0]), 2 * np.pi * fractions[:, 1]
        x, y, z = radius * np.cos(angle), where.height_m * fractions[:, 2], radius * np.sin(angle)
        round_axis: Array = base + np.stack([x, y, z], axis=1)
        return round_axis
    path = as_poses(where)
    if not len(path):
        raise Error("where: expected at least one pose")
    positions: Array = path[
        np.minimum((fractions[:, 0] * len(path)).astype(int), len(path) - 1), :3, 3
    ]
    return positions


def _spread_points(count: int) -> Array:
    """Evenly spread points (count, 6) of the unit cube: an additive recurrence.

    Its steps are the powers of 1/g, g the root of g^7 = g + 1 (Roberts 2018, "The unreasonable
    effectiveness of quasirandom sequences").
    """
    g = 1.0
    for _ in range(60):  # a contraction, so this is g to the last bit
        g = (1 + g) ** (1 / 7)
    steps = g ** -np.arange(1.0, 7.0)
    points: Array = (0.5 + np.outer(np.arange(count), steps)) % 1
    return points


def _uniform_quaternions(fractions: Array) -> Array:
    """Evenly spread rotations (n, 4), x y z w (Shoemake 1992), from points (n, 3)."""
    a, b, c = fractions[:, 0], 2 * np.pi * fractions[:, 1], 2 * np.pi * fractions[:, 2]
    low, high = np.sqrt(1 - a), np.sqrt(a)
    components = [low * np.sin(b), low * np.cos(b), high * np.sin(c), high * np.cos(c)]
    quaternions: Array = np.stack(components, axis=1)
    return quaternions


def _turned(quaternions: Array, turn_rad: Array) -> Array:
    """Rotations (n, 4) turned by small rotation vectors (n, 3), rad, in the world."""
    angle = np.linalg.norm(turn_rad, axis=1, keepdims=True)
    v, w = np.sinc(angle / (2 * np.pi)) / 2 * turn_rad, np.cos(angle / 2)
    q, s = quaternions[:, :3], quaternions[:, 3:]
    scalar = w * s - (v * q).sum(axis=1, keepdims=True)
    turned: Array = np.concatenate([w * q + s * v + np.cross(v, q), scalar], axis=1)
    return turned


def _curve(tally: _Tally, pose: Array, limit: float) -> tuple[NDArray[np.int64], Array]:
    """Standard deviations against rays: doubled until under the limit, then closer about it."""
    found: dict[int, float] = {}

    def measure(rays: int) -> float:
        variance = tally.variances(pose[None], rays, _REPEATS, f"{rays} rays", _SEEDS)
        found[rays] = float(np.sqrt(variance.max()))
        return found[rays]

    rays = 1
    while measure(rays) > limit:
        # Scrambled nets gain N^-1.5 at best (Owen 1997): more is not worth a wait.
        if found[rays] * (rays / _MOST_RAYS) ** 1.5 > limit or rays >= _MOST_RAYS:
            raise Error(
                f"fraction: the standard deviation is {found[rays]:.3g} at {rays} rays per "
                f"steradian, too far over the limit of {limit:.3g} for {_MOST_RAYS}"
            )
        rays *= 2
    for extra in {round(rays * 2 ** (k / 4)) for k in (-3, -2, -1, 1)} - set(found):
        if extra >= 1:
            measure(extra)
    counts = np.array(sorted(found), dtype=np.int64)
    return counts, np.array([found[int(n)] for n in counts])


def _crossing(
    counts: NDArray[np.int64], deviations: Array, limit: float
) -> tuple[float, float, int | None]:
    """Where a power law fitted to the nearest measurements meets the limit, its relative standard
    error, and the median of where counting up one by one stops."""
    if deviations[0] <= limit:
        return 1.0, 0.0, 1
    first = int(np.flatnonzero(deviations <= limit)[0])
    near = slice(max(0, first - 3), first + 3)
    x, y = np.log(counts[near]), np.log(deviations[near])
    slope, height = np.polyfit(x, y, 1)
    needed = float(np.exp((np.log(limit) - height) / slope))
    # A standard deviation of R normal values has the relative error 1/sqrt(2(R - 1)).
    error = (2 * (_REPEATS - 1) * len(x)) ** -0.5 / abs(slope)
    # Noise of 2 % (1,000 frames) does not stop it further from where it should.
    tried = np.arange(max(1, int(0.7 * needed)), int(1.3 * needed) + 20)
    noise = np.random.default_rng(0).normal(1, (2 * 999) ** -0.5, size=(400, len(tried)))
    stops = tried[(np.exp(height + slope * np.log(tried)) * noise < limit).argmax(axis=1)]
    return needed, error, int(np.median(stops))
