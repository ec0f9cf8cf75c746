"""Eyes by rays for each ommatidium, by a small camera for each, and by cube maps that are binned
into ommatidia: errors and times of each, in Omma and, where it is installed, in Mitsuba.

    python bench/many_cameras.py [--quick]

Prints CSV. Mitsuba is `pip install mitsuba`, and DRJIT_LIBLLVM_PATH names a libLLVM.

The scene is the lit meadow, flattened, with diffuse grey surfaces, unlit and in the direct light of
a grey sky and sun; the eyes are a honeybee's and a fruit fly's, less what looks at the sun, which
Mitsuba's cameras cannot see. Errors are in percent of the mean response, root mean squares over
ommatidia, less the variance of the truth: very many rays of Omma, the first row of each table,
which has its own standard error.

- noise_percent: what other random numbers would change; of cube maps what more rays a pixel would,
  aliasing too.
- bias_percent: what more rays leave: pixels that are wide, textures that are filtered, fields of
  view that end.
- place_percent: what it makes that a cube map has one place and an eye as many as ommatidia.

On one thread, at a pose that is another in each frame (not for still cameras): times are the
processor's, medians over some frames, after one that warms up. setup_s is what is made once,
with a first frame; the scene's acceleration structure is not part of it.
"""

from __future__ import annotations

import argparse
import functools
import gc
import math
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from cube_maps import binning_matrix, face_poses
from light_peer import peer_variants
from light_scenes import Setup, diffuse_setup, grey_light, grey_setup, lit_meadow
from numpy.typing import NDArray
from small_cameras import VARIANT, CubeOfCameras, EyeOfCameras, PeerWorld, RaysOfEye

import omma
from omma.light import Bands, Light
from omma.scene import Camera

COLUMNS = (
    "lighting,eye,ommatidia,way,setting,rays_per_ommatidium,setup_s,ms_per_frame,mean,"
    "error_percent,noise_percent,bias_percent,place_percent"
)
SUN_ELEVATION_DEG, SUN_AZIMUTH_DEG = 30.0, 135.0
# What cube maps and rays of Omma are compared with: 8 times as many rays, for its standard error.
TRUE_RAYS, QUICK_TRUE_RAYS = 512, 32
OWN_RAYS, QUICK_OWN_RAYS = (4, 16, 64, 256, 1024), (4, 16)
SHARED_RAYS, QUICK_SHARED_RAYS = (1, 4, 16, 64), (4,)
# Pixels along an edge of a face, rays a pixel.
CUBES = (
    (16, 1), (16, 16), (32, 1), (32, 4), (64, 1), (64, 4), (128, 1), (128, 4), (256, 1), (256, 4),
)  # fmt: skip
QUICK_CUBES = ((16, 1), (32, 1))
# Pixels along an edge of a small camera, rays a pixel.
CAMERAS, QUICK_CAMERAS = ((4, 1), (8, 4)), ((4, 1),)
PEER_RAYS, QUICK_PEER_RAYS = (16, 64, 256), (16,)
# Rays of a cube map without noise.
MANY_RAYS, QUICK_MANY_RAYS = 4_000_000, 200_000
TURNS, QUICK_TURNS = 3, 2
QUICK_OMMATIDIA = 200

See = Callable[[NDArray[np.float64], int], NDArray[np.float32]]


@dataclass(frozen=True)
class Way:
    """One way to see.

    make: sets up, and returns what gives responses (N, 3) at a pose, with random numbers of a
    seed. many: responses of the cube map that has the same pixels and no noise; None: it is none.
    """

    name: str
    setting: str
    rays: float
    make: Callable[[], See]
    many: Callable[[NDArray[np.float64]], NDArray[np.float32]] | None = None


@dataclass(frozen=True)
class Amounts:
    """How much is measured."""

    true_rays: int = TRUE_RAYS
    own_rays: tuple[int, ...] = OWN_RAYS
    shared_rays: tuple[int, ...] = SHARED_RAYS
    cubes: tuple[tuple[int, int], ...] = CUBES
    cameras: tuple[tuple[int, int], ...] = CAMERAS
    peer_rays: tuple[int, ...] = PEER_RAYS
    many_rays: int = MANY_RAYS
    turns: int = TURNS


QUICK = Amounts(
    QUICK_TRUE_RAYS, QUICK_OWN_RAYS, QUICK_SHARED_RAYS, QUICK_CUBES, QUICK_CAMERAS,
    QUICK_PEER_RAYS, QUICK_MANY_RAYS, QUICK_TURNS,
)  # fmt: skip


