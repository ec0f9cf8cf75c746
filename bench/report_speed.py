"""The sections of RESULTS.md about speed, of the tables that omma_bench prints."""

from __future__ import annotations

from curves import Reached, Row, crossing, least, pick, random_error, scenes_of
from report_text import number, table, text

from omma.study.speed_test import PUBLISHED_FRAMES_PER_S, PUBLISHED_RAYS

NATURAL = "CompoundRay, RTX 2080 Ti, natural scene (published)"
# The published honeybee: about 50 rays for each of 6,000 ommatidia (eLife 2022, 73893).
BEE_RAYS, BEE_FRAMES_PER_S = 50, 3000
AT_16 = ("no footprints", "footprints", "shared rays")  # whose bias is shown
OURS = ("footprints", "shared", "target")  # how the names of our methods begin


def published() -> dict[int, int]:
    """Frames/s of CompoundRay in a natural scene, by rays per ommatidium."""
    return dict(zip(PUBLISHED_RAYS, PUBLISHED_FRAMES_PER_S[NATURAL], strict=True))


def fraction_of_ceiling(row: Row) -> float:
    """How much of what Embree can trace the whole render reaches."""
    return float(row["render_mrays_per_s"]) / float(row["ceiling_mrays_per_s"])


def ceiling(rows: list[Row]) -> list[str]:
    """Section 1 of RESULTS.md."""
    found: list[list[object]] = []
    for row in rows:
        top, whole = float(row["ceiling_mrays_per_s"]), float(row["render_mrays_per_s"])
        frames = 1e6 * whole / float(row["rays"]) / float(row["ommatidia"])
        cells = [row["scene"], f"{int(row['triangles']):,}", row["ommatidia"], row["rays"]]
        fraction = f"{100 * fraction_of_ceiling(row):.0f} %"
        found.append([*cells, number(top), number(whole), fraction, number(frames)])
    return [
        "## 1. Ceiling and whole render",
        "",
        *text(
            "Best of each, one pose a call, all threads. The ceiling is tracing alone:",
            "`rtcIntersect16`, coherent, on the render's own packets and in its own scene, which",
            "is watertight (Embree's robust mode). Rays each: per ommatidium.",
        ),
        *table(
            "scene | triangles | ommatidia | rays each | ceiling, million rays/s "
            "| render, million rays/s | share | frames/s",
            found,
        ),
    ]


def ways_to(own: list[Row], error: float, random: Reached) -> list[tuple[str, Reached | None]]:
    """What each method takes to an error in one scene."""
    target = least(own, "target", error)
    return [
        ("random", random),
        ("no footprints", crossing(pick(own, method="no footprints"), error)),
        ("footprints", crossing(pick(own, method="footprints"), error)),
        ("shared rays", crossing(pick(own, method="shared rays"), error)),
        ("error target" if target is None else f"error {target.method}", target),
    ]


def error(rows: list[Row]) -> list[str]:
    """Section 2 of RESULTS.md."""
    found: list[list[object]] = []
    bias: list[list[object]] = []
    for scene in scenes_of(rows):
        own = pick(rows, scene=scene)
        e100 = random_error(own, 100)
        base = pick(own, method="random", setting=100)[0]
        random = Reached(100, float(base["ms_per_frame"]), "random")
        for name, way in ways_to(own, e100, random):
            cells: list[object] = [scene, own[0]["ommatidia"], f"{e100:.5f}", name]
            if way is None:
                found.append([*cells, "not reached", "", "", "", ""])
                continue
            cells += [number(way.rays), f"{100 / way.rays:.2f}", number(way.ms)]
            found.append([*cells, number(1e3 / way.ms), f"{random.ms / way.ms:.1f}"])
        own_16 = [pick(own, method=method, setting=16) for method in AT_16]
        bias.append([scene, *(f"{r[0]['bias']} of {r[0]['rms']}" if r else "" for r in own_16)])
    references = [f"{n:,}" for n in sorted({int(row["reference_rays"]) for row in rows})]
    return [
        "## 2. To the error of 100 random rays",
        "",
        *text(
            "Error: root mean square over all ommatidia and channels of the difference to a",
            f"reference of {' or '.join(references)} rays (the fewer in grass) without footprints;",
            "full scale is 1. Random: independent directions for every ray of every frame, as",
            "CompoundRay has them. Rays per ommatidium: of all that are traced where neighbours",
            "share them, and a mean with an error target, whose `from` is the least that an",
            "ommatidium gets. Times are per frame in a batch. Between",
            "the points of results/error.csv, straight lines on logarithmic axes.",
        ),
        *table(
            "scene | ommatidia | error | method | rays | times fewer | ms per frame | frames/s "
            "| times faster",
            found,
        ),
        *text(
            "Bias: the root mean square, over ommatidia and channels, of what is left of the",
            "difference to the reference when noise is averaged away (0: less than this measures),",
            "and of how much error; all at 16 rays.",
        ),
        *table(
            "scene | no footprints | footprints | shared rays",
            bias,
        ),
    ]


