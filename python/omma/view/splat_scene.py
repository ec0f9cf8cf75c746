"""Gaussian splats as the page draws them: without what depends on direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omma._core import Scene, SplatCloud
from omma.base.arrays import Floats32
from omma.picture.cameras import display
from omma.scene.splat_harmonics import basis

# What a browser sorts and draws without effort; of more each second, third and so on is drawn.
MOST_SPLATS = 500_000
# Flat splats are drawn this thick.
_LEAST_M = 1e-6


@dataclass(frozen=True)
class DrawnSplats:
    """In the world: middles (N, 3), m, covariances (N, 3, 3), m², display colours (N, 3), 0 to 1,
    and opacities (N, 1)."""

    centers: Floats32
    covariances: Floats32
    rgbs: Floats32
    opacities: Floats32


def drawn_splats(scene: Scene) -> tuple[list[DrawnSplats], str]:
    """The clouds of a scene, and what of them is not drawn, in words."""
    step = -(-scene.splat_count // MOST_SPLATS)
    found = [_drawn(cloud, max(step, 1)) for cloud in scene.splats if len(cloud.opacities)]
    note = f"one of {step} Gaussian splats is drawn" if step > 1 else ""
    return found, note


def _drawn(cloud: SplatCloud, step: int) -> DrawnSplats:
    from scipy.spatial.transform import Rotation

    rows = slice(None, None, step)
    matrix = cloud.world_from_splats
    axes = matrix[:3, :3] @ Rotation.from_quat(cloud.rotations[rows]).as_matrix()
    axes = axes * np.maximum(cloud.scales_m[rows], _LEAST_M)[:, None, :]
    colour = 0.5 + basis(np.array([[0.0, 0.0, 1.0]]), 1)[0, 0] * cloud.harmonics[rows, 0, :3]
    colour = np.ascontiguousarray(np.clip(colour, 0, 1), np.float32)
    if cloud.color_space == "linear":
        colour = display(colour[None])[0].astype(np.float32) / 255
    return DrawnSplats(
        (cloud.positions_m[rows] @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32),
        (axes @ axes.transpose(0, 2, 1)).astype(np.float32),
        colour,
        cloud.opacities[rows, None],
    )
