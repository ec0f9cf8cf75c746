"""How far responses scatter: by position in a scene, and by the number of rays.

Everything rests on one thing: estimates of the same response repeated with independent samples,
and their standard deviation. The protocols are CompoundRay's (Millward, Maddock, Mangan, eLife
2022, 73893): twelve ommatidia of 1 sr along the corners of an icosahedron look all round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye, Scene
from omma.base.arguments import checked, positive, whole
from omma.base.poses import as_pose, as_poses, numbers
from omma.base.progress import Progress, Stage, ends_of_steps, share_of
from omma.base.renamed import renamed_arguments, renamed_fields
from omma.base.values import value_class
from omma.rendering.renderer import Renderer
from omma.rendering.settings import MAX_SAMPLES, AngularSensitivityName, Fixed, PointsName

Array = NDArray[np.float64]
Measure = Literal["linear", "compoundray"]

# Full width of a cone of 1 sr, which CompoundRay gives these ommatidia as acceptance angle.
ONE_STERADIAN_RAD = 2 * float(np.arccos(1 - 1 / (2 * np.pi)))
# What a measure's standard deviation is a share of: radiance 1; black to white in 8-bit RGB.
FULL_SCALE: dict[str, float] = {"linear": 1.0, "compoundray": 255 * 3**0.5}

# Estimates held at once: few enough to forget about.
_CHUNK_BYTES = 64 << 20


@renamed_fields(kernel="angular_sensitivity")
@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Method:
    """How directions are drawn: names of a `Renderer`'s angular sensitivity and points."""

    angular_sensitivity: AngularSensitivityName = "gaussian"
    points: PointsName = "low_discrepancy"

    @property
    def name(self) -> str:
        """In words."""
        return f"{self.angular_sensitivity} sensitivity, {self.points.replace('_', ' ')} points"


OURS = Method()
COMPOUNDRAY = Method("compoundray", "random")


@checked
def icosahedral_eye() -> Eye:
    """Twelve ommatidia in one point along the corners of an icosahedron, 1 sr wide each."""
    ring = np.arange(5) * 0.4 * np.pi
    height, radius = 5**-0.5, 2 * 5**-0.5
    upper = np.stack([radius * np.cos(ring), np.full(5, height), radius * np.sin(ring)], axis=1)
    axes = np.concatenate([[[0, 1, 0]], upper, -upper, [[0, -1, 0]]])
    return Eye(np.zeros_like(axes), axes, ONE_STERADIAN_RAD)


@checked
def solid_angles_sr(eye: Eye) -> Array:
    """Solid angle of each ommatidium's cone, 2π(1 - cos(Δρ/2)): (N,), sr.

    Example:
        >>> omma.study.solid_angles_sr(omma.study.icosahedral_eye())[0].round(6)
        np.float64(1.0)
    """
    half = eye.acceptance_angle_rad.astype(np.float64) / 2
    return 4 * np.pi * np.sin(half / 2) ** 2  # the same, exact for narrow cones too


@checked
def rays_per_ommatidium(eye: Eye, rays_per_sr: float) -> int:
    """Rays for the widest ommatidium of an eye at a number of rays per steradian; at least 1."""
    rays = solid_angles_sr(eye).max(initial=0.0) * positive(float(rays_per_sr), "rays_per_sr")
    if not rays < 1 << 62:
        raise Error(f"rays_per_sr: expected less, found {rays_per_sr:g}")
    return max(1, int(np.ceil(rays)))