def equal_error(rows: list[Row]) -> list[tuple[str, int, float, float, Reached]]:
    """Ommatidia, random rays, their error, CompoundRay's frames/s, and what ours takes."""
    asked = {"meadow 1000": published(), "meadow": {BEE_RAYS: BEE_FRAMES_PER_S}}
    found = []
    for scene, by_rays in asked.items():
        own = pick(rows, scene=scene)
        for rays, theirs in by_rays.items() if own else ():
            wanted = random_error(own, rays)
            ways = [least(own, begins, wanted, "ms") for begins in OURS]
            best = min((way for way in ways if way), key=lambda way: way.ms, default=None)
            if best is not None:
                found.append((own[0]["ommatidia"], rays, wanted, theirs, best))
    return found


def frames(rows: list[Row], errors: list[Row]) -> list[str]:
    """Section 3 of RESULTS.md."""
    theirs = published()
    small, large = sorted({int(row["ommatidia"]) for row in rows})
    cells: list[list[object]] = []
    for n in sorted({int(row["rays"]) for row in rows}):
        ours = [pick(rows, ommatidia=e, rays=n)[0]["frames_per_s"] for e in (small, large)]
        bee = f"{BEE_FRAMES_PER_S:,}" if n == BEE_RAYS else ""
        natural = f"{theirs[n]:,}" if n in theirs else ""
        cells.append([f"{n:,}", natural, number(float(ours[0])), bee, number(float(ours[1]))])
    lines = [
        "## 3. Frames per second beside CompoundRay's",
        "",
        *text(
            "Published: Millward, Maddock, Mangan 2022, eLife 73893, on an NVIDIA RTX 2080 Ti,",
            f"1,000 ommatidia in a natural scene and a honeybee of 6,000. Ours: {rows[0]['scene']}",
            "(which comes with CompoundRay in place of the published one), many poses in one call,",
            "all threads. At the same number of rays:",
        ),
        *table(
            f"rays each | 1,000, CompoundRay | {small:,}, Omma | 6,000, CompoundRay "
            f"| {large:,}, Omma",
            cells,
        ),
    ]
    equal = equal_error(errors)
    if not equal:
        return [*lines, *text("At equal error: not measured here.")]
    return [
        *lines,
        *text(
            "At equal error, that of CompoundRay's random rays in our scene, by the quickest of",
            "our methods:",
        ),
        *table(
            "ommatidia | random rays | error | CompoundRay, frames/s | Omma, frames/s | ratio "
            "| Omma's rays | method",
            [
                [n, f"{rays:,}", f"{e:.5f}", f"{cr:,}", number(1e3 / way.ms),
                 f"{1e3 / way.ms / cr:.2f}", number(way.rays), way.method]
                for n, rays, e, cr, way in equal
            ],
        ),
    ]  # fmt: skip


def latency(rows: list[Row]) -> list[str]:
    """Section 4 of RESULTS.md."""
    found: list[list[object]] = []
    for row in rows:
        middle, slow, batch = (float(row[k]) for k in ("median_us", "p99_us", "batch_us"))
        cells = [row["language"], row["scene"], row["ommatidia"], row["rays"]]
        times = [number(value) for value in (middle, slow, batch)]
        found.append([*cells, *times, f"{middle - batch:.1f}"])
    return [
        "## 4. Latency of one frame",
        "",
        *text(
            "Closed loop: one pose, its responses, the next pose; all threads. Start-up is what a",
            "frame takes longer so than in a batch.",
        ),
        *table(
            "from | scene | ommatidia | rays each | median, µs | 99 % are below, µs "
            "| in a batch, µs | start-up, µs",
            found,
        ),
    ]


def serial_fraction(one_s: float, many_s: float, threads: int) -> float:
    """Of Amdahl's rule T(n) / T(1) = s + (1 - s) / n; below 0 where n threads are more than n
    times faster, which is noise.
    """
    return (threads * many_s / one_s - 1) / (threads - 1)


def threads(rows: list[Row]) -> list[str]:
    """Section 5 of RESULTS.md."""
    found = []
    for row in rows:
        n = int(row["threads"])
        first = pick(rows, ommatidia=row["ommatidia"], rays=row["rays"], threads=1)[0]
        cells: list[object] = [row["scene"], row["ommatidia"], row["rays"], n]
        for key in ("batch_us", "single_us"):
            one, now = float(first[key]), float(row[key])
            if n == 1:
                cells += [number(now), "", "", ""]
                continue
            serial = serial_fraction(one, now, n)
            kept = max(0.0, serial)
            on_16 = 1 / (kept + (1 - kept) / 16)
            cells += [number(now), f"{one / now:.2f}", f"{100 * serial:.1f} %", f"{on_16:.1f}"]
        found.append(cells)
    return [
        "## 5. Threads",
        "",
        *text(
            "Best of several rounds in which the numbers of threads took turns; of single frames",
            "their median. Serial: the share of a frame on one thread that more threads do not",
            "shorten, by Amdahl's rule; on 16: the speedup that this share allows on 16 cores.",
        ),
        *table(
            "scene | ommatidia | rays each | threads | batch, µs per frame | speedup | serial "
            "| on 16 | single, µs | speedup | serial | on 16",
            found,
        ),
    ]


