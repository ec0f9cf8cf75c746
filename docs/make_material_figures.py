"""Makes docs/materials.png, docs/materials-water.png and the table in docs/materials.md.

.venv/bin/python docs/make_material_figures.py
"""

import csv
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import omma
from omma.scene import NaturalMaterial, water

FOLDER = Path(__file__).resolve().parent
SOURCES = FOLDER.parent / "python" / "omma" / "scene" / "material_sources.csv"
PAGE = FOLDER / "materials.md"
START, END = "<!-- table: made by make_material_figures.py -->", "<!-- end of the table -->"
MATERIALS = omma.scene.natural_materials()

# Of each panel: title, upper end (with room for the names), materials with their colours.
PANELS = [
    (
        "Leaves and blades",
        0.55,
        {"green leaf": "#1b7a2f", "grass blade": "#7fb03a", "dry grass": "#b5892e"},
    ),
    (
        "Swards and bark",
        0.85,
        {
            "green sward": "#1b7a2f",
            "dry sward": "#b5892e",
            "bark": "#6b4b32",
            "birch bark": "#8a8f98",
        },
    ),
    (
        "Ground",
        1.5,
        {
            "dark soil": "#4a3626",
            "light soil": "#a0713f",
            "sand": "#d1a94a",
            "rock": "#7b7f86",
            "snow": "#4aa3d8",
        },
    ),
    (
        "Petals that absorb ultraviolet",
        1.0,
        {
            "white petal": "#8a8f98",
            "yellow petal": "#d9a800",
            "red petal": "#c4302b",
            "pink petal": "#d467a8",
            "dark petal": "#2d1a2e",
        },
    ),
    (
        "Petals that reflect it",
        1.0,
        {
            "white petal with ultraviolet": "#8a8f98",
            "yellow petal with ultraviolet": "#d9a800",
            "red petal with ultraviolet": "#c4302b",
            "blue petal": "#3b5bdb",
        },
    ),
    (
        "Water and made surfaces",
        1.0,
        {
            "pond water": "#18445c",
            "concrete": "#9a9a94",
            "asphalt": "#333333",
            "sky-blue paint": "#2e9bd6",
        },
    ),
]


def draw(panel: Axes, material: NaturalMaterial, color: str) -> None:
    nm = material.wavelength_nm
    panel.plot(nm, material.total_reflectance, color=color, lw=1.8, label=material.name)
    if material.total_transmittance is not None:
        panel.plot(nm, material.total_transmittance, color=color, lw=1.2, ls=(0, (3, 2)))
    read = [
        (fact.wavelength_nm, fact.value)
        for fact in material.facts
        if fact.standing == "read" and fact.wavelength_nm is not None
    ]
    if read:
        panel.plot(*zip(*read), "o", color=color, ms=4)


def figure() -> None:
    drawn = [name for _, _, shown in PANELS for name in shown]
    assert sorted(drawn) == sorted(MATERIALS)
    figure, panels = plt.subplots(2, 3, figsize=(11, 6.4), sharex=True)
    for panel, (title, top, shown) in zip(panels.ravel(), PANELS):
        panel.axvspan(300, 400, color="0.93", lw=0)
        for name, color in shown.items():
            draw(panel, MATERIALS[name], color)
        panel.set_title(title, loc="left", fontsize=10)
        panel.set_xlim(300, 700)
        panel.set_ylim(0, top)
        panel.set_yticks([tick for tick in panel.get_yticks() if tick <= min(top, 1)])
        panel.spines[["top", "right"]].set_visible(False)
        panel.tick_params(labelsize=8.5)
        panel.legend(fontsize=7.5, frameon=False, loc="upper left")
    for panel in panels[1]:
        panel.set_xlabel("wavelength (nm)", fontsize=9)
    for panel in panels[:, 0]:
        panel.set_ylabel("reflected (line), transmitted (dashes)", fontsize=9)
    figure.tight_layout()
    figure.savefig(FOLDER / "materials.png", dpi=110)


def mean(material: NaturalMaterial, low: float, high: float) -> str:
    nm = material.wavelength_nm
    return f"{np.mean(material.total_reflectance[(nm >= low) & (nm <= high)]):.3f}"


def table() -> str:
    head = ["material", "300–400", "400–500", "500–600", "600–700", "through", "ior", "roughness"]
    head += ["numbers: read, computed, assumed"]
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    for material in MATERIALS.values():
        counts = [
            str(sum(fact.standing == standing for fact in material.facts))
            for standing in ("read", "computed", "assumed")
        ]
        through = material.total_transmittance
        cells = [material.name, *(mean(material, nm, nm + 100) for nm in (300, 400, 500, 600))]
        cells += ["–" if through is None else f"{through.max():.2f}"]
        cells += [f"{material.ior:g}" if material.specular else "–", f"{material.roughness:g}"]
        lines.append("| " + " | ".join([*cells, ", ".join(counts)]) + " |")
    lines += ["", "Sources, and what of each was read:", ""]
    with SOURCES.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if row["key"] != "omma":
                lines.append(f"- {row['citation']} [{row['read']}]")
    return "\n".join(lines)


