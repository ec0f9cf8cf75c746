"""The sections of RESULTS.md about light, of light.csv, baked_error.csv and light_to_error.csv as
light.py, baked_error.py and light_to_error.py print them."""

from __future__ import annotations

from curves import Row, pick, scenes_of
from report_text import table, text

PEERS = ("llvm_ad_rgb", "llvm_ad_spectral")
# What a part costs: what one way takes more than another.
PARTS = (
    ("first hit and its colour (unlit)", "unlit", "nothing, unlit"),
    ("16 bands instead of RGB", "unlit in bands", "unlit"),
    ("surfaces as they scatter light", "dark", "unlit in bands"),
    ("the sun chosen, no shadow ray", "sun below", "dark"),
    ("shadow ray, the sun's light scattered", "sun", "sun below"),
    ("the sky chosen, shadow ray, its light", "sky", "dark"),
    ("the sky looked up by a ray that meets nothing", "nothing, sky", "nothing, dark"),
    ("second scattering", "up to 2", "direct light"),
    ("third and fourth", "up to 4", "up to 2"),
    ("fifth to eighth", "up to 8", "up to 4"),
    ("all further ones", "paths", "up to 8"),
    ("Stokes vectors in direct light", "direct light, polarised", "direct light"),
    ("Stokes vectors of paths", "paths, polarised", "paths"),
)


def nanoseconds(rows: list[Row], way: str) -> float:
    """What a ray takes in a way, one scene's rows given."""
    return float(pick(rows, way=way)[0]["ns_per_ray"])


def times(rows: list[Row], way: str) -> float:
    """How many times as long as the way that it is compared with."""
    return float(pick(rows, way=way)[0]["times"])


def part_costs(rows: list[Row]) -> list[tuple[str, float]]:
    """Parts and their nanoseconds for each ray from the eye, of one scene's rows."""
    return [(name, nanoseconds(rows, more) - nanoseconds(rows, less)) for name, more, less in PARTS]


def beside_peer(rows: list[Row]) -> list[tuple[str, float, str, float, float]]:
    """Of one scene: what was followed, Omma's ns a path, the quicker peer, its ns, the ratio."""
    found = []
    for row in rows:
        if not row["way"].startswith("Omma, "):
            continue
        what = row["way"].removeprefix("Omma, ")
        peers = [pick(rows, way=f"{peer}, {what}")[0] for peer in PEERS]
        best = min(peers, key=lambda one: float(one["ns_per_ray"]))
        variant = best["way"].split(", ")[0]
        found.append(
            (what, float(row["ns_per_ray"]), variant, float(best["ns_per_ray"]),
             float(best["times"]))
        )  # fmt: skip
    return found


def aims_of_light(rows: list[Row]) -> list[list[object]]:
    """What was asked and what is reached, the least over the scenes to the most."""
    scenes = [pick(rows, scene=scene) for scene in scenes_of(rows)]

    def span(values: list[float], scale: float = 1.0, unit: str = "") -> str:
        low, high = scale * min(values), scale * max(values)
        return f"{low:.2f} to {high:.2f}{unit}" if high - low > 0.005 else f"{low:.2f}{unit}"

    bands = [1 / times(own, "unlit in bands") for own in scenes]
    direct = [1 / times(own, "direct light") for own in scenes]
    polarised = [
        100 * (times(own, way) - 1)
        for own in scenes
        for way in ("direct light, polarised", "paths, polarised")
    ]
    return [
        ["unlit, frames/s with 16 bands over 3", "0.85", span(bands)],
        ["frames/s in direct light over unlit, same rays", "0.2", span(direct)],
        ["more time for Stokes vectors", "at most 10 %", span(polarised, unit=" %")],
    ]


def ways_table(rows: list[Row]) -> list[list[object]]:
    """All ways but the peers'."""
    found: list[list[object]] = []
    for row in rows:
        if row["way"].split(", ")[0] in ("Omma", *PEERS):
            continue
        ns = float(row["ns_per_ray"])
        found.append(
            [row["scene"], row["way"], row["bands"], f"{ns:,.0f}", f"{1e3 / ns:.2f}",
             row["times"] and f"{row['times']} × {row['compared_with']}"]
        )  # fmt: skip
    return found


