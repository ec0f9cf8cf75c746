"""Gaussian splats, slowly: every ray meets every Gaussian, in double precision.

The model is that of 3D Gaussian Ray Tracing (Moenne-Loccoz et al. 2024) with the thresholds of 3DGS
(Kerbl et al. 2023): each Gaussian counts once, at the point of its greatest response along the ray.
"""

import numpy as np
from scipy.spatial.transform import Rotation

LEAST_ALPHA, MOST_ALPHA, LEAST_TRANSMITTANCE = 1 / 255, 0.99, 1e-4

# graphdeco-inria/gaussian-splatting, utils/sh_utils.py.
C0 = 0.28209479177387814
C1 = 0.4886025119029199
C2 = (
    1.0925484305920792,
    -1.0925484305920792,
    0.31539156525252005,
    -1.0925484305920792,
    0.5462742152960396,
)
C3 = (
    -0.5900435899266435,
    2.890611442640554,
    -0.4570457994644658,
    0.3731763325901154,
    -0.4570457994644658,
    1.445305721320277,
    -0.5900435899266435,
)


def basis(directions):
    """(..., 16) harmonics of unit directions (..., 3), as 3DGS orders and signs them."""
    x, y, z = np.moveaxis(np.asarray(directions, float), -1, 0)
    xx, yy, zz = x * x, y * y, z * z
    return np.stack(
        [
            np.full_like(x, C0),
            -C1 * y,
            C1 * z,
            -C1 * x,
            C2[0] * x * y,
            C2[1] * y * z,
            C2[2] * (2 * zz - xx - yy),
            C2[3] * x * z,
            C2[4] * (xx - yy),
            C3[0] * y * (3 * xx - yy),
            C3[1] * x * y * z,
            C3[2] * y * (4 * zz - xx - yy),
            C3[3] * z * (2 * zz - 3 * xx - 3 * yy),
            C3[4] * x * (4 * zz - xx - yy),
            C3[5] * z * (xx - yy),
            C3[6] * x * (xx - 3 * yy),
        ],
        axis=-1,
    )


def trace(splats, origins, directions, far_m):
    """What rays in the world see of splats: (R,) each but the first.

    ``splats`` has the fields of `SplatArrays`. Of each ray the sum of display colours (R, 3),
    transmittance, expected depth (mean t, weighted as the colours), and the first t at which no
    more than half of the light comes through; both are along the ray, m, and infinite where there
    is none.
    """
    origins, directions = np.asarray(origins, float), np.asarray(directions, float)
    found = [_trace_one(splats, *one) for one in zip(origins, directions, np.asarray(far_m, float))]
    return tuple(np.array(column) for column in zip(*found))


def _trace_one(splats, origin, direction, far_m):
    # In the cloud's own frame, where t stays that of the world: the direction is not normalised.
    cloud_from_world = np.linalg.inv(splats.world_from_splats)
    o = cloud_from_world[:3, :3] @ origin + cloud_from_world[:3, 3]
    d = cloud_from_world[:3, :3] @ direction
    centres = splats.positions.astype(float)
    axes = Rotation.from_quat(splats.rotations.astype(float)).as_matrix()
    scales = splats.scales.astype(float)
    # Where the Gaussian is round and of standard deviation 1: S^-1 R^T.
    o1 = np.einsum("nji,nj->ni", axes, o - centres) / scales
    d1 = np.einsum("nji,j->ni", axes, d) / scales
    t = -(o1 * d1).sum(axis=1) / (d1 * d1).sum(axis=1)
    square = ((o1 + t[:, None] * d1) ** 2).sum(axis=1)
    alpha = np.minimum(MOST_ALPHA, splats.opacities.astype(float) * np.exp(-square / 2))
    met = np.flatnonzero((alpha >= LEAST_ALPHA) & (t > 0) & (t <= far_m))
    met = met[np.argsort(t[met], kind="stable")]
    seen = centres[met] - o if splats.direction == "center" else np.broadcast_to(d, (len(met), 3))
    seen = seen / np.linalg.norm(seen, axis=1, keepdims=True)
    harmonics = splats.harmonics[met].astype(float)
    terms = harmonics.shape[1]
    colours = np.maximum(0, 0.5 + np.einsum("nk,nkc->nc", basis(seen)[:, :terms], harmonics))
    rgb, transmittance, weights, depth, half = np.zeros(3), 1.0, 0.0, 0.0, np.inf
    for i, colour in zip(met, colours):
        weight = transmittance * alpha[i]
        rgb += weight * colour
        weights += weight
        depth += weight * t[i]
        transmittance *= 1 - alpha[i]
        if transmittance <= 0.5 and np.isinf(half):
            half = t[i]
        if transmittance < LEAST_TRANSMITTANCE:
            break
    return rgb, transmittance, depth / weights if weights else np.inf, half
