"""An eye in Mitsuba 3, in its LLVM variant: a small camera for each ommatidium in a `batch` sensor,
six cameras for a cube map, or rays for each ommatidium without cameras. Scenes are as light_peer.py
makes them.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from cube_maps import camera_weights, face_poses
from light_peer import gaussian_rays, peer_scene
from numpy.typing import NDArray

import omma
from omma.light import Light

VARIANT = "llvm_ad_rgb"
# Columns: the camera's left, up and ahead, from those of a camera that looks along its -Z.
PEER_FROM_CAMERA = np.diag([-1.0, 1.0, -1.0, 1.0])
FIELD_SIGMAS = 3.0
INTEGRATORS = {
    # The base colour of what is met first; where nothing is, 0.
    "unlit": {"type": "aov", "aovs": "colour:albedo"},
    "direct light": {"type": "path", "max_depth": 2},
}


class PeerWorld:
    """The scene on one thread, seen unlit or in direct light."""

    def __init__(self, scene: omma.Scene, light: Light, lighting: str) -> None:
        import drjit
        import mitsuba

        mitsuba.set_variant(VARIANT)
        drjit.set_thread_count(1)
        self.scene = peer_scene(scene, light)
        self.integrator = mitsuba.load_dict(INTEGRATORS[lighting])


class Cameras:
    """Square pictures of many cameras, which move from frame to frame."""

    def __init__(
        self, world: PeerWorld, fov_rad: NDArray[np.float64], pixels: int, samples: int
    ) -> None:
        import drjit
        import mitsuba

        def film(width: int) -> dict[str, Any]:
            return {
                "type": "hdrfilm", "width": width, "height": pixels, "rfilter": {"type": "box"},
                "pixel_format": "rgb", "component_format": "float32",
            }  # fmt: skip

        self._world, self._pixels = world, pixels
        one = {"type": "perspective", "near_clip": 1e-4, "far_clip": 1e4}
        self._sensor = mitsuba.load_dict(
            {
                "type": "batch",
                "film": film(len(fov_rad) * pixels),
                "sampler": {"type": "independent", "sample_count": samples},
            }
            | {
                f"camera{k}": one | {"fov": float(np.degrees(fov)), "film": film(pixels)}
                for k, fov in enumerate(fov_rad)
            },
            # Cameras that are alike are not to be made one, as each has a place of its own.
            optimize=False,
        )
        # Frozen, the program of a frame is recorded in the first two and then repeated.
        self._render = drjit.freeze(
            lambda scene, sensor, integrator, seed: mitsuba.render(
                scene, sensor=sensor, integrator=integrator, spp=samples, seed=seed
            )
        )
        self._parameters = mitsuba.traverse(self._sensor)
        self._names = [f"camera{k}.to_world" for k in range(len(fov_rad))]

    def move(self, poses: NDArray[np.float64]) -> None:
        """Places the cameras: world from camera, (N, 4, 4), m."""
        import mitsuba

        for name, matrix in zip(self._names, poses @ PEER_FROM_CAMERA):
            self._parameters[name] = mitsuba.Transform4f(matrix.tolist())
        self._parameters.update()

    def see(self, seed: int) -> NDArray[np.float32]:
        """Pictures (N, pixels, pixels, 3), row 0 at the top."""
        import mitsuba

        found = self._render(
            self._world.scene, self._sensor, self._world.integrator, mitsuba.UInt32(seed)
        )
        film = np.array(found, np.float32)
        return film.reshape(self._pixels, -1, self._pixels, 3).swapaxes(0, 1)


class EyeOfCameras:
    """A small camera for each ommatidium, its pixels weighted by the sensitivity.

    still: the cameras stay where the first frame places them.
    """

    def __init__(
        self, world: PeerWorld, eye: omma.Eye, pixels: int, samples: int, *, still: bool = False
    ) -> None:
        self._weights, fov = camera_weights(eye.acceptance_angle_rad, pixels, FIELD_SIGMAS)
        self._cameras = Cameras(world, fov, pixels, samples)
        self._head_from_camera = np.tile(np.eye(4), (len(eye), 1, 1))
        self._head_from_camera[:, :3, :3] = np.stack([eye.right, eye.up, -eye.axis], axis=-1)
        self._head_from_camera[:, :3, 3] = eye.position_m
        self._still, self._is_placed = still, False

    def see(self, pose: NDArray[np.float64], seed: int) -> NDArray[np.float32]:
        """Responses (N, 3) at a pose."""
        if not (self._still and self._is_placed):
            self._cameras.move(pose @ self._head_from_camera)
            self._is_placed = True
        return np.einsum("nij,nijc->nc", self._weights, self._cameras.see(seed))


class CubeOfCameras:
    """Six cameras at one place."""

    def __init__(self, world: PeerWorld, size: int, samples: int) -> None:
        self._cameras = Cameras(world, np.full(6, np.pi / 2), size, samples)

    def see(self, pose: NDArray[np.float64], seed: int) -> NDArray[np.float32]:
        """Pixels (6 size², 3) in the order of `cube_maps.pixel_directions`."""
        self._cameras.move(face_poses(pose))
        return self._cameras.see(seed).reshape(-1, 3)


class RaysOfEye:
    """Random rays for each ommatidium, handed to the integrator without a camera."""

    def __init__(self, world: PeerWorld, eye: omma.Eye, samples: int) -> None:
        import drjit
        import mitsuba

        self._world, self._eye, self._samples = world, eye, samples
        self._sampler = mitsuba.load_dict({"type": "independent"})
        self._rays = functools.cache(self._make_rays)
        self._follow = drjit.freeze(follow)

    def _make_rays(self, seed: int) -> tuple[Any, Any]:
        import mitsuba

        count = self._samples * len(self._eye)
        origin, direction = gaussian_rays(self._eye, np.eye(4), count, seed)
        return mitsuba.Point3f(origin), mitsuba.Vector3f(direction)

    def see(self, pose: NDArray[np.float64], seed: int) -> NDArray[np.float32]:
        """Responses (N, 3) at a pose; the rays of a seed are fixed to the head."""
        import drjit
        import mitsuba

        placed = mitsuba.Transform4f(pose.tolist())
        drjit.make_opaque(placed)
        self._sampler.seed(seed, self._samples * len(self._eye))
        found = self._follow(
            self._world.scene, self._world.integrator, self._sampler, placed, *self._rays(seed)
        )
        seen = np.stack([np.array(one) for one in found], axis=-1)
        return seen.reshape(-1, self._samples, 3).mean(axis=1)


def follow(
    scene: Any, integrator: Any, sampler: Any, placed: Any, origin: Any, direction: Any
) -> list[Any]:
    """Red, green and blue that rays of a head bring which is placed so."""
    import mitsuba

    rays = mitsuba.RayDifferential3f(placed @ origin, placed @ direction)
    radiance, _, others = integrator.sample(scene, sampler, rays)
    # What is no radiance comes apart from it, as a list.
    return list(others or radiance)