def parts_table(rows: list[Row]) -> tuple[str, list[list[object]]]:
    """The head and the lines of what parts cost, a column for each scene."""
    scenes = scenes_of(rows)
    columns = [dict(part_costs(pick(rows, scene=scene))) for scene in scenes]
    lines: list[list[object]] = [
        [name, *(f"{column[name]:,.0f}" for column in columns)] for name, _, _ in PARTS
    ]
    return " | ".join(["part", *(f"{scene}, ns" for scene in scenes)]), lines


def peer_table(rows: list[Row]) -> list[list[object]]:
    """Omma and the quicker of Mitsuba's variants, side by side."""
    return [
        [scene, what, f"{1e3 / own:.2f}", f"{1e3 / peer:.2f}", variant, f"{ratio:.2f}"]
        for scene in scenes_of(rows)
        for what, own, variant, peer, ratio in beside_peer(pick(rows, scene=scene))
    ]


def baked_error_table(rows: list[Row]) -> list[list[object]]:
    """What the bake is off by, %, a line for each scene and band."""
    names = ("bias", "rms", "median", "percentile_95", "darkest_third_rms")
    columns = ("scene", "band_nm", *(f"{name}_percent" for name in names), "rms_z")
    return [[row[name] for name in (*columns, "z_below_2_percent")] for row in rows]


# Over how many frames a bake is spread.
FRAMES = (1, 100, 10_000)


def to_error_table(rows: list[Row]) -> list[list[object]]:
    """Milliseconds of the processor to an error, a line for each scene and way."""
    lines: list[list[object]] = []
    for row in rows:
        reached = row["ms_to_5_percent"]
        of_frames = ["not reached"] * len(FRAMES)
        if reached:
            bake_ms = 1e3 * float(row["bake_cpu_s"])
            of_frames = [f"{float(reached) + bake_ms / frames:,.1f}" for frames in FRAMES]
        each = row["ms_to_5_percent_each"]
        lines.append(
            [row["scene"], row["way"], row["rays"], row["ms_a_frame"], row["noise_percent"],
             row["fixed_percent"], row["percentile_95_percent"], *of_frames,
             f"{float(each):,.1f}" if each else ""]
        )  # fmt: skip
    return lines


RMS, EACH = "ms_to_5_percent", "ms_to_5_percent_each"


def beside_paths(rows: list[Row], aim: str, way: str) -> list[tuple[str, str, float]]:
    """Scene, way of Mitsuba, and how many times as long as a way of Omma it takes to an aim."""
    found = []
    for row in rows:
        if row["way"].startswith("Omma") or not row[aim]:
            continue
        own = pick(rows, scene=row["scene"], way=way)[0][aim]
        found.append((row["scene"], row["way"], float(row[aim]) / float(own)))
    return found


def frames_that_pay(rows: list[Row]) -> list[tuple[str, float | None]]:
    """Scene, and from how many frames on a bake is quicker than paths; None: never."""
    found: list[tuple[str, float | None]] = []
    for row in pick(rows, way="Omma, baked"):
        paths = float(pick(rows, scene=row["scene"], way="Omma, paths")[0]["ms_to_5_percent"])
        reached = row["ms_to_5_percent"]
        saved = paths - float(reached) if reached else -1.0
        bake_ms = 1e3 * float(row["bake_cpu_s"])
        found.append((row["scene"], bake_ms / saved if saved > 0 else None))
    return found