def blind_to_sun(eye: omma.Eye, pose: NDArray[np.float64], light: Light) -> omma.Eye:
    """The ommatidia that look at none of the discs, by four acceptance angles and more."""
    axis = eye.axis @ pose[:3, :3].T
    looks = [
        np.arccos(np.clip(axis @ disc.direction, -1, 1)) < 4 * eye.acceptance_angle_rad
        for disc in light.discs
    ]
    return eye.take(~np.any(looks, axis=0))


def at_one_place(eye: omma.Eye) -> omma.Eye:
    """The eye with all nodal points in the middle of the head."""
    return eye.replace(position_m=np.zeros_like(eye.position_m))


def on_the_way(pose: NDArray[np.float64], frame: int) -> NDArray[np.float64]:
    """The head some frames later: 5 mm to the side and a degree to the right in each."""
    turn = np.radians(-frame)
    step = np.eye(4)
    step[0, 0] = step[2, 2] = np.cos(turn)
    step[0, 2], step[2, 0] = np.sin(turn), -np.sin(turn)
    step[0, 3] = 0.005 * frame
    return pose @ step


def omma_rays(world: omma.World, eye: omma.Eye, sampling: omma.Fixed | omma.Shared) -> See:
    """Rays of Omma for each ommatidium."""
    renderer = functools.cache(
        lambda seed: omma.Renderer(world, eye, sampling, seed=seed, threads=1)
    )
    renderer(0)
    return lambda pose, seed: renderer(seed).render(pose)[0]


def omma_cube(world: omma.World, size: int, samples: int) -> See:
    """Pixels (6 size², C) of a cube map by Omma's cameras."""

    def see(pose: NDArray[np.float64], seed: int) -> NDArray[np.float32]:
        faces = [
            omma.render_camera(
                world, Camera(yfov_rad=np.pi / 2, aspect_ratio=1.0, world_from_camera=one),
                width=size, height=size, samples=samples, seed=seed,
            )
            for one in face_poses(pose)
        ]  # fmt: skip
        return np.stack(faces).reshape(6 * size**2, -1)

    return see


def binned(eye: omma.Eye, size: int, cube: See) -> See:
    """What ommatidia make of a cube map."""
    matrix = binning_matrix(eye.axis, eye.acceptance_angle_rad, size)
    return lambda pose, seed: matrix @ cube(pose, seed)


def cube_ways(
    name: str, eye: omma.Eye, amounts: Amounts, cube: Callable[[int, int], See]
) -> Iterator[Way]:
    """Cube maps of several sizes; ``cube`` makes one of a size and of rays a pixel."""
    without_noise: dict[int, NDArray[np.float32]] = {}

    def many(pose: NDArray[np.float64], size: int) -> NDArray[np.float32]:
        if size not in without_noise:
            most = max(16, round(amounts.many_rays / (6 * size**2)))
            without_noise[size] = binned(eye, size, cube(size, most))(pose, 2)
        return without_noise[size]

    for size, samples in amounts.cubes:
        yield Way(
            name,
            f"{size} x {size} x {samples}",
            6 * size**2 * samples / len(eye),
            lambda size=size, samples=samples: binned(eye, size, cube(size, samples)),
            functools.partial(many, size=size),
        )


def omma_ways(world: omma.World, eye: omma.Eye, amounts: Amounts) -> Iterator[Way]:
    """All that Omma does by itself."""
    for rays in amounts.own_rays:
        make = functools.partial(omma_rays, world, eye, omma.Fixed(rays))
        yield Way("Omma, own rays", f"{rays}", rays, make)
    for rays in amounts.shared_rays:
        make = functools.partial(omma_rays, world, eye, omma.Shared(rays))
        yield Way("Omma, shared rays", f"{rays}", rays, make)
    yield from cube_ways("Omma, cube map", eye, amounts, functools.partial(omma_cube, world))


def peer_ways(world: PeerWorld, eye: omma.Eye, amounts: Amounts) -> Iterator[Way]:
    """All that Mitsuba does."""
    for rays in amounts.peer_rays:
        yield Way(
            "Mitsuba, rays", f"{rays}", rays,
            lambda rays=rays: RaysOfEye(world, eye, rays).see,
        )  # fmt: skip
    for pixels, samples in amounts.cameras:
        setting, rays = f"{pixels} x {pixels} x {samples}", pixels**2 * samples
        for name, still in (("Mitsuba, cameras", False), ("Mitsuba, still cameras", True)):
            make = functools.partial(EyeOfCameras, world, eye, pixels, samples, still=still)
            yield Way(name, setting, rays, lambda make=make: make().see)
    yield from cube_ways(
        "Mitsuba, cube map", eye, amounts,
        lambda size, samples: CubeOfCameras(world, size, samples).see,
    )  # fmt: skip


