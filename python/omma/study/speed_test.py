"""The speed test of CompoundRay's paper: frames/s against rays per ommatidium, on this machine.

Its protocol (eLife 2022, 73893; python-examples/speed-test): an eye of 1,000 ommatidia of 2.6°,
frames of one ray each for ten seconds to warm up, then for each number of rays two frames that do
not count and the mean time of those that follow.
"""

from __future__ import annotations

import platform
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye, Scene
from omma.base.arguments import array_of, checked, whole
from omma.base.poses import as_pose
from omma.base.processors import processor_model
from omma.base.progress import Stage, ends_of_steps
from omma.base.values import value_class
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed
from omma.scene.building import BUILDING, stage_of
from omma.study.variance import OURS, Method

# Frames/s of CompoundRay on an NVIDIA RTX 2080 Ti, by rays per ommatidium: eLife 2022, 73893.
PUBLISHED_RAYS = (1, 10, 100, 1000, 3200)
PUBLISHED_FRAMES_PER_S = {
    "CompoundRay, RTX 2080 Ti, arena (published)": (5418, 5607, 4460, 1566, 612),
    "CompoundRay, RTX 2080 Ti, natural scene (published)": (5175, 5091, 4104, 1470, 572),
}


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class SpeedTest:
    """Frames/s for each number of rays per ommatidium (K,), and of what.

    ``frames_per_s`` comes from one call of `Renderer.render` for each frame, as a script that
    reacts to what it sees has to do; ``batch_frames_per_s`` from one call for all of them.
    """

    machine: str
    threads: int
    backend: str
    ommatidia: int
    method: Method
    frames: int
    rays: NDArray[np.int64]
    frames_per_s: NDArray[np.float64]
    batch_frames_per_s: NDArray[np.float64]


@checked
def measure_speed(
    scene: Scene,
    eye: Eye,
    pose: ArrayLike,
    rays: Sequence[int] = (1, 3, 10, 30, 100, 300, 1000, 3200),
    *,
    frames: int = 100,
    warm_up_s: float = 10.0,
    method: Method = OURS,
    threads: int = 0,
    progress: Stage | None = None,
) -> SpeedTest:
    """Time frames of an eye at one pose; every frame draws samples of its own.

    Args:
        scene: what there is to see.
        eye: who sees it; the published test takes ``1000-equidistant.eye``.
        pose: (4, 4) ``world_from_head``, m.
        rays: numbers of rays per ommatidium, (K,).
        frames: that the mean is taken of.
        warm_up_s: seconds of rendering before the clock starts, 0 or more.
        method: angular sensitivity and points.
        threads: 0 takes all.
        progress: called with a stage and its finished share.

    Raises:
        omma.Error: an argument is out of its range.
    """
    whole(frames, "frames", 1, 1 << 20)
    if not 0 <= warm_up_s <= 3600:
        raise Error(f"warm_up_s: expected 0 to 3600, found {warm_up_s}")
    rays = array_of(rays, "rays", (None,), np.int64).tolist()
    if not len(rays):
        raise Error("rays: expected at least one number")
    samplings = [Fixed(count) for count in rays]
    tell: Stage = progress or (lambda stage, fraction: None)
    matrix = as_pose(pose, "pose")[None]
    batch = np.repeat(matrix, frames, axis=0)
    single, together = [], []
    renderer = Renderer(
        scene,
        eye,
        Fixed(1),
        angular_sensitivity=method.angular_sensitivity,
        points=method.points,
        noise="new_every_frame",
        threads=threads,
        progress=stage_of(tell, BUILDING),
    )
    start = time.perf_counter()
    while (passed := time.perf_counter() - start) < warm_up_s:
        tell("Warming up", passed / warm_up_s)
        renderer.render(matrix)
    done = ends_of_steps(rays)
    for index, count in enumerate(rays):
        renderer = renderer.with_eye(eye, samplings[index])
        tell(f"{count} rays", done[index])
        for _ in range(2):
            renderer.render(matrix)
        start = time.perf_counter()
        for _ in range(frames):
            renderer.render(matrix)
        single.append(frames / (time.perf_counter() - start))
        tell(f"{count} rays", (done[index] + done[index + 1]) / 2)
        start = time.perf_counter()
        renderer.render(batch)
        together.append(frames / (time.perf_counter() - start))
    return SpeedTest(
        machine=machine_name(),
        threads=renderer.threads,
        backend=renderer.backend,
        ommatidia=len(eye),
        method=method,
        frames=frames,
        rays=np.array(rays, dtype=np.int64),
        frames_per_s=np.array(single),
        batch_frames_per_s=np.array(together),
    )


def machine_name() -> str:
    """Model of the processor, as the system says it."""
    if model := processor_model():
        return model
    if platform.system() == "Darwin":
        command = ["sysctl", "-n", "machdep.cpu.brand_string"]
        found = subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()
        if found:
            return found
    return platform.processor() or platform.machine() or "unknown processor"