@checked
def response_variances(
    scene: Scene | Renderer,
    eye: Eye,
    poses: ArrayLike,
    *,
    rays: int,
    repeats: int,
    method: Method = OURS,
    measure: Measure = "linear",
    seed: int = 0,
    seeds: int = 1,
    threads: int = 0,
    progress: Progress | None = None,
) -> Array:
    """Variance of each ommatidium's response among independent estimates of it: (P, N), float64.

    Args:
        scene: what there is to see; or a renderer of it, to share what that has built.
        eye: who sees it.
        poses: (P, 4, 4) or (4, 4) ``world_from_head``, m.
        rays: rays per estimate.
        repeats: estimates; their variance has a relative standard error of about
            sqrt(2 / (repeats - 1)).
        method: angular sensitivity and points.
        measure: "linear": variance of the linear response, of the channel with the largest; full
            scale is radiance 1. "compoundray": clamped, raised to 1/2.2, truncated to 8 bits; the
            mean squared distance in RGB from the mean colour.
        seed: of the samples.
        seeds: renderers of different seeds that share the repeats.
        threads: 0 takes all; of no effect where a renderer is given.
        progress: called with the finished share.

    Raises:
        omma.Error: an argument is out of its range.
    """
    if measure not in FULL_SCALE:
        raise Error(f"measure: expected linear or compoundray, found {measure!r}")
    whole(seed, "seed", 0, (1 << 64) - 1)
    matrices = as_poses(poses)
    seeds = min(whole(seeds, "seeds", 1, 1 << 10), whole(repeats, "repeats", 2, 1 << 20))
    copies = -(-repeats // seeds)
    # Random single rays are independent; otherwise the eye is repeated, and each copy has its own
    # scramble.
    single = rays == 1 and method.points == "random"
    crowd = Eye(
        *(np.repeat(array, copies, axis=0) for array in (eye.position_m, eye.axis)),
        *(np.repeat(array, copies) for array in (eye.acceptance_angle_rad, eye.focal_offset_m)),
    )
    base = scene_renderer(scene, threads)
    renderers = [
        base.with_eye(
            eye if single else crowd,
            Fixed(copies if single else rays),
            seed=further_seed(seed, k),
            angular_sensitivity=method.angular_sensitivity,
            points=method.points,
            noise="new_every_frame",
        )
        for k in range(seeds)
    ]
    chunk = max(1, _CHUNK_BYTES // (24 * max(1, len(crowd)) * seeds))
    result = np.empty((len(matrices), len(eye)))
    render = Renderer.render_rays if single else Renderer.render
    for first in range(0, len(matrices), chunk):
        piece = matrices[first : first + chunk]
        estimates = []
        for k, renderer in enumerate(renderers):
            share = len(piece) / len(matrices) / seeds
            done = first / len(matrices) + k * share
            tell = share_of(progress, done, done + share)
            found = render(renderer, piece, first_pose=first, progress=tell)
            estimates.append(found.reshape(len(piece), len(eye), copies, -1))
        result[first : first + chunk] = _variance(np.concatenate(estimates, axis=2), measure)
    return result


def scene_renderer(
    scene: Scene | Renderer, threads: int, progress: Progress | None = None
) -> Renderer:
    """A renderer to make others of the same scene from."""
    if isinstance(scene, Renderer):
        return scene
    return Renderer(scene, icosahedral_eye(), Fixed(1), threads=threads, progress=progress)


def further_seed(seed: int, number: int) -> int:
    """A seed of its own for each number; the same one for number 0."""
    return (seed + number * 0x9E3779B97F4A7C15) % (1 << 64)


def _variance(estimates: NDArray[np.float32], measure: Measure) -> Array:
    """Of estimates (P, N, R, C): (P, N)."""
    if measure == "linear":
        widest: Array = estimates.var(axis=2, ddof=1, dtype=np.float64).max(axis=-1)
        return widest
    display = np.floor(255 * np.clip(estimates, 0, 1) ** np.float32(1 / 2.2))
    summed: Array = display.var(axis=2, ddof=1, dtype=np.float64).sum(axis=-1)
    return summed


@renamed_arguments(centre_m="center_m")
@checked
def variance_map(
    scene: Scene | Renderer,
    center_m: ArrayLike,
    size_m: float,
    *,
    steps: int = 21,
    statistic: Literal["max", "mean"] = "max",
    rays: int = 1,
    repeats: int = 1024,
    method: Method = COMPOUNDRAY,
    measure: Measure = "linear",
    seed: int = 0,
    threads: int = 0,
    progress: Stage | None = None,
) -> Array:
    """Variance of responses over a horizontal square, seen by the icosahedral eye.

    Row i, column j is the middle of a cell of side ``size_m / steps``: z grows with i, x with j,
    seen from above with -Z (ahead of an unturned head) at the top. (steps, steps), float64.

    Args:
        scene: what there is to see, or a renderer of it.
        center_m: middle of the square (3,), m; its y is the height of the eye.
        size_m: side of the square, over 0.
        steps: cells along a side.
        statistic: of the twelve ommatidia: "max" or "mean".
        rays: rays per estimate; 1 with random points gives the variance of the light itself.
        repeats: estimates per ommatidium.
        method: angular sensitivity and points.
        measure: as in `response_variances`.
        seed: of the samples.
        threads: 0 takes all.
        progress: called with a stage and its finished share.

    Raises:
        omma.Error: an argument is out of its range.
    """
    if statistic not in ("max", "mean"):
        raise Error(f"statistic: expected max or mean, found {statistic!r}")
    x, z = cell_middles(center_m, size_m, whole(steps, "steps", 1, 1 << 12))
    height = numbers(center_m, "center_m", 3)[0, 1]
    poses = np.tile(np.eye(4), (steps, steps, 1, 1))
    poses[:, :, 0, 3], poses[:, :, 1, 3], poses[:, :, 2, 3] = x[None], height, z[:, None]
    variance = response_variances(
        scene,
        icosahedral_eye(),
        poses.reshape(-1, 4, 4),
        rays=rays,
        repeats=repeats,
        method=method,
        measure=measure,
        seed=seed,
        threads=threads,
        progress=None if progress is None else lambda done: progress("Mapping", done),
    ).reshape(steps, steps, -1)
    result: Array = variance.max(axis=2) if statistic == "max" else variance.mean(axis=2)
    return result


def cell_middles(center_m: ArrayLike, size_m: float, steps: int) -> tuple[Array, Array]:
    """x (steps,) and z (steps,), m, of the cells of `variance_map`."""
    centre = numbers(center_m, "center_m", 3)[0]
    if not (size_m > 0 and np.isfinite(size_m)):
        raise Error(f"size_m: expected over 0, found {size_m}")
    offsets = ((np.arange(steps) + 0.5) / steps - 0.5) * size_m
    return centre[0] + offsets, centre[2] + offsets


@checked
def alias_curve(
    scene: Scene | Renderer,
    eye: Eye,
    pose: ArrayLike,
    rays: Sequence[int],
    *,
    repeats: int = 64,
    method: Method = OURS,
    measure: Measure = "linear",
    seed: int = 0,
    threads: int = 0,
    progress: Stage | None = None,
) -> tuple[Array, Array]:
    """Scatter of an eye's responses against rays per ommatidium.

    Args:
        scene: what there is to see, or a renderer of it.
        eye: who sees it.
        pose: (4, 4) ``world_from_head``, m.
        rays: numbers of rays, (K,).
        repeats: estimates of each response.
        method: angular sensitivity and points.
        measure: as in `response_variances`.
        seed: of the samples.
        threads: 0 takes all.
        progress: called with a stage and its finished share.

    Returns:
        Mean over the ommatidia of standard deviation over solid angle (K,), per sr, which is what
        CompoundRay's demonstration plots; and the root mean square of the standard deviation (K,).

    Raises:
        omma.Error: an argument is out of its range.
    """
    angles = solid_angles_sr(eye)
    if not (angles > 0).all():
        raise Error("eye: expected acceptance angles over 0, found one of 0")
    at = as_pose(pose, "pose")[None]
    base = scene_renderer(scene, threads)
    done = ends_of_steps([whole(count, "rays", 1, MAX_SAMPLES) for count in rays])
    per_sr, plain = [], []
    for number, count in enumerate(rays):
        tell = None if progress is None else partial(progress, f"{count} rays")
        variance = response_variances(
            base,
            eye,
            at,
            rays=count,
            repeats=repeats,
            method=method,
            measure=measure,
            seed=further_seed(seed, number),
            seeds=2,
            progress=share_of(tell, done[number], done[number + 1]),
        )[0]
        per_sr.append(float((np.sqrt(variance) / angles).mean()))
        plain.append(float(np.sqrt(variance.mean())))
    return np.array(per_sr), np.array(plain)
