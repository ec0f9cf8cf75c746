"""What data sets cost: views per second beside `render` alone, memory, size, reading at random; and
whether fifty kills leave a trace.

    python bench/datasets.py [--quick]

Prints CSV. A job and its shards are compared with `render` by turns, so that other work on the
machine disturbs both alike: shards with calls of `render` for the same poses, a whole job with
calls while it is stopped for a moment. Other times are wall times: keep the machine idle.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import omma
from omma.datasets.layout import Layout, make_layouts, planned, view_bytes
from omma.datasets.plan import Plan, make_plan
from omma.datasets.records import digests_of_inputs
from omma.datasets.shards import make_shard
from omma.datasets.worlds import Workshop, load_eyes

COLUMNS = "what,setting,value"
OMMATIDIA, VIEWS, QUICK_VIEWS = 1000, 100_000, 2048
TURNS, QUICK_TURNS = 10, 2
TURN_S, TURN_VIEWS = 4.0, 256  # how long a job goes on between two turns of `render`
READ, QUICK_READ = 1000, 100
KILLS, QUICK_KILLS = 50, 3

JOB = """
[dataset]
seed = 3
{dataset}
[rendering]
samples = 16
[[scene]]
file = "room.glb"
[[eye]]
files = "eye.csv"
[[poses]]
sampler = "uniform"
low_m = [-2, 0.3, -2]
high_m = [2, 1.5, 2]
clearance_m = 0.1
count = {count}
"""

# Runs a job and says what it took, in a process of its own so that memory is its own.
RUN = """
import json, resource, sys, time
import omma
start, cpu = time.perf_counter(), time.process_time()
omma.datasets.run(sys.argv[1])
print(json.dumps([time.perf_counter() - start, time.process_time() - cpu,
                  resource.getrusage(resource.RUSAGE_SELF).ru_maxrss]))
"""


def write_inputs(folder: Path) -> None:
    """A room with textured walls and boxes in it, and an eye."""
    rng = np.random.default_rng(1)
    tiles = rng.uniform(0.1, 0.9, (128, 128, 3)).astype(np.float32)
    parts = [omma.scene.plane((10, 10), tiles)]
    for k in range(20):
        x, z = rng.uniform(-4, 4, 2)
        parts.append(
            omma.scene.place_scene(
                omma.scene.box((0.4, 0.8, 0.4), tiles[k : k + 32, :32], name=f"box {k}"),
                omma.poses_from_angles((x, 0.4, z), (rng.uniform(0, 90), 0, 0))[0],
            )
        )
    sky = omma.Background.simple_sky()
    omma.scene.save_scene(folder / "room.glb", omma.scene.merge_scenes(parts, background=sky))
    omma.save_eye(folder / "eye.csv", omma.eye.generate_eye(OMMATIDIA))


def write_job(folder: Path, name: str, count: int, dataset: str = "") -> Path:
    """A job for these inputs."""
    path = folder / f"{name}.toml"
    path.write_text(JOB.format(count=count, dataset=dataset))
    return path


@dataclass
class Beside:
    """What `render` alone needs for views of the same job."""

    job: omma.datasets.Job
    plan: Plan
    layouts: dict[str, Layout]
    workshop: Workshop
    views: int = 0
    wall_s: float = 0.0
    cpu_s: float = 0.0

    def render(self, views: range) -> float:
        """Render some of the job's views and write nothing; the processor time, s."""
        block = self.plan.blocks[0]
        poses = self.workshop.poses(block, views)
        renderer = self.workshop.renderer(block, self.job.eyes[0].name)
        wall, cpu = time.perf_counter(), time.process_time()
        renderer.render(poses)
        spent = time.process_time() - cpu
        self.views += len(poses)
        self.wall_s += time.perf_counter() - wall
        self.cpu_s += spent
        return spent


def beside(path: Path) -> Beside:
    """Of a job's file."""
    job = omma.datasets.load_job(path)
    eyes = load_eyes(job)
    of_one_view = make_layouts(job, eyes)
    plan = make_plan(job, view_bytes(of_one_view))
    made = Beside(job, plan, planned(of_one_view, plan), Workshop(job, digests_of_inputs(job)))
    made.render(plan.views_of(0))
    made.views, made.wall_s, made.cpu_s = 0, 0.0, 0.0  # what the first time takes does not count
    return made


def print_turns(folder: Path, turns: int) -> None:
    """Views per second of processor time, of shards and of `render` alone, one after the other."""
    alone = beside(write_job(folder, "turns", 1024 * (turns + 1)))
    omma.datasets.run(
        write_job(folder, "none", 1), folder / "none.zarr"
    )  # reads and builds once, so that nothing is new
    store = folder / "turns.zarr"
    for layout in alone.layouts.values():
        for name in layout.variables:
            (store / layout.group / name).mkdir(parents=True, exist_ok=True)
    (store / "omma" / "done").mkdir(parents=True)
    ratios = []
    for shard in range(1, min(turns + 1, alone.plan.shards)):
        render = alone.render(alone.plan.views_of(shard))
        start = time.process_time()
        make_shard(str(store), alone.workshop, alone.plan, alone.layouts, shard)
        ratios.append(render / (time.process_time() - start))
    print(f"views per processor second,render alone,{alone.views / alone.cpu_s:.1f}")
    print(f"of render alone,median of {len(ratios)} shards,{np.median(ratios):.3f}", flush=True)


