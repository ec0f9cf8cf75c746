"""Runs the measurements and writes what they print: results/*.csv, RESULTS.md and the figures.
`scripts/bench` builds everything and calls this.

    python bench/run.py --program build/bench/bench/omma_bench [--quick] [--out FOLDER] [PART ...]

Without PARTs all are measured; with some, the others' tables stay as they are.
"""

from __future__ import annotations

import argparse
import csv
import datetime
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BENCH = Path(__file__).resolve().parent
ROOT = BENCH.parent
DATA = ROOT.parent / "shared" / "data" / "compound-ray"
sys.path[:0] = [str(BENCH), str(ROOT / "docs")]

import make_loop_figure  # noqa: E402
import make_many_cameras_figure  # noqa: E402
import make_performance_figures  # noqa: E402
import report  # noqa: E402
from make_large_scene import write_scene  # noqa: E402

# Parts that are programs in Python, and whether they take the folder of CompoundRay's data.
SCRIPTS = {"light": ("light.py", True), "cameras": ("many_cameras.py", False),
           "motion": ("motion.py", False), "datasets": ("datasets.py", False),
           "baked": ("baked.py", False), "baked_error": ("baked_error.py", False),
           "light_to_error": ("light_to_error.py", True), "gpu": ("gpu.py", True)}  # fmt: skip
PARTS = ("ceiling", "error", "frames", "latency", "threads", "kernels", "build", "moving",
         "search", "worlds", "instructions", *SCRIPTS)  # fmt: skip
COUNTED = ("1", "16", "16-plain", "16-random", "16-shared", "target")


def printed_table(command: list[str | Path]) -> list[str]:
    """Lines of a table that a command prints, shown as they come."""
    lines = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            print("  " + line, end="", flush=True)
            lines.append(line.strip())
    if process.returncode != 0:
        raise SystemExit(f"{command[0]} ended with {process.returncode}")
    return lines


