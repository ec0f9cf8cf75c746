"""Makes RESULTS.md of the tables of a bench run.

python bench/report.py RESULTS_FOLDER > RESULTS.md
"""

from __future__ import annotations

import sys
from pathlib import Path

from curves import Row, least, pick, random_error, read
from report_cameras import AT_PERCENT, all_table, times_table
from report_light import baked, baked_error, light, light_to_error
from report_speed import (
    OURS,
    build,
    ceiling,
    error,
    fraction_of_ceiling,
    frames,
    instructions,
    kernels,
    latency,
    moving,
    threads,
)
from report_text import number, table, text

FOUR_SCENES = ("meadow", "arena", "checkerboard", "grass")


def aims(results: Path) -> list[str]:
    """What was aimed at, beside what the tables below say about it."""
    cells: list[list[object]] = []
    rows = read(results, "ceiling")
    for name, least_rays, most_rays, aim in (("1 ray", 1, 1, 75), ("8 rays and more", 8, 1e9, 90)):
        found = [fraction_of_ceiling(r) for r in rows if least_rays <= int(r["rays"]) <= most_rays]
        if found:
            span = f"{100 * min(found):.0f} to {100 * max(found):.0f} %"
            cells.append([f"share of the ceiling, {name}", f"{aim} %", span])
    errors = read(results, "error")
    fewer = []
    for scene in FOUR_SCENES:
        if own := pick(errors, scene=scene):
            ways = [least(own, begins, random_error(own, 100)) for begins in OURS]
            best = min((way for way in ways if way), key=lambda way: way.rays, default=None)
            reached = f"{100 / best.rays:.1f} ({best.method})" if best else "not reached"
            fewer.append(f"{scene} {reached}")
    if fewer:
        cells.append(["times fewer rays to the error of 100 random ones", "5", ", ".join(fewer)])
    if own := pick(errors, scene="meadow"):
        ways = [least(own, begins, random_error(own, 100), "ms") for begins in OURS]
        best = min((way for way in ways if way), key=lambda way: way.ms, default=None)
        reached = f"{number(1e3 / best.ms)} ({best.method})" if best else "not reached"
        what = "frames/s of the bee in the meadow at the error of 100 random rays"
        cells.append([what, "900", reached])
    for row in pick(read(results, "frames"), ommatidia=1000, rays=1):
        reached = number(float(row["frames_per_s"]))
        cells.append(["frames/s of 1,000 ommatidia at 1 ray", "20,000", reached])
    for row in pick(read(results, "latency"), ommatidia=1000, rays=1, language="C++"):
        reached = f"{float(row['median_us']) - float(row['batch_us']):.1f} µs"
        cells.append(["start-up of a single frame of 1,000 ommatidia at 1 ray", "20 µs", reached])
    if rows := pick(read(results, "kernels"), sensitivity="mixed"):
        fractions = [100 * float(row["over_gaussian"]) for row in rows]
        reached = f"{min(fractions):.0f} to {max(fractions):.0f} %"
        cells.append(["frames/s of an eye of mixed kernels over one of Gaussians", "80 %", reached])
    rows = read(results, "build")
    for row in pick(rows, scene="natural-standin-sky"):
        reached = f"{float(row['first_frame_ms']):.0f} ms"
        cells.append(["natural-standin-sky from file to first frame", "300 ms", reached])
    if large := max(rows, key=lambda row: int(row["triangles"]), default=None):
        what = f"peak memory over that of the meshes, {int(large['triangles']):,} triangles"
        ratio = float(large["peak_mb"]) / float(large["mesh_mb"])
        cells.append([what, "about 2", f"{ratio:.1f}"])
    return ["## Aims and what is reached", "", *table("what | aim | reached", cells)]