def kernels(rows: list[Row]) -> list[str]:
    """Section 6 of RESULTS.md."""
    ways = list(dict.fromkeys((row["sampling"], row["rays"]) for row in rows))
    found: list[list[object]] = []
    for kind in dict.fromkeys(row["sensitivity"] for row in rows):
        own = pick(rows, sensitivity=kind)
        fractions = [f"{float(row['over_gaussian']):.2f}" for row in own]
        at_16 = pick(own, sampling="low discrepancy", rays=16)[0]
        found.append([kind, *fractions, number(float(at_16["tables_ms"]))])
    gaussian = pick(rows, sensitivity="gaussian")
    speeds = [number(float(row["frames_per_s"])) for row in gaussian]
    return [
        "## 6. Other angular sensitivities",
        "",
        *text(
            f"Frames/s over those of an eye of Gaussians of one width ({', '.join(speeds)} in the",
            f"order of the columns) in {rows[0]['scene']}, best of seven rounds in which the eyes",
            "took turns. Mixed: nine different kinds in turn, two of them elliptical, one a map.",
            "A width each: Gaussians of as many widths as ommatidia. The last column is what the",
            "tables of directions take to make, once. docs/eyes.md says what the kinds are.",
        ),
        *table(
            " | ".join(
                ["sensitivity", *(f"{rays} rays, {way}" for way, rays in ways), "tables, ms"]
            ),
            found,
        ),
    ]


def build(rows: list[Row]) -> list[str]:
    """Section 7 of RESULTS.md."""
    keys = ("load_ms", "shading_ms", "acceleration_ms", "directions_ms", "first_frame_ms",
            "mesh_mb", "image_mb", "peak_load_mb", "peak_mb")  # fmt: skip
    found: list[list[object]] = []
    for row in rows:
        numbers = [number(float(row[key])) for key in keys]
        ratio = float(row["peak_mb"]) / float(row["mesh_mb"])
        found.append([row["scene"], f"{int(row['triangles']):,}", *numbers, f"{ratio:.1f}"])
    return [
        "## 7. Loading and building",
        "",
        *text(
            "Each in a process of its own, the quickest of some; files that were read before.",
            "Triangles as seen: the bundled meadow places few meshes many times. Meshes: vertices,",
            "texture coordinates and triangles as the Scene holds them. Peaks are of the whole",
            f"process, which starts with {number(float(rows[0]['peak_start_mb']))} MB.",
        ),
        *table(
            "scene | triangles | file to Scene, ms | shading data, ms | acceleration structure, ms "
            "| directions (16 rays), ms | file to first frame, ms | meshes, MB | images, MB "
            "| peak after loading, MB | peak, MB | peak / meshes",
            found,
        ),
    ]


def moving(rows: list[Row]) -> list[str]:
    """Section 8 of RESULTS.md."""
    keys = ("first_move_ms", "move_us", "still_frames_per_s", "moved_frames_per_s",
            "moving_frames_per_s")  # fmt: skip
    found: list[list[object]] = [
        [row["scene"], row["ommatidia"], f"{int(row['moving']):,}",
         *(number(float(row[key])) for key in keys), f"{float(row['share_of_still']):.2f}"]
        for row in rows
    ]  # fmt: skip
    return [
        "## 8. A world that moves",
        "",
        *text(
            "One frame after the other, 16 rays, one call each. Still: nothing has ever moved.",
            "Moved: so many things have been moved before and rest. Moving: they are moved",
            "between any two frames, which the time of `set_transforms` is part of. The first",
            "move builds what does not move again.",
        ),
        *table(
            "scene | ommatidia | things moved | first move, ms | later ones, µs | frames/s, still "
            "| moved | moving | moving / still",
            found,
        ),
    ]


def instructions(rows: list[Row]) -> list[str]:
    """Section 9 of RESULTS.md, the guard against getting slower unseen."""
    found: list[list[object]] = []
    for row in rows:
        before = f"{int(row['previous']) / 1e6:.3f}" if row["previous"] else ""
        change = f"{row['change_percent']} %" if row["change_percent"] else ""
        found.append([row["render"], before, f"{int(row['now']) / 1e6:.3f}", change])
    return [
        "## 9. Instructions",
        "",
        *text(
            "Of fixed small renders on one thread, counted by callgrind: four poses of 1,000",
            "ommatidia over 20,000 triangles, at 1 and 16 rays, 16 without footprints, 16",
            "random, 16 shared, and to an error. A change is one of the program, the compiler",
            "or Embree, not of how busy the machine was. valgrind knows no AVX-512: this is the",
            "AVX2 path. Previous: what was checked in.",
        ),
        *table("render | previous, millions | now, millions | change", found),
    ]