def run_quietly(*command: str | Path) -> str:
    """What a command says, "" where it is missing."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return ""
    return done.stdout.strip()


def write_lines(path: Path, lines: list[str]) -> None:
    """A file, whole or not at all."""
    partial = path.with_suffix(".partial")
    partial.write_text("\n".join(lines) + "\n")
    partial.replace(path)


def machine() -> list[str]:
    """What this runs on, as CSV."""

    def found(file: str, pattern: str) -> str:
        path = Path(file)
        match = re.search(pattern, path.read_text(), re.M) if path.exists() else None
        return match.group(1).strip() if match else "unknown"

    flags = found("/proc/cpuinfo", r"^flags\s*:(.*)").split()
    has_512 = {"avx512f", "avx512bw", "avx512dq", "avx512vl", "avx512cd"} <= set(flags)
    has_2 = {"avx2", "fma", "bmi2", "f16c"} <= set(flags)
    memory_kib = found("/proc/meminfo", r"^MemTotal:\s*(\d+)")
    memory = f"{int(memory_kib) / 2**20:.0f} GiB" if memory_kib.isdigit() else memory_kib
    facts = {
        "date": datetime.date.today().isoformat(),
        "processor": f"{found('/proc/cpuinfo', r'^model name.*?:(.*)')}, {os.cpu_count()} cores",
        "instruction set": "AVX-512" if has_512 else "AVX2" if has_2 else platform.machine(),
        "memory": memory,
        "system": found("/etc/os-release", r'^PRETTY_NAME="(.*)"'),
        "compiler": run_quietly("c++", "--version").split("\n")[0],
        "Embree": run_quietly("dpkg-query", "-W", "-f=${Version}", "libembree-dev") or "unknown",
        "other work before": f"load average {os.getloadavg()[0]:.2f}",
    }
    return ["what,found", *(f'{key},"{value}"' for key, value in facts.items())]


def measure_latency(program: Path, quick: list[str]) -> list[str]:
    """From C++ and from Python."""
    lines = printed_table([program, "latency", *quick])
    if not DATA.exists():
        print("  left out: latency in Python (it is measured in CompoundRay's scenes)")
        return lines
    return lines + printed_table([sys.executable, BENCH / "latency.py", DATA, *quick])[1:]


def measure_build(program: Path, quick: list[str]) -> list[str]:
    """Scenes of more and more triangles, each in processes of its own: the quickest of some."""
    with tempfile.TemporaryDirectory() as folder:
        scenes = [("bundled meadow", ROOT / "examples" / "meadow.glb", 3)]
        if DATA.exists():
            natural = DATA / "scenes" / "natural-standin-sky.gltf"
            scenes.insert(0, ("natural-standin-sky", natural, 5))
        for count, runs in ((10_000, 1), (100_000, 1)) if quick else ((10**6, 3), (10**7, 2)):
            file = Path(folder) / f"hills-{count}.glb"
            write_scene(file, count)
            scenes.append(("hills", file, runs))
        lines: list[str] = []
        for name, file, runs in scenes:
            command: list[str | Path] = [program, "build", name, file]
            found = [printed_table(command) for _ in range(1 if quick else runs)]
            column = found[0][0].split(",").index("first_frame_ms")
            best = min(found, key=lambda lines: float(lines[1].split(",")[column]))
            lines += best if not lines else best[1:]
    return lines


def measure_instructions(program: Path) -> list[str] | None:
    """Instructions of fixed small renders, beside those that were checked in."""
    if shutil.which("valgrind") is None:
        print("  left out: instruction counts (valgrind is not installed)")
        return None
    kept = run_quietly("git", "-C", ROOT, "show", "HEAD:bench/results/instructions.csv")
    before = {row["render"]: int(row["now"]) for row in csv.DictReader(kept.splitlines())}
    lines = ["render,previous,now,change_percent"]
    for which in COUNTED:
        valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
        inside = ["--collect-atstart=no", "--toggle-collect=omma::Renderer::render(*"]
        done = subprocess.run(
            [*valgrind, *inside, program, "instructions", which],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        match = re.search(r"Collected : (\d+)", done.stderr)
        if done.returncode != 0 or match is None or match.group(1) == "0":
            raise SystemExit(f"counting instructions failed:\n{done.stderr}")
        now = int(match.group(1))
        old = before.get(which)
        change = "" if old is None else f"{100 * (now / old - 1):+.2f}"
        lines.append(f"{which},{'' if old is None else old},{now},{change}")
        print("  " + lines[-1], flush=True)
    return lines


def main() -> None:
    """Measure, write, draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, required=True, help="omma_bench, built")
    parser.add_argument("--quick", action="store_true", help="tiny settings: only tries it all")
    parser.add_argument("--out", type=Path, help="folder to write to instead of bench/ and docs/")
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}")
    given = parser.parse_args()
    unknown = set(given.parts) - set(PARTS)
    if unknown:
        parser.error(f"expected {', '.join(PARTS)}, found {', '.join(sorted(unknown))}")
    if given.quick and given.out is None:
        parser.error("--quick needs --out: its numbers mean nothing")
    out = given.out or BENCH
    results = out / "results"
    results.mkdir(parents=True, exist_ok=True)
    quick = ["--quick"] if given.quick else []
    write_lines(results / "machine.csv", machine())
    for part in PARTS:
        # Few machines have a card: it is asked for by name.
        if part not in given.parts if given.parts else part == "gpu":
            continue
        print(f"{part}", flush=True)
        start = time.monotonic()
        if part == "latency":
            lines = measure_latency(given.program, quick)
        elif part == "build":
            lines = measure_build(given.program, quick)
        elif part in SCRIPTS:
            name, takes_data = SCRIPTS[part]
            data = [DATA] if takes_data and DATA.exists() else []
            lines = printed_table([sys.executable, BENCH / name, *data, *quick])
        elif part == "instructions":
            lines = measure_instructions(given.program)
        else:
            lines = printed_table([given.program, part, *quick])
        if lines is not None:
            write_lines(results / f"{part}.csv", lines)
        print(f"  {time.monotonic() - start:.0f} s", flush=True)
    write_lines(out / "RESULTS.md", report.report(results, given.quick))
    make_performance_figures.make(results, given.out or ROOT / "docs")
    make_many_cameras_figure.make(results, given.out or ROOT / "docs")
    make_loop_figure.make(results, given.out or ROOT / "docs")
    print(f"Wrote {out / 'RESULTS.md'}, {results} and the figures.")


if __name__ == "__main__":
    main()
