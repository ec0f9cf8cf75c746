"""How far a response may be from the true one: intervals that do not trust rays that agree.

A standard error comes from how much independent scrambles differ. Where all of them miss something
(the tip of a black stripe, a lamp), or one alone meets it, they differ too little: the standard
error is of the right size on average, but most ommatidia have one that is too small, and a few one
that is too large. What their neighbours see says what there is to miss.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye, error_scrambles
from omma.base.arguments import array_of, checked, expect

# Of a standard error.
_DEGREES_OF_FREEDOM = error_scrambles - 1
# Neighbours: those whose axes lie in the field, of which a Gaussian leaves two thousandths beyond
# 1.5 acceptance angles; and where fields are apart, as many as a hexagonal lattice has around each.
_FIELD, _NEIGHBOURS = 1.5, 6


@checked
def confidence_interval(
    eye: Eye,
    responses: ArrayLike,
    standard_errors: ArrayLike,
    rays: ArrayLike,
    *,
    level: float = 0.95,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Bounds that hold the true responses in about ``level`` of all cases, or more.

    The larger of two: Student's interval for the standard error, with 7 degrees of freedom; and
    what n rays can overlook. If a share p of a field is different, n independent rays miss it with
    the probability (1 - p)^n, which is 1 - ``level`` where p is -ln(1 - level) / n (for 0.95 the
    rule of three, 3/n). How different it may be, neighbours say, those of its eye that look within
    1.5 acceptance angles of it, or the six nearest, by their responses r and standard errors s: the
    range of all r, and sum(n s^2) / sum(r - min r), which is what a ray brings of something small
    and bright that some rays met (max r - r: of something dark); the larger counts. Without
    neighbours only the first interval is left.

    Measured in docs/sampling.md. What no ray of the neighbours meets either is not in it, and
    where rays are shared, neighbours miss the same things.

    Args:
        eye: who sees, (N,); the renderer's.
        responses: (..., N, C), as `Renderer.render` gives them.
        standard_errors: of these, the same shape.
        rays: that each response comes from, a number or (..., N): 8 times the samples with
            ``standard_error=True``, `SamplingReport.rays` with `ToError`.
        level: share of responses whose bounds are to hold the true one, between 0 and 1.

    Returns:
        (low, high), each of the shape of ``responses``, float64, radiance. They are not clipped:
        ``low`` may be below 0.

    Raises:
        omma.Error: a wrong shape, or a number that is out of its range.
        TypeError: ``eye`` is no `Eye`.
    """
    from scipy.special import stdtrit

    expect(eye, Eye, "eye", "omma.load_eye gives one")
    values = array_of(responses, "responses", (..., len(eye), "C"))
    errors = array_of(standard_errors, "standard_errors", values.shape)
    counts = array_of(rays, "rays", [(), values.shape[:-1]])
    if not (counts >= 1).all():
        raise Error(f"rays: expected at least 1 each, found {counts.min()}")
    if not 0 < level < 1:
        raise Error(f"level: expected a number between 0 and 1, found {level!r:.40}")
    per_ray = np.broadcast_to(counts[..., None], values.shape) * errors**2
    by_pose = (-1, *values.shape[-2:])
    contrast = _contrast(values.reshape(by_pose), per_ray.reshape(by_pose), eye)
    contrast = contrast.reshape(values.shape)
    overlooked = -np.log1p(-level) / counts[..., None] * contrast
    half = np.maximum(stdtrit(_DEGREES_OF_FREEDOM, (1 + level) / 2) * errors, overlooked)
    return values - half, values + half


def _contrast(
    values: NDArray[np.float64], variance: NDArray[np.float64], eye: Eye
) -> NDArray[np.float64]:
    """How different what none of an ommatidium's rays met may be from what they did, by the
    responses and variances of single rays of itself and its neighbours, all (K, N, C)."""
    from scipy.spatial import cKDTree

    axis, eye_id = np.asarray(eye.axis, np.float64), np.asarray(eye.eye_id)
    reach_rad = np.minimum(_FIELD * np.asarray(eye.acceptance_angle_rad, np.float64), np.pi)
    contrast = np.zeros_like(values)
    for which in np.unique(eye_id):
        members = np.flatnonzero(eye_id == which)
        tree = cKDTree(axis[members])
        farthest, _ = tree.query(axis[members], k=[min(len(members), 1 + _NEIGHBOURS)])
        reach = np.maximum(2 * np.sin(reach_rad[members] / 2), farthest[:, 0] * (1 + 1e-9))
        near = tree.query_ball_point(axis[members], reach)
        first = np.cumsum([0, *map(len, near[:-1])])
        around = members[np.concatenate(near).astype(np.int64)]
        count = np.diff([*first, len(around)])[:, None]
        for pose, of_pose, of_rays in zip(contrast, values, variance, strict=True):
            seen = of_pose[around]
            least, most = np.minimum.reduceat(seen, first), np.maximum.reduceat(seen, first)
            # A target of radiance C that k of n rays met adds k C / n to a response and k C^2 / n
            # to its rays' variance, however few of them met it.
            total = np.add.reduceat(seen, first)
            beside = np.minimum(total - count * least, count * most - total)
            scatter = np.add.reduceat(of_rays[around], first)
            by_rays = np.divide(scatter, beside, out=np.zeros_like(scatter), where=beside > 0)
            pose[members] = np.maximum(most - least, by_rays)
    return contrast
