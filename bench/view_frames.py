"""How fast the window into the eye is: frames/s of its page, beside those of the renderer alone.

    python bench/view_frames.py [--lit] [SAMPLES ...]

A honeybee's two eyes go along the bundled flight over the bundled meadow. For each number of rays,
in turns: the renderer alone; and all that the page does for a frame that moves, which is rendering,
painting the picture (800 x 400, facets) and encoding it as JPEG. With --lit it is the lit meadow in
the light of a clear morning, baked (minutes, the first time). With each frame's wall time goes
the processor time of all threads: on a machine with other work that is what can be compared. Prints
CSV.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Callable

import omma
from omma.view.page import encoded
from omma.view.painting import channels_of, eye_ids, paint_eye, shown_values
from omma.view.poses import pose_from_matrix
from omma.view.state import Look, Looker

_ROUNDS = 3


def frame_times(frame: Callable[[Look], object], looks: list[Look]) -> tuple[float, float]:
    """Median wall time of a frame, and processor time of the mean one, ms."""
    walls = []
    before = time.process_time()
    for look in looks:
        start = time.perf_counter()
        frame(look)
        walls.append(1e3 * (time.perf_counter() - start))
    return statistics.median(walls), 1e3 * (time.process_time() - before) / len(looks)


def lit_meadow() -> omma.World:
    """The bundled meadow with spectra; how well its light is baked makes no difference here."""
    scene = omma.load_scene(omma.examples.lit_meadow())
    return omma.World(
        scene,
        light=omma.light.clear_sky(30, sun_azimuth_deg=135),
        lighting="baked",
        bake=omma.scene.Bake(paths=16),
    )


def main(samples: list[int], is_lit: bool) -> None:
    world = lit_meadow() if is_lit else omma.World(omma.load_scene(omma.examples.meadow()))
    eye = omma.species.honeybee_worker().eye
    looker = Looker(world, eye)
    channel = channels_of(world, eye)[0]
    ids = eye_ids(eye, "facets on the eye", 800)
    poses = [pose_from_matrix(one) for one in omma.load_poses(omma.examples.flight())[::3]]
    load = os.getloadavg()[0]
    print(f"# {len(eye)} ommatidia, {os.cpu_count()} threads of hardware, load before: {load:.1f}")
    print("samples,what,wall_ms,frames_per_s,processor_ms,processor_ratio")
    for count in samples:
        looks = [Look(pose, samples=count) for pose in poses]
        renderer = looker.renderer(looks[0], count)

        def render(look: Look, renderer: omma.Renderer = renderer) -> None:
            renderer.render(look.pose.world_from_head)

        def page(look: Look) -> None:
            seen = looker.see(look)
            encoded(paint_eye(ids, shown_values(world, eye, seen, channel), 1.0, 0.0), "JPEG")

        render(looks[0])
        found: dict[str, list[tuple[float, float]]] = {"render": [], "page": []}
        for _ in range(_ROUNDS):
            found["render"].append(frame_times(render, looks))
            found["page"].append(frame_times(page, looks))
        least = {name: [min(each) for each in zip(*times)] for name, times in found.items()}
        for name, (wall, processor) in least.items():
            ratio = processor / least["render"][1]
            print(f"{count},{name},{wall:.1f},{1e3 / wall:.1f},{processor:.1f},{ratio:.2f}")


if __name__ == "__main__":
    words = sys.argv[1:]
    main([int(word) for word in words if word != "--lit"] or [1, 2, 4, 8, 16], "--lit" in words)