# Of the figure of water: types, depths of a bottom of sand (None: none), winds, m/s, and what the
# pictures of glitter show, degrees.
TYPES = ("I", "IB", "III", "1C", "5C", "9C")
DEPTHS_M = (None, 10.0, 3.0, 1.0, 0.3, 0.0)
WINDS = (0.0, 1.0, 5.0, 12.0)
SUN_DEG, WIDE_DEG, LOW_DEG, HIGH_DEG, PER_DEG = 25.0, 35.0, -60.0, 5.0, 3


def coloured(type_: str, depth_m: float | None) -> tuple[float, float, float]:
    """Of what comes out of water, as people see it, 1.7 times as bright."""
    made = water(type_, depth_m=depth_m, bottom=None if depth_m is None else "sand")
    linear = np.clip(1.7 * np.array(made.base_color[:3]), 0, 1)
    return tuple(np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))


def lake(wind_m_per_s: float) -> np.ndarray:
    """A lake with wind towards the sun, as people see it: an ommatidium a pixel."""
    ground = omma.scene.plane((4000, 4000)).replace(
        materials=[water("3C", wind_m_per_s=wind_m_per_s)]
    )
    sky = omma.light.clear_sky(SUN_DEG, bands=omma.light.Bands.equal(8, 400, 700))
    across = np.arange(-WIDE_DEG, WIDE_DEG, 1 / PER_DEG) + 0.5 / PER_DEG
    rise = np.arange(HIGH_DEG, LOW_DEG, -1 / PER_DEG) - 0.5 / PER_DEG
    axis = omma.eye.direction(across, rise[:, None]).reshape(-1, 3)
    eye = omma.Eye(np.zeros_like(axis), axis, np.radians(1 / PER_DEG))
    world = omma.World(ground, light=sky)
    pose = omma.look_at((0, 2, 0), (0, 2, -1))
    seen = omma.Renderer(world, eye, omma.Fixed(32)).render(pose)[0]
    colours = omma.picture.bands_to_rgb(seen, sky).reshape(len(rise), len(across), 3)
    return omma.picture.display(1 - np.exp(-colours / 2.5))


def water_figure() -> None:
    figure = plt.figure(figsize=(11, 7.2), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=[1.15, 1])
    panel, swatches = above.subplots(1, 2)
    panel.axvspan(300, 400, color="0.93", lw=0)
    for type_, colour in zip(
        TYPES, ("#1f3b99", "#3b7dd8", "#2a9d8f", "#7fb03a", "#b5892e", "#6b4b32")
    ):
        made = water(type_).reflectance
        panel.plot(made.wavelength_nm, made.value, color=colour, lw=1.8, label=type_)
    panel.set(xlim=(300, 700), ylim=(0, None), xlabel="wavelength (nm)")
    panel.set_title("Out of deep water: reflectance of the base, by type", loc="left", fontsize=10)
    panel.spines[["top", "right"]].set_visible(False)
    panel.legend(fontsize=8, frameon=False, ncols=2)

    panel = swatches
    panel.imshow([[coloured(type_, depth) for type_ in TYPES] for depth in DEPTHS_M], aspect="auto")
    panel.set_xticks(range(len(TYPES)), TYPES)
    rows = ["no bottom" if depth is None else f"{depth:g} m" for depth in DEPTHS_M]
    panel.set_yticks(range(len(DEPTHS_M)), rows)
    panel.tick_params(length=0)
    panel.set_title(
        "The same over sand, by type and depth, 1.7 times as bright", loc="left", fontsize=10
    )

    for k, (panel, wind) in enumerate(zip(below.subplots(1, len(WINDS)), WINDS)):
        extent = (-WIDE_DEG, WIDE_DEG, LOW_DEG, HIGH_DEG)
        panel.imshow(lake(wind), extent=extent, interpolation="nearest")
        panel.set_title("no wind" if wind == 0 else f"wind {wind:g} m/s", loc="left", fontsize=10)
        panel.set_xticks([-25, 0, 25], ["25° left", "sun", "25° right"])
        ticks = [0, -SUN_DEG, -50]
        panel.set_yticks(
            ticks, [f"{tick:g}°".replace("-", "−") for tick in ticks] if k == 0 else [""] * 3
        )
        panel.tick_params(length=2, labelsize=8.5)
    figure.savefig(FOLDER / "materials-water.png", dpi=100)


def main() -> None:
    figure()
    water_figure()
    text = PAGE.read_text(encoding="utf-8")
    before, after = text[: text.index(START)], text[text.index(END) :]
    PAGE.write_text(f"{before}{START}\n\n{table()}\n\n{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