def cameras(rows: list[Row]) -> list[str]:
    """The section of RESULTS.md about many cameras."""
    errors = " | ".join(f"ms to {error:.0f} %" for error in AT_PERCENT)
    return [
        "## 11. Many cameras",
        "",
        *text(
            "`bench/many_cameras.py`: one thread, processor time of a frame, at a pose that is",
            "another in each; errors are root mean squares over ommatidia in percent of the mean",
            "response. What it means: [notes/many-cameras.md](notes/many-cameras.md).",
        ),
        *table(f"lighting | eye | way | {errors} | least error, %", times_table(rows)),
        *text("All that was measured; pixels along an edge, squared, by rays a pixel:"),
        *table(
            "lighting | eye | way | rays | rays per ommatidium | set-up, s | ms a frame "
            "| error, % | noise, % | bias, % | place, %",
            all_table(rows),
        ),
    ]


def motion(rows: list[Row]) -> list[str]:
    """The section of RESULTS.md about what motion and time cost."""
    shares = {
        (row["scene"], row["setting"]): row["value"]
        for row in pick(rows, what="of the still world")
    }
    rates = pick(rows, what="frames per second")
    return [
        "## 12. Motion and time",
        "",
        *text(
            "`bench/motion.py`: 1,000 ommatidia of 16 rays, one thread, processor time in turns;",
            "100 spheres of which all move, above a plain and above the bundled meadow.",
        ),
        *table(
            "scene | what | frames/s | of the still world's",
            [
                [row["scene"], row["setting"], row["value"], shares[row["scene"], row["setting"]]]
                for row in rates
            ],
        ),
        *text(
            "One turn of a closed loop above the plain, wall time of set_transforms of 10 things,",
            "render and reading the responses, µs:",
        ),
        *table(
            "share of the turns | at most",
            [[row["setting"], row["value"]] for row in pick(rows, what="loop µs")],
        ),
        *text("A frame of a skin on 20 bones, on all threads, wall time, ms:"),
        *table(
            "what | median, or as said",
            [[row["setting"], row["value"]] for row in pick(rows, scene="tube")],
        ),
    ]


def datasets(rows: list[Row]) -> list[str]:
    """The section of RESULTS.md about data sets."""
    return [
        "## 13. Data sets",
        "",
        *text(
            "`bench/datasets.py`: uniform poses in a room of textured triangles, 1,000 ommatidia",
            "of 16 rays; shards beside `render` alone are in processor time, in turns.",
        ),
        *table("what | of | value", [[row["what"], row["setting"], row["value"]] for row in rows]),
    ]


def report(results: Path, quick: bool = False) -> list[str]:
    """The lines of RESULTS.md."""
    facts = {row["what"]: row["found"] for row in read(results, "machine")}
    lines = [
        "# How fast",
        "",
        *text(
            f"Made by `scripts/bench`, as a whole on {facts.pop('date')} on this machine;",
            "light, cameras, motion, data sets and baking may have been run alone since, also",
            "elsewhere. The numbers are in",
            "[results](results), what they mean in [docs/performance.md](../docs/performance.md).",
        ),
        *(f"- {key}: {value}" for key, value in facts.items()),
        "",
    ]
    if quick:
        lines += text("**A quick run, which only tries everything: its numbers mean nothing.**")
    lines += aims(results)
    errors = read(results, "error")
    parts = {
        "ceiling": ceiling,
        "error": error,
        "frames": lambda rows: frames(rows, errors),
        "latency": latency,
        "threads": threads,
        "kernels": kernels,
        "build": build,
        "moving": moving,
        "instructions": instructions,
        "light": light,
        "cameras": cameras,
        "motion": motion,
        "datasets": datasets,
        "baked": baked,
        "baked_error": baked_error,
        "light_to_error": light_to_error,
    }
    missing = []
    for name, part in parts.items():
        if rows := read(results, name):
            lines += part(rows)
        else:
            missing.append(f"- {name} was not measured")
    if errors and not pick(errors, scene="meadow"):
        missing.append("- what needs CompoundRay's scenes and eyes, which are missing here")
    return lines + (["## Left out", "", *missing, ""] if missing else [])


if __name__ == "__main__":
    print("\n".join(report(Path(sys.argv[1]))))
