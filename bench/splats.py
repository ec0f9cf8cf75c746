"""Gaussian splats: building time, memory and rays per second of clouds on the surfaces of the
bundled meadow, beside the meadow itself, in the same run.

    python bench/splats.py              # 1 and 5 million
    python bench/splats.py 1 5 20       # millions

Splats lie on the surfaces by area. Their standard deviations, of the distance to the next one, and
their opacities are distributed as those of the 9,400 splats that examples/python/train_splats.py
trained on that meadow: medians 1.10, 0.74 and 0.47, logarithms with a spread of 0.55; opacities
with quartiles 0.43, 0.65 and 0.80, a Beta distribution.
"""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np
from numpy.typing import NDArray

import omma
from omma.scene.memory import words_for_bytes

Floats = NDArray[np.float64]
# Standard deviations along a surface and across it, of the distance to the next splat.
SCALES, SPREAD = (1.10, 0.74, 0.47), 0.55
# Of a Beta distribution.
OPACITIES = (1.87, 1.23)
TERMS = 16
POSES = 20


def triangles_of(scene: omma.Scene) -> tuple[Floats, Floats]:
    """Corners (T, 3, 3), m, of all that is placed, and areas (T,)."""
    corners = []
    for instance in scene.instances:
        mesh, matrix = scene.meshes[instance.mesh], instance.world_from_mesh
        placed = mesh.positions_m @ matrix[:3, :3].T + matrix[:3, 3]
        corners.append(placed[mesh.triangles])
    all_of = np.concatenate(corners)
    normals = np.cross(all_of[:, 1] - all_of[:, 0], all_of[:, 2] - all_of[:, 0])
    return all_of, np.linalg.norm(normals, axis=1) / 2


def quaternions(axes: Floats) -> Floats:
    """(N, 4), x, y, z, w, of frames (N, 3, 3) whose columns are their axes."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(axes).as_quat()


def cloud(scene: omma.Scene, count: int) -> omma.scene.SplatCloud:
    """Splats on the surfaces of a scene, each somewhere on a triangle."""
    rng = np.random.default_rng(1)
    corners, areas = triangles_of(scene)
    spacing = np.sqrt(areas.sum() / count)
    chosen = rng.choice(len(areas), count, p=areas / areas.sum())
    u, v = rng.random((2, count))
    flip = u + v > 1
    u[flip], v[flip] = 1 - u[flip], 1 - v[flip]
    a, b, c = (corners[chosen, k] for k in range(3))
    positions = a + (b - a) * u[:, None] + (c - a) * v[:, None]
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    along = np.cross(normal, rng.normal(size=(count, 3)))
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-30)
    axes = np.stack([along, np.cross(normal, along), normal], axis=2)
    # Of places by chance the next one is half as far as on a square grid, in the mean.
    scales = spacing / 2 * np.array(SCALES) * np.exp(rng.normal(0, SPREAD, (count, 3)))
    harmonics = rng.normal(0, 0.05, (count, TERMS, 3)).astype(np.float32)
    harmonics[:, 0] = rng.normal(-0.8, 0.4, (count, 3))
    return omma.scene.SplatCloud(
        positions, scales, quaternions(axes), rng.beta(*OPACITIES, count), harmonics
    )


def rate(world: omma.World, eye: omma.Eye, pose: Floats) -> float:
    """Rays per second of frames of 16 rays."""
    renderer = omma.Renderer(world, eye, omma.Fixed(16))
    poses = np.tile(pose, (POSES, 1, 1))
    renderer.render(poses[:1])
    start = time.perf_counter()
    renderer.render(poses)
    return POSES * len(eye) * 16 / (time.perf_counter() - start)


def main(millions: float) -> None:
    """Prints the meadow's speed and that of so many splats."""
    scene = omma.load_scene(omma.examples.meadow())
    eye = omma.species.honeybee_worker().eye
    pose = scene.camera("bee").world_from_camera
    mesh = rate(omma.World(scene), eye, pose)
    print(f"the meadow, {scene.triangle_count:,} triangles: {mesh / 1e6:.2f} M rays/s")
    count = round(millions * 1e6)
    splats = omma.Scene(splats=[cloud(scene, count)], background=scene.background)
    names = ("positions_m", "scales_m", "rotations", "opacities", "harmonics")
    held = sum(getattr(splats.splats[0], name).nbytes for name in names)
    before = resident()
    start = time.perf_counter()
    world = omma.World(splats)
    built_s = time.perf_counter() - start
    added = resident() - before
    print(
        f"{count:,} splats: built in {built_s:.1f} s, {words_for_bytes(added)} "
        f"({added / count:.0f} bytes each, beside {held / count:.0f} of the scene), "
        f"{rate(world, eye, pose) / 1e6:.2f} M rays/s",
        flush=True,
    )


def resident() -> int:
    """Bytes of memory that this process has."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


if __name__ == "__main__":
    asked = [float(one) for one in sys.argv[1:]] or [1.0, 5.0]
    if len(asked) == 1:
        main(asked[0])
    else:  # each in a process of its own, whose memory says what a world takes
        for some in asked:
            subprocess.run([sys.executable, __file__, str(some)], check=True)