def rms(difference: NDArray[np.floating], variance: float = 0.0) -> float:
    """Root mean square, less a variance that is known."""
    return float(np.sqrt(max(0.0, np.mean(np.square(difference, dtype=float)) - variance)))


@dataclass(frozen=True)
class Truth:
    """Responses (N, 3) of very many rays, those of the eye at one place, and their variance."""

    seen: NDArray[np.float32]
    central: NDArray[np.float32]
    variance: float


def find_truth(world: omma.World, eye: omma.Eye, pose: NDArray[np.float64], rays: int) -> Truth:
    """With 8 times as many rays as ``rays``, and no textures filtered."""
    found = []
    for one in (eye, at_one_place(eye)):
        renderer = omma.Renderer(
            world, one, omma.Fixed(rays), threads=1, footprints=False, seed=12345
        )
        seen, error = renderer.render(pose, standard_error=True)
        found.append((seen[0], float(np.mean(np.square(error, dtype=float)))))
    return Truth(found[0][0], found[1][0], found[0][1])


def measure(
    way: Way, truth: Truth, pose: NDArray[np.float64], turns: int
) -> tuple[float, float, dict[str, float]]:
    """Seconds to set up, ms a frame, and the mean and errors in the response's unit."""
    start = time.process_time()
    see = way.make()
    seen = see(pose, 0)
    setup_s = time.process_time() - start
    see(on_the_way(pose, 1), 0)
    taken = []
    for turn in range(turns):
        moved = on_the_way(pose, turn + 2)
        start = time.process_time()
        see(moved, 0)
        taken.append(1e3 * (time.process_time() - start))
    found = {"mean": float(seen.mean()), "error": rms(seen - truth.seen, truth.variance)}
    if way.many is None:
        found["noise"] = rms(seen - see(pose, 1)) / math.sqrt(2)
        found["bias"] = rms(seen - truth.seen, truth.variance + found["noise"] ** 2)
        found["place"] = 0.0
    else:
        many = way.many(pose)
        found["noise"] = rms(seen - many)
        found["bias"] = rms(many - truth.central, truth.variance)
        found["place"] = rms(truth.central - truth.seen)
    return setup_s, float(np.median(taken)), found


def print_rows(
    lighting: str, name: str, setup: Setup, ways: list[Way], truth: Truth, turns: int
) -> None:
    """A table of one eye in one light, its truth first."""
    scale = 100 / float(truth.seen.mean())
    count = len(setup.eye)
    own = f"{scale * math.sqrt(truth.variance):.4f}"
    print(f"{lighting},{name},{count},truth,,,,,{truth.seen.mean():.6g},{own},{own},,", flush=True)
    for way in ways:
        setup_s, ms, found = measure(way, truth, setup.pose, turns)
        parts = ",".join(f"{scale * found[key]:.4f}" for key in ("error", "noise", "bias", "place"))
        print(
            f'{lighting},{name},{count},"{way.name}",{way.setting},{way.rays:.4g},{setup_s:.3f},'
            f"{ms:.3f},{found['mean']:.6g},{parts}",
            flush=True,
        )
        # Mitsuba asks all cameras that there are, those of other ways too.
        gc.collect()


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    # The scene's file says of itself that without a light it is not lit, which is meant.
    warnings.simplefilter("ignore", UserWarning)
    amounts = QUICK if given.quick else Amounts()
    meadow = grey_setup(diffuse_setup(lit_meadow()))
    clear = omma.light.clear_sky(SUN_ELEVATION_DEG, sun_azimuth_deg=SUN_AZIMUTH_DEG)
    light = grey_light(clear, Bands.equal(3, 400.0, 700.0))
    nothing = omma.Background.constant((0, 0, 0))
    worlds = {
        "unlit": omma.World(meadow.scene, background=nothing, threads=1),
        "direct light": omma.World(meadow.scene, light=light, lighting="path", depth=1, threads=1),
    }
    eyes = {"honeybee": meadow.eye, "fruit fly": omma.species.drosophila().eye}
    has_peer = VARIANT in peer_variants()
    print(COLUMNS)
    for lighting, world in worlds.items():
        peer = PeerWorld(meadow.scene, light, lighting) if has_peer else None
        for name, whole in eyes.items():
            eye = blind_to_sun(whole, meadow.pose, light)
            if given.quick:
                eye = eye.take(np.linspace(0, len(eye) - 1, QUICK_OMMATIDIA).astype(int))
            ways = list(omma_ways(world, eye, amounts))
            if peer is not None:
                ways += peer_ways(peer, eye, amounts)
            truth = find_truth(world, eye, meadow.pose, amounts.true_rays)
            print_rows(lighting, name, replace(meadow, eye=eye), ways, truth, amounts.turns)


if __name__ == "__main__":
    main()
