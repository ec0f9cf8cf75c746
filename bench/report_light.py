"""The sections of RESULTS.md about light, of light.csv and baked_error.csv as light.py and
baked_error.py print them."""

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
    exact = [1 / times(own, "baked, sun exact") for own in scenes]
    by_map = [1 / times(own, "baked, sun map") for own in scenes]
    polarised = [
        100 * (times(own, way) - 1)
        for own in scenes
        for way in ("direct light, polarised", "paths, polarised")
    ]
    cells: list[list[object]] = [
        ["unlit, frames/s with 16 bands over 3", "0.85", span(bands)],
        ["frames/s in direct light over unlit, same rays", "0.2", span(direct)],
        ["frames/s baked, sun by shadow ray, over unlit", "0.35 to 0.5", span(exact)],
        ["frames/s baked, sun by map, over unlit", "0.75 to 0.9", span(by_map)],
        ["more time for Stokes vectors", "at most 10 %", span(polarised, unit=" %")],
    ]
    ratios = [found[-1] for own in scenes for found in beside_peer(own)]
    if ratios:
        cells.append(["paths/s over Mitsuba's (LLVM)", "2", span(ratios)])
    return cells


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
    """Bias and rms with their standard errors, %, a line for each band, by the ways of the sun."""
    return [
        [
            exact["band_nm"],
            *(
                f"{float(row[what + '_percent']):.2f} ± {float(row[what + '_error']):.2f}"
                for row in (exact, by_map)
                for what in ("bias", "rms")
            ),
        ]
        for exact, by_map in zip(pick(rows, sun="exact"), pick(rows, sun="map"))
    ]