def print_run(folder: Path, count: int, read: int) -> None:
    """A whole job: time, memory, size; and views read from it in random order."""
    job = write_job(folder, "whole", count)
    alone = beside(job)
    stopped, first = 0.0, 0
    with subprocess.Popen([sys.executable, "-c", RUN, job], stdout=subprocess.PIPE) as process:
        while True:
            try:
                process.wait(TURN_S)
                break
            except subprocess.TimeoutExpired:
                start = time.perf_counter()
                process.send_signal(signal.SIGSTOP)
                alone.render(range(first, first + TURN_VIEWS))
                first = (first + TURN_VIEWS) % (count - TURN_VIEWS)
                process.send_signal(signal.SIGCONT)
                stopped += time.perf_counter() - start
        said = process.communicate()[0]
    wall, cpu, kilobytes = json.loads(said)
    wall -= stopped
    print(f"views,of {OMMATIDIA} ommatidia,{count}")
    print(f"seconds,whole job with reading and checking inputs,{wall:.1f}")
    for clock, job_s, render_s in (("", wall, alone.wall_s), ("processor ", cpu, alone.cpu_s)):
        render = alone.views / render_s
        print(f"views per {clock}second,whole job,{count / job_s:.1f}")
        print(f"views per {clock}second,render alone in turns with it,{render:.1f}")
        print(f"of render alone,whole job by {clock}seconds,{count / job_s / render:.3f}")
    print(f"peak memory MB,whole job,{kilobytes / 1024:.0f}")
    store = folder / "whole.zarr"
    size = sum(file.stat().st_size for file in store.rglob("*") if file.is_file())
    print(f"size MB,store,{size / 1e6:.1f}")
    print(f"size MB,as float32,{count * OMMATIDIA * 12 / 1e6:.1f}", flush=True)
    views = omma.datasets.open_views(store)
    chosen = np.random.default_rng(1).choice(len(views), read, replace=False)
    views[0]
    start = time.perf_counter()
    for k in chosen:
        views[int(k)]
    print(f"seconds,{read} random views one by one,{time.perf_counter() - start:.2f}")
    start = time.perf_counter()
    views[chosen]
    print(f"seconds,{read} random views at once,{time.perf_counter() - start:.2f}")
    start, found = time.perf_counter(), 0
    for batch in omma.datasets.batches(views, 64):
        found += len(batch["response"])
        if found >= 10 * read:
            break
    rate = found / (time.perf_counter() - start)
    print(f"views per second,read in shuffled batches of 64,{rate:.0f}", flush=True)


def print_kills(folder: Path, kills: int) -> None:
    """Kills at random moments, then a run to the end, beside one that nobody disturbed."""
    job = write_job(folder, "kills", 3000, "views_per_chunk = 8\nviews_per_shard = 24")
    subprocess.run([sys.executable, "-c", RUN, job], capture_output=True, check=True)
    (folder / "kills.zarr").rename(folder / "undisturbed.zarr")
    rng, killed = random.Random(1), 0
    for _ in range(kills):
        known = shards_done(folder)
        with subprocess.Popen(
            [sys.executable, "-c", RUN, job], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as process:
            # Some while it starts, some after a shard or two more, so that runs get somewhere and
            # the job is not done before.
            more, end = rng.randint(0, 2), time.monotonic() + 60
            while shards_done(folder) < known + more and process.poll() is None:
                if time.monotonic() > end:
                    raise RuntimeError("expected a shard within a minute, found none")
                time.sleep(0.001)
            time.sleep(rng.uniform(0, 1.5 if more == 0 else 0.05))
            process.send_signal(signal.SIGKILL)
        killed += process.returncode == -signal.SIGKILL
    done = shards_done(folder)
    left = len(list((folder / "kills.zarr").rglob(".*.partial")))
    subprocess.run([sys.executable, "-c", RUN, job], capture_output=True, check=True)
    print(f"kills,at random moments,{killed}")
    print(f"shards,there after the kills (of 125),{done}")
    print(f"files,left by the kills,{left}")
    print(f"files,left after the last run,{len(list((folder / 'kills.zarr').rglob('.*')))}")
    print(f"files,that differ from an undisturbed run,{len(differing(folder))}")
    report = omma.datasets.verify(folder / "kills.zarr")
    print(f"whole,by verify,{int(report.is_whole)}", flush=True)


def shards_done(folder: Path) -> int:
    return len(list((folder / "kills.zarr" / "omma" / "done").glob("*.json")))


def differing(folder: Path) -> list[str]:
    """Files of the two stores that are not the same, but for times and machines."""
    found = []
    for path in sorted((folder / "undisturbed.zarr").rglob("*")):
        name = os.path.relpath(path, folder / "undisturbed.zarr")
        other = folder / "kills.zarr" / name
        if not path.is_file() or path.parent.name == "done" or name == "zarr.json":
            continue
        if not other.is_file() or path.read_bytes() != other.read_bytes():
            found.append(name)
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    print(COLUMNS)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_inputs(folder)
        print_turns(folder, QUICK_TURNS if quick else TURNS)
        print_run(folder, QUICK_VIEWS if quick else VIEWS, QUICK_READ if quick else READ)
        print_kills(folder, QUICK_KILLS if quick else KILLS)


if __name__ == "__main__":
    main()
