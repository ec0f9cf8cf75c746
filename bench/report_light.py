"""The sections of RESULTS.md about light, of light.csv, baked_error.csv and light_to_error.csv as
light.py, baked_error.py and light_to_error.py print them."""

from __future__ import annotations

from curves import Row, pick

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


def scenes_of(rows: list[Row]) -> list[str]:
    """The scenes of a table, in its order."""
    return list(dict.fromkeys(row["scene"] for row in rows))


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
    """What the bake is off by, %, a line for each time of day and band."""
    names = ("bias", "rms", "median", "percentile_95", "darkest_third_rms")
    return [
        [row["time"], row["band_nm"], *(row[f"{name}_percent"] for name in names), row["rms_z"]]
        for row in rows
    ]


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
        lines.append(
            [row["scene"], row["way"], row["ms_a_frame"], row["noise_percent"],
             row["fixed_percent"], row["percentile_95_percent"], *of_frames]
        )  # fmt: skip
    return lines


def beside_paths(rows: list[Row]) -> list[tuple[str, str, float]]:
    """Scene, way of Mitsuba, and how many times as long as Omma's paths it takes to the error."""
    found = []
    for row in rows:
        if row["way"].startswith("Omma") or not row["ms_to_5_percent"]:
            continue
        own = pick(rows, scene=row["scene"], way="Omma, paths")[0]["ms_to_5_percent"]
        found.append((row["scene"], row["way"], float(row["ms_to_5_percent"]) / float(own)))
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
