"""The scenes of light.py in Mitsuba 3, in its LLVM variants: the same triangles, light and rays."""

from __future__ import annotations

import importlib.util
import os
from typing import Any

import numpy as np
from light_scenes import Setup, linear_pixels
from numpy.typing import NDArray

import omma
from omma.light import Light

VARIANTS = ("llvm_ad_rgb", "llvm_ad_spectral")
# From the fourth scattering on paths may end, as ours do; its depths count one more.
ROULETTE_FROM = 4
WHOLE = 64  # scatterings of a path without a limit
SKY_ROWS, SKY_COLUMNS = 181, 360


def peer_variants() -> tuple[str, ...]:
    """Those that can be measured here."""
    is_there = importlib.util.find_spec("mitsuba") is not None
    return VARIANTS if is_there and "DRJIT_LIBLLVM_PATH" in os.environ else ()


class Peer:
    """One variant with a scene and the rays of an eye, on one thread."""

    def __init__(self, variant: str, setup: Setup, light: Light, rays: int) -> None:
        import drjit
        import mitsuba

        mitsuba.set_variant(variant)
        drjit.set_thread_count(1)
        self.variant = variant
        self.bands = 3 if variant.endswith("rgb") else 4
        self._scene = peer_scene(setup.scene, light)
        self._setup, self._rays = setup, rays
        self._origin, self._direction = gaussian_rays(setup.eye, setup.pose, rays)
        # Other rays for turns that were prepared.
        self._prepared: dict[int, tuple[NDArray[np.float32], NDArray[np.float32]]] = {}
        self._sampler = mitsuba.load_dict({"type": "independent"})
        self._integrators: dict[int, Any] = {}
        self._turn = 0

    def render(self, depth: int) -> int:
        """Follows all rays once; how many they were."""
        self._sample(depth)
        return self._origin.shape[1]

    def prepare(self, turn: int) -> None:
        """Rays of that turn's own."""
        eye, pose = self._setup.eye, self._setup.pose
        self._prepared[turn] = gaussian_rays(eye, pose, self._rays, seed=turn + 1)

    def responses(self, ommatidia: int, turn: int) -> NDArray[np.float64]:
        """Of whole paths, (N, 1): means over the rays and colours of each ommatidium, which are
        grey; each turn that was prepared has random numbers of its own."""
        self._turn = turn
        self._origin, self._direction = self._prepared[turn]
        radiance = np.asarray(self._sample(WHOLE))
        return radiance.mean(axis=0).reshape(ommatidia, -1).mean(axis=1)[:, None].astype(float)

    def _sample(self, depth: int) -> Any:
        import drjit
        import mitsuba

        mitsuba.set_variant(self.variant)
        if depth not in self._integrators:
            self._integrators[depth] = mitsuba.load_dict(
                {"type": "path", "max_depth": depth + 1, "rr_depth": ROULETTE_FROM}
            )
        count = self._origin.shape[1]
        self._turn += 1
        self._sampler.seed(self._turn, count)
        rays = mitsuba.RayDifferential3f(
            mitsuba.Point3f(self._origin), mitsuba.Vector3f(self._direction)
        )
        if self.bands == 4:
            shifted = mitsuba.sample_shifted(self._sampler.next_1d())
            rays.wavelengths, _ = mitsuba.sample_rgb_spectrum(shifted)
        radiance, _, _ = self._integrators[depth].sample(self._scene, self._sampler, rays)
        drjit.eval(radiance)
        drjit.sync_thread()
        return radiance


def peer_scene(scene: omma.Scene, light: Light) -> Any:
    """The scene in that light, in the variant that is set."""
    import mitsuba

    return mitsuba.load_dict(
        {"type": "scene", **_lights(mitsuba, light), **_shapes(mitsuba, scene)}
    )


def gaussian_rays(
    eye: omma.Eye, pose: NDArray[np.float64], rays: int, seed: int = 1
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Origins and directions (3, N), ommatidium by ommatidium, within Gaussian acceptances."""
    samples = max(1, round(rays / len(eye)))
    random = np.random.default_rng(seed)
    axis = np.repeat(eye.axis, samples, axis=0)
    width_rad = np.repeat(np.asarray(eye.acceptance_angle_rad), samples)
    off = random.normal(size=axis.shape) * (width_rad / np.sqrt(8 * np.log(2)))[:, None]
    off -= (off * axis).sum(axis=1, keepdims=True) * axis
    direction = axis + off
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    turn, place = pose[:3, :3], pose[:3, 3]
    origin = np.repeat(eye.position_m, samples, axis=0) @ turn.T + place
    return origin.T.astype(np.float32), (direction @ turn.T).T.astype(np.float32)


def _lights(mitsuba: Any, light: Light) -> dict[str, Any]:
    """The sky as a picture of all directions, the sun as rays from one direction."""
    elevation = np.radians(90 - 180 * (np.arange(SKY_ROWS) + 0.5) / SKY_ROWS)[:, None]
    azimuth = np.radians(360 * (np.arange(SKY_COLUMNS) + 0.5) / SKY_COLUMNS)[None, :]
    flat = np.cos(elevation)
    towards = np.stack(
        np.broadcast_arrays(flat * np.sin(azimuth), np.sin(elevation), -flat * np.cos(azimuth)),
        axis=-1,
    )
    sky = Light(light.bands, light.unit, light.sky).radiance(towards)[..., 0, 0]
    picture = np.repeat(sky[..., None], 3, axis=-1).astype(np.float32)
    lights: dict[str, Any] = {"sky": {"type": "envmap", "bitmap": mitsuba.Bitmap(picture)}}
    for k, disc in enumerate(light.discs):
        lights[f"disc{k}"] = {
            "type": "directional",
            "direction": (-disc.direction).tolist(),
            "irradiance": {"type": "uniform", "value": float(disc.irradiance()[0])},
        }
    return lights


def _shapes(mitsuba: Any, scene: omma.Scene) -> dict[str, Any]:
    """A mesh for each material, diffuse from both sides."""
    images = scene.images
    shapes = {}
    for k, mesh in enumerate(scene.meshes):
        material = scene.materials[mesh.material]
        use = material.base_color_texture
        reflectance: dict[str, Any] = {"type": "rgb", "value": list(material.base_color[:3])}
        if use is not None:
            texels = linear_pixels(images[scene.textures[use.texture].image].pixels[..., :3])
            texels *= np.asarray(material.base_color[:3], np.float32)
            # Raw numbers are no colours that could be spectra.
            raw = mitsuba.variant().endswith("rgb")
            reflectance = {"type": "bitmap", "bitmap": mitsuba.Bitmap(texels), "raw": raw}
        properties = mitsuba.Properties()
        properties["own"] = mitsuba.load_dict(
            {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}
        )
        shape = mitsuba.Mesh(
            f"mesh{k}", len(mesh.positions_m), len(mesh.triangles),
            has_vertex_texcoords=True, props=properties,
        )  # fmt: skip
        values = mitsuba.traverse(shape)
        values["vertex_positions"] = mesh.positions_m.ravel()
        values["vertex_texcoords"] = mesh.texture_coordinates.ravel()
        values["faces"] = mesh.triangles.ravel()
        values.update()
        shapes[f"mesh{k}"] = shape
    return shapes
