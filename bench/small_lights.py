"""How far off single responses are where small lights are about, and what they cost a frame.

.venv/bin/python bench/small_lights.py [FRAMES]

1,500 ommatidia of 5 deg look all around from within a shell of lights of 5 mm, 3 m away, over a
matt floor; 16 rays each. Those that look up see the lights alone, in the dark: their responses are
compared with the sum over the lights of radiance, solid angle and sensitivity, one by one, frame by
frame.
"""

import platform
import sys
import time

import numpy as np

import omma

RADIANCE, RADIUS_M, AWAY_M, WIDTH_RAD = 3.0, 0.005, 3.0, np.radians(5.0)
BANDS = omma.light.Bands.equal(1, 400, 700)


def flat(value: float) -> omma.light.Spectrum:
    return omma.light.Spectrum([300.0, 800.0], [value, value])


def scene_of(places_m: np.ndarray) -> omma.Scene:
    shining = omma.scene.Material(
        "shining", specular=0, base_color=(0, 0, 0, 1), emissive=(1, 1, 1), emission=flat(RADIANCE)
    )
    matt = omma.scene.Material("matt", specular=0, reflectance=flat(0.3))
    lights = [
        omma.scene.disc(RADIUS_M, center_m=place, facing=-place, segments=4).replace(
            materials=[shining]
        )
        for place in places_m
    ]
    floor = omma.scene.plane((20, 20), center_m=(0, -1, 0), facing=(0, 1, 0))
    return omma.scene.merge_scenes([floor.replace(materials=[matt]), *lights])


def expected(axes: np.ndarray, places_m: np.ndarray) -> np.ndarray:
    """Of each ommatidium, for lights far smaller than its acceptance."""
    cosine = np.clip(axes @ (places_m / AWAY_M).T, -1, 1)
    sensitivity = np.exp(-4 * np.log(2) * (np.arccos(cosine) / WIDTH_RAD) ** 2)
    solid_sr = 2 * RADIUS_M**2 / AWAY_M**2
    return RADIANCE * solid_sr * sensitivity.sum(1) / omma.receptors.solid_angle_sr(WIDTH_RAD)


def main() -> None:
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    random = np.random.default_rng(2)
    axes, shell = random.normal(size=(1500, 3)), random.normal(size=(1024, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    shell *= AWAY_M / np.linalg.norm(shell, axis=1, keepdims=True)
    shell[:, 1] = np.abs(shell[:, 1])
    eye = omma.Eye(np.zeros((1500, 3)), axes, WIDTH_RAD)
    up = axes[:, 1] > np.sin(4 * WIDTH_RAD)
    print(f"{platform.machine()}, {len(eye)} ommatidia, 16 rays, best of {frames}")
    print("lights   ms a frame   off by, rms   error claimed, rms   z, rms")
    for count in (1, 4, 16, 64, 256, 1024):
        world = omma.World(
            scene_of(shell[:count]), light=omma.light.lamps(bands=BANDS, unit="watts")
        )
        renderer = omma.Renderer(world, eye, omma.Fixed(16), noise="new_every_frame")
        renderer.render(np.eye(4))
        best, found, claimed = np.inf, [], []
        for _ in range(frames):
            begin = time.perf_counter()
            response, error = renderer.render(np.eye(4), standard_error=True)
            best = min(best, time.perf_counter() - begin)
            found.append(response[0, up, 0].astype(float))
            claimed.append(error[0, up, 0].astype(float))
        true = expected(axes[up], shell[:count])
        seen = true > 1e-3 * true.max()
        off = (np.array(found)[:, seen] - true[seen]) / true[seen]
        said = np.array(claimed)[:, seen] / true[seen]
        z = np.sqrt(np.mean((off / said) ** 2))
        rms, of_said = np.sqrt(np.mean(off**2)), np.sqrt(np.mean(said**2))
        print(f"{count:6d} {1e3 * best:12.1f} {100 * rms:11.2f} % {100 * of_said:18.2f} % {z:8.2f}")


if __name__ == "__main__":
    main()
