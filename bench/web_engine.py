"""How fast the engine in WebAssembly is, in Node.js, beside the same search on the same processor.

    .venv/bin/python bench/web_engine.py [--turns 5]

One thread each: omma.js (128-bit lanes), omma_plain.js (none) and the native backend `portable`, in
turns. Seconds are the processor's, and the best frame of all turns counts, so that what else the
machine does plays less of a part.
The meadow, seen by 1,500 ommatidia of a honeybee's eye from ten places of the flight, 4 and 16 rays
each. Prints rays/s and their ratios as CSV. `scripts/web_engine` builds the modules first.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import omma

ROOT = Path(__file__).resolve().parents[1]
OMMATIDIA, POSES = 1500, 10


def seconds_of_module(name: str, request: dict[str, Any]) -> float:
    """Of the fastest round through all poses."""
    module = ROOT / "build" / "web" / "engine" / f"{name}.js"
    run = ["node", str(ROOT / "web" / "engine" / "run.mjs")]
    text = json.dumps(request | {"module": str(module)})
    done = subprocess.run(run, input=text, capture_output=True, text=True, check=True)
    answer = json.loads(done.stdout)
    if "error" in answer:
        raise SystemExit(f"{name}: {answer['error']}")
    return float(np.min(np.reshape(answer["processor_seconds"], (-1, POSES)), axis=0).sum())


def seconds_of_native(renderer: omma.Renderer, poses: np.ndarray, times: int) -> float:
    best = np.full(POSES, np.inf)
    for _ in range(times):
        for i in range(POSES):
            before = time.process_time()
            renderer.render(poses[i : i + 1])
            best[i] = min(best[i], time.process_time() - before)
    return float(best.sum())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--turns", type=int, default=5)
    turns = parser.parse_args().turns
    whole = omma.load_eye(ROOT / "examples" / "honeybee_worker_left.eye")
    eye = whole.take(np.linspace(0, len(whole.axis) - 1, OMMATIDIA).astype(int))
    scene = omma.load_scene(omma.examples.meadow())
    poses = np.asarray(omma.load_poses(omma.examples.flight()))[:: 120 // POSES][:POSES]
    print("rays,what,million_rays_per_s,of_native")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "eye.csv"
        omma.save_eye(file, eye)
        for rays in (4, 16):
            request = {
                "scene": str(omma.examples.meadow()),
                "eye": str(file),
                "options": {"rays": rays},
                "poses": [pose.ravel().tolist() for pose in poses],
                "times": 5,
            }
            renderer = omma.Renderer(scene, eye, omma.Fixed(rays), backend="portable", threads=1)
            best: dict[str, float] = {}
            for _ in range(turns):
                for name in ("omma", "omma_plain", "native"):
                    seconds = (
                        seconds_of_native(renderer, poses, 5)
                        if name == "native"
                        else seconds_of_module(name, request)
                    )
                    best[name] = min(best.get(name, np.inf), seconds)
            for name, seconds in best.items():
                per_s = OMMATIDIA * rays * POSES / seconds / 1e6
                print(f"{rays},{name},{per_s:.3f},{best['native'] / seconds:.3f}", flush=True)


if __name__ == "__main__":
    main()
