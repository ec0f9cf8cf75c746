"""What data sets cost: views per second beside `render` alone, memory, size, reading at random; and
whether fifty kills leave a trace.

    python bench/datasets.py [--quick]

Prints CSV. The ratio to `render` is of shards that take turns with calls of `render` for the same
poses, in processor time, so that other work on the machine disturbs both alike. Other times are
wall times: keep the machine idle.
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
from pathlib import Path

import numpy as np

import omma
from omma.datasets.layout import make_layouts, view_bytes
from omma.datasets.plan import make_plan
from omma.datasets.records import digests_of_inputs
from omma.datasets.shards import make_shard
from omma.datasets.worlds import Workshop, load_eyes

COLUMNS = "what,setting,value"
OMMATIDIA, VIEWS, QUICK_VIEWS = 1000, 100_000, 2048
TURNS, QUICK_TURNS = 10, 2
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
report = omma.datasets.run(sys.argv[1])
print(json.dumps([report.seconds, time.perf_counter() - start, time.process_time() - cpu,
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


def print_turns(folder: Path, turns: int) -> None:
    """Views per second of processor time, of shards and of `render` alone, one after the other."""
    job = omma.datasets.load_job(write_job(folder, "turns", 1024 * (turns + 1)))
    eyes = load_eyes(job)
    plan = make_plan(job, view_bytes(make_layouts(job, eyes)))
    layouts = make_layouts(job, eyes, plan)
    omma.datasets.run(
        write_job(folder, "none", 1), folder / "none.zarr"
    )  # reads and builds once, so that nothing is new
    store = folder / "turns.zarr"
    for layout in layouts.values():
        for name in layout.variables:
            (store / layout.group / name).mkdir(parents=True, exist_ok=True)
    (store / "omma" / "done").mkdir(parents=True)
    workshop = Workshop(job, digests_of_inputs(job))
    block = plan.blocks[0]
    renderer = workshop.renderer(block, job.eyes[0].name)
    ratios, rates = [], []
    for shard in range(min(turns + 1, plan.shards)):
        views = plan.views_of(shard)
        poses = workshop.poses(block, views)
        start = time.process_time()
        renderer.render(poses)
        alone = time.process_time() - start
        start = time.process_time()
        make_shard(str(store), workshop, plan, layouts, shard)
        whole = time.process_time() - start
        if shard > 0:  # the first warms up
            ratios.append(alone / whole)
            rates.append(len(views) / alone)
    print(f"views per processor second,render alone,{np.median(rates):.1f}")
    print(f"of render alone,median of {len(ratios)} shards,{np.median(ratios):.3f}", flush=True)


def print_run(folder: Path, count: int, read: int) -> None:
    """A whole job: time, memory, size; and views read from it in random order."""
    job = write_job(folder, "whole", count)
    done = subprocess.run(
        [sys.executable, "-c", RUN, job], capture_output=True, text=True, check=True
    )
    making, wall, cpu, kilobytes = json.loads(done.stdout)
    print(f"views,of {OMMATIDIA} ommatidia,{count}")
    print(f"views per second,whole job,{count / making:.1f}")
    print(f"seconds,whole job with reading and checking inputs,{wall:.1f}")
    print(f"views per processor second,whole job,{count / cpu:.1f}")
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
