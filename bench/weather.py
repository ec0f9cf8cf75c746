"""What weather costs a frame of the lit meadow, by paths: air between surfaces, clouds, stars.

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
        renderers = {
            name: omma.Renderer(
                omma.World(scene, light=light, polarized=polarized), eye, omma.Fixed(16), threads=1
            )
            for name, light in lights.items()
        }
        best_s = dict.fromkeys(renderers, np.inf)
        for renderer in renderers.values():
            renderer.render(pose)
        for _ in range(rounds):
            for name, renderer in renderers.items():
                began = time.process_time()
                renderer.render(pose)
                best_s[name] = min(best_s[name], time.process_time() - began)
        print("polarised" if polarized else "unpolarised")
        for name, seconds in best_s.items():
            print(f"  {name:22} {1e3 * seconds:7.1f} ms  {seconds / best_s['clear']:.3f}")


main()
