"""What weather costs a frame of the lit meadow, by paths: air between surfaces, clouds; and what
refraction does where its pond fills a third of the view.

.venv/bin/python bench/weather.py [ROUNDS]

An ant's eye in the meadow, 16 rays an ommatidium, one thread. The lights take turns, and the best
of some rounds counts (25), as on a busy machine it is nearest to an idle one.
"""

import platform
import sys
import time
import warnings

import numpy as np

import omma
from omma.light import clear_sky, clouded, with_air

# The middle of the meadow's pond, and how far above it the pond is a third of an ant's view.
POND_M, HEIGHT_M = np.array([34.7, -0.2, -15.5]), 0.8


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 25
    warnings.simplefilter("ignore")  # of light that the file's own colours do not need
    clear = clear_sky(30, sun_azimuth_deg=135)
    lights = {
        "clear": clear,
        "air of the clear sky": with_air(clear),
        "mist, 60 m": with_air(clear, 60, layer_height_m=0),
        "half clouded": clouded(clear, 0.5),
        "half clouded, mist": with_air(clouded(clear, 0.5), 60, layer_height_m=0),
    }
    scene = omma.load_scene(omma.examples.lit_meadow())
    pose = scene.cameras[0].world_from_camera
    eye = omma.species.melophorus().eye
    camera = scene.cameras[0].name
    print(f"{platform.machine()}, {len(eye)} ommatidia, camera {camera}, best of {rounds}")
    for polarized in (False, True):
        worlds = {
            name: omma.World(scene, light=light, polarized=polarized)
            for name, light in lights.items()
        }
        print("polarised" if polarized else "unpolarised")
        compare(worlds, eye, pose, rounds)
    print("over the pond, unpolarised")
    ponds = {
        name: omma.World(with_pond(scene, water), light=clear)
        for name, water in (
            ("a surface", omma.scene.water("IB", depth_m=0.5, bottom="light soil")),
            ("that bends rays", omma.scene.water_volume("IB")),
        )
    }
    above = np.eye(4)
    above[:3, 3] = POND_M + (0, HEIGHT_M, 0)
    compare(ponds, eye, above, rounds)


def with_pond(scene: omma.Scene, water: omma.scene.Material) -> omma.Scene:
    """The meadow with other water in its pond, over the meadow's own ground."""
    materials = [water if one.name == "pond water" else one for one in scene.materials]
    return scene.replace(materials=materials)


def compare(worlds: dict[str, omma.World], eye: omma.Eye, pose: np.ndarray, rounds: int) -> None:
    """Print the time of a frame of each world, and over that of the first."""
    renderers = {
        name: omma.Renderer(world, eye, omma.Fixed(16), threads=1) for name, world in worlds.items()
    }
    best_s = dict.fromkeys(renderers, np.inf)
    for renderer in renderers.values():
        renderer.render(pose)
    for _ in range(rounds):
        for name, renderer in renderers.items():
            began = time.process_time()
            renderer.render(pose)
            best_s[name] = min(best_s[name], time.process_time() - began)
    first_s = next(iter(best_s.values()))
    for name, seconds in best_s.items():
        print(f"  {name:22} {1e3 * seconds:7.1f} ms  {seconds / first_s:.3f}")


main()