def light(rows: list[Row]) -> list[str]:
    """The section of RESULTS.md about light."""
    head, parts = parts_table(rows)
    lines = [
        "## 10. Light",
        "",
        *text(
            "`bench/light.py`: one thread, all ways in turns, medians of the processor's time for",
            "each ray from the eye; ratios are medians of those within each turn. A clear sky, the",
            "sun 30° high, 16 bands if not said otherwise. Scattered up to so many times; `paths`:",
            "without a limit.",
        ),
        *table("what | asked | reached", aims_of_light(rows)),
        *table("scene | way | bands | ns a ray | million rays/s | compared", ways_table(rows)),
        *text(
            "What each part costs, as differences between two of these, for each ray from the eye:"
        ),
        *table(head, parts),
    ]
    if peers := peer_table(rows):
        lines += text(
            "Beside Mitsuba 3's path integrator, the quicker of its variants `llvm_ad_rgb` and",
            "`llvm_ad_spectral`; Omma with 16 bands. The same triangles (flattened, diffuse,",
            "opaque), sky, sun and number of rays, million paths/s of one core:",
        )
        lines += table("scene | scattered | Omma | Mitsuba | its variant | ratio", peers)
    return lines


def baked(rows: list[Row]) -> list[str]:
    """The section of RESULTS.md about what baking takes."""
    head = "triangles | bands | cells | cell, m | baked, MB | core-s | s | peak, MB"
    columns = ("cells", "cell_m", "baked_mb", "cpu_s", "wall_s", "peak_mb")
    return [
        "## 14. Baking light",
        "",
        *text(
            "`bench/baked.py`: hills in the light of a clear sky, 16 paths a side of a cell.",
            "Core-seconds are of all cores together; the peak is the whole process's.",
        ),
        *table(
            head,
            [
                [f"{int(row['triangles']):,}", row["bands"], *(row[name] for name in columns)]
                for row in rows
            ],
        ),
    ]


def baked_error(rows: list[Row]) -> list[str]:
    """The section of RESULTS.md about what baked light is off by."""
    first_of_scene = [pick(rows, scene=scene)[0] for scene in scenes_of(rows)]
    return [
        "## 15. Baked light beside paths",
        "",
        *text(
            "`bench/baked_error.py`: a honeybee's ommatidia that look at the ground of the lit",
            "meadow at dusk and at noon, and what is seen of a room and a corridor; the bake",
            "alone: %, relative to each response, without the noise of rays. z: baked minus paths",
            "over the standard error of a frame, and how many of 100 are below 2.",
        ),
        *text(
            *(
                f"{row['scene'].capitalize()}: {int(row['cells']):,} cells of {row['paths']} paths "
                f"a side took {row['bake_cpu_s']} core-seconds and {row['baked_mb']} MB."
                for row in first_of_scene
            )
        ),
        *table(
            "scene | band, nm | bias | rms | median | 95 % below | darkest third, rms | z, rms "
            "| z < 2, %",
            baked_error_table(rows),
        ),
    ]


def light_to_error(rows: list[Row]) -> list[str]:
    """The section of RESULTS.md about time to an error of lit frames."""
    pays = [
        f"{scene}: " + ("never" if frames is None else f"{frames:,.0f}")
        for scene, frames in frames_that_pay(rows)
    ]
    equal, to_error = "Omma, paths", "Omma, paths to an error"
    beside = [
        "; ".join(f"{scene}, {of}: {x:.1f}" for scene, of, x in beside_paths(rows, aim, way))
        for aim, way in ((RMS, equal), (RMS, to_error), (EACH, to_error))
    ]
    return [
        "## 16. Time to an error in light",
        "",
        *text(
            f"`bench/light_to_error.py`: {rows[0]['ommatidia']} ommatidia, one thread,",
            "milliseconds of the processor for a frame whose error, relative to each response, is",
            "5 % (rms over ommatidia), with the bake spread over so many frames; `each`: when 95",
            "of 100 ommatidia have less noise than 5 % of their own response. Noise and what stays",
            "whatever rays there are, %, are of so many rays an ommatidium.",
        ),
        *table(
            "scene | way | rays | ms a frame | noise | fixed | 95 % below | to 5 %, 1 frame "
            "| 100 frames | 10,000 frames | each",
            to_error_table(rows),
        ),
        *text("Frames from which on baking pays: " + "; ".join(pays) + "."),
        *(
            text(
                f"Times as long as Omma's paths of as many rays, to the same rms: {beside[0]};",
                f"as those to an error: {beside[1]}; the same, to the error of each: {beside[2]}.",
            )
            if beside[0]
            else []
        ),
    ]
