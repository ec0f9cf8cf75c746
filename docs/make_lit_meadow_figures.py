"""Makes docs/lit-morning.png, lit-noon.png and lit-dusk.png: the lit meadow through a honeybee's
eyes; and docs/lit-rim.png: through the dorsal rims of a desert ant. Light is followed by paths.

    .venv/bin/python docs/make_lit_meadow_figures.py              all four
    .venv/bin/python docs/make_lit_meadow_figures.py noon rim     these

Some minutes on two cores for each of the three lights.
"""

from __future__ import annotations

import sys
from datetime import datetime, timedelta, timezone
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from make_lit_figures import white_ground
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

import omma
from omma.base.directions import azimuth_elevation_deg_of, direction
from omma.base.figures import COLOURS, GREY, INK, figure_style, save_figure
from omma.light import Light
from omma.picture.response_colours import receptors_shown
from omma.picture.unseen import hatch

DOCS = Path(__file__).resolve().parent
SUMMER_TIME = timezone(timedelta(hours=2))
TIMES = {"morning": (7, 0), "noon": (13, 0), "dusk": (21, 15)}
LATITUDE_DEG, LONGITUDE_DEG = 48.0, 15.0
PLACE = "21 June, 48° N 15° E"

# Panoramas: two pixels a degree, from here to the zenith.
LOWEST_DEG, PER_DEG = -60, 2
WIDTH, HEIGHT = 360 * PER_DEG, (90 - LOWEST_DEG) * PER_DEG
EXTENT = (-180.0, 180.0, float(LOWEST_DEG), 90.0)
RAYS, BEE_RAYS = 32, 256
DECADES = 4  # of the scales of receptors
DPI = 102
OUTSIDE = 0.88  # grey, hatched, where no ommatidium looks


@cache
def lit(name: str) -> omma.World:
    """The meadow at a time of day."""
    light = omma.light.clear_sky_at(moment(name), LATITUDE_DEG, LONGITUDE_DEG)
    return omma.World(
        omma.load_scene(omma.examples.lit_meadow()),
        light=light,
        polarized=True,
    )


def light_of(world: omma.World) -> Light:
    assert world.light is not None
    return world.light


def sun_of(name: str) -> omma.light.SunPosition:
    return omma.light.sun_position(moment(name), LATITUDE_DEG, LONGITUDE_DEG)


def moment(name: str) -> datetime:
    return datetime(2026, 6, 21, *TIMES[name], tzinfo=SUMMER_TIME)


def title(name: str) -> str:
    hour, minute = TIMES[name]
    elevation = sun_of(name).elevation_deg
    height = f"{abs(elevation):.0f}° {'above' if elevation > 0 else 'below'} the horizon"
    return f"{name.capitalize()}, {hour}:{minute:02}: the sun is {height}"


def panorama_eye() -> omma.Eye:
    """An ommatidium for each pixel of a panorama, row by row from the top left."""
    azimuth = np.radians((np.arange(WIDTH) + 0.5) / PER_DEG - 180)
    elevation = np.radians(90 - (np.arange(HEIGHT) + 0.5) / PER_DEG)
    azimuth, elevation = np.meshgrid(azimuth, elevation)
    across = np.cos(elevation)
    axis = np.stack(
        [np.sin(azimuth) * across, np.sin(elevation), -np.cos(azimuth) * across], axis=-1
    ).reshape(-1, 3)
    return omma.Eye(np.zeros_like(axis), axis, acceptance_angle_rad=np.radians(1 / PER_DEG))


def bee_pixels(eye: omma.Eye) -> NDArray[np.int32]:
    """Which of both eyes' ommatidia each pixel of a panorama shows, -1 outside of their fields."""
    size = WIDTH, 180 * PER_DEG
    ids = omma.picture.equirectangular_ids(eye, *size).copy()
    seen = np.zeros(ids.shape, bool)
    for one in np.unique(eye.eye_id):
        seen |= omma.picture.field_ids(eye.take(np.flatnonzero(eye.eye_id == one)), *size) >= 0
    ids[~seen] = -1
    return ids[:HEIGHT]


def through_the_bee(name: str) -> None:
    """What is there, and the same through both eyes: in false colours, and by receptor."""
    world = lit(name)
    light = light_of(world)
    sharp = omma.Renderer(world, panorama_eye(), omma.Fixed(RAYS)).render("bee")[0]
    people = exposed(omma.picture.bands_to_rgb(sharp, light).reshape(HEIGHT, WIDTH, 3))

    eye = omma.species.honeybee_worker().eye
    answers = omma.Renderer(world, eye, omma.Fixed(BEE_RAYS)).render_receptors("bee")[0]
    kinds = ["green", "blue", "ultraviolet"]
    values = receptors_shown(eye, answers, kinds, "answers").values[0]
    ids = bee_pixels(eye)
    white = dict(zip([each.name for each in eye.receptor_types], white_ground(light, eye)))
    adapted = values / [white[kind] for kind in kinds]
    bee = exposed(adapted[ids].astype(np.float32))
    hatch(bee, ids < 0)

    figure = Figure(figsize=(9.2, 4.75), layout="constrained")
    figure.suptitle(f"{title(name)} ({PLACE})", fontsize="large", weight="bold")
    grid = figure.add_gridspec(2, 6, height_ratios=[3.0, 2.0])
    for k, (picture, words) in enumerate(
        [(people, "as people see it"), (bee, "through a honeybee's eyes, in false colours")]
    ):
        panel = figure.add_subplot(grid[0, 3 * k : 3 * k + 3])
        panel.imshow(picture, extent=EXTENT, interpolation="nearest")
        degrees(panel, words, k == 0)
    # One scale for all three: as much above the brightest but a few as takes these in.
    high = float(np.quantile(values, 0.98))
    power = 10.0 ** np.ceil(np.log10(high))
    top = power * min(step for step in (0.2, 0.5, 1.0) if power * step >= high)
    for k, kind in enumerate(reversed(kinds)):
        panel = figure.add_subplot(grid[1, 2 * k : 2 * k + 2])
        shown = np.where(ids < 0, np.nan, values[:, kinds.index(kind)][ids])
        panel.set_facecolor(str(OUTSIDE))
        panel.patch.set(hatch="//////", edgecolor="0.65", linewidth=0)
        marks = panel.imshow(
            shown, extent=EXTENT, interpolation="nearest", cmap="magma",
            norm=LogNorm(top / 10**DECADES, top),
        )  # fmt: skip
        peak = next(t.peak_wavelength_nm for t in eye.receptor_types if t.name == kind)
        degrees(panel, f"its {kind} receptors ({peak:.0f} nm)", k == 0)
        panels = [*figure.axes[2 : 3 + k]]
    bar = figure.colorbar(marks, ax=panels, location="bottom", shrink=0.5, aspect=45, pad=0.03)
    bar.set_label("light that receptors see, photons m$^{-2}$ s$^{-1}$ sr$^{-1}$ nm$^{-1}$")
    bar.outline.set_visible(False)
    save_figure(figure, [str(DOCS / f"lit-{name}.png")], dpi=DPI)


def exposed(colours: NDArray[Any]) -> NDArray[np.uint8]:
    """For the screen: hues as they are, the sky bright but not burnt out, and contrast lowered as
    far as it takes to see what is on the ground."""
    bright = np.maximum(colours.mean(axis=-1, keepdims=True), 1e-9)
    horizon = 90 * PER_DEG
    sky, ground = np.median(bright[: horizon // 2]), np.median(bright[horizon:])
    power = min(1.0, np.log(0.1) / np.log(min(ground / sky, 0.1)))
    film = 1 - np.exp(-1.2 * (bright / sky) ** power)
    return omma.picture.display(np.clip(colours * (film / bright), 0, 1).astype(np.float32))


def degrees(panel: Any, words: str, first: bool) -> None:
    panel.set_title(words, loc="left")
    panel.set_xticks(range(-180, 181, 90), ["behind", "left", "ahead", "right", "behind"])
    panel.set_yticks((-60, -30, 0, 30, 60, 90))
    panel.set_yticklabels([f"{t}°".replace("-", "−") for t in (-60, -30, 0, 30, 60, 90)])
    panel.tick_params(length=2, labelsize="small")
    if not first:
        panel.set_yticklabels([])
    for label, side in zip(panel.get_xticklabels(), ("left", *["center"] * 3, "right")):
        label.set_horizontalalignment(side)
    panel.spines[:].set_visible(False)


# Where the ant is: between blades, as high as the camera "bee-low".
ANT_M = (-1.0, 0.126, 4.3)
ULTRAVIOLET_BAND = 2  # 350 to 375 nm
DOME_PIXELS, RIM_RAYS = 181, 64
FULL_SIGNAL = 0.6
LEAST_POLARISED = 0.03  # below, bars have no direction
SIGNAL_COLOURS = colormaps["RdBu_r"]
HEADINGS_DEG = np.arange(0, 361, 10)


def ant_pose(heading_deg: float) -> NDArray[np.float64]:
    """Level, at a heading from north to the east."""
    x, z = np.sin(np.radians(heading_deg)), -np.cos(np.radians(heading_deg))
    return omma.look_at(ANT_M, (ANT_M[0] + x, ANT_M[1], ANT_M[2] + z))


def rim_eye() -> tuple[omma.Eye, NDArray[np.int64]]:
    """The ommatidia of both dorsal rims, and the two ultraviolet receptors of each, (N, 2): along
    and across its up vector."""
    eye = omma.species.cataglyphis().eye
    rim = eye.take(np.flatnonzero(np.array(eye.columns["region"]) == "dorsal rim"))
    behind = omma.receptors.ommatidium_of_receptor(rim)
    names = [rim.receptor_types[which].name for which in rim.receptor_type]
    pairs = np.empty((len(rim), 2), np.int64)
    for receptor, (name, ommatidium) in enumerate(zip(names, behind)):
        for k, ending in enumerate(("along", "across")):
            if name.endswith(ending):
                pairs[ommatidium, k] = receptor
    return rim, pairs


def opponent(answers: NDArray[Any], pairs: NDArray[np.int64]) -> NDArray[np.float64]:
    """(along - across) / (along + across) of each ommatidium, (..., N)."""
    along, across = (answers[..., pairs[:, k]].astype(float) for k in range(2))
    return np.asarray((along - across) / (along + across))


def dome() -> tuple[omma.Eye, NDArray[np.bool_]]:
    """An ommatidium for each pixel of a map of the sky, zenith in the middle, its up vector towards
    the zenith; and which pixels of the square these are."""
    span = np.linspace(-1, 1, DOME_PIXELS)
    x, y = np.meshgrid(span, span[::-1])
    inside = np.hypot(x, y) <= 1
    axis = direction(np.degrees(np.arctan2(x, y)), 90 * (1 - np.hypot(x, y)))[inside]
    return omma.Eye(np.zeros_like(axis), axis, acceptance_angle_rad=np.radians(1)), inside


def on_map(axis: NDArray[Any]) -> NDArray[np.float64]:
    """Directions (N, 3) on a map of the sky, zenith in the middle, ahead up, right at the right."""
    azimuth, elevation = azimuth_elevation_deg_of(axis)
    r = 1 - elevation / 90
    return np.stack([r * np.sin(np.radians(azimuth)), r * np.cos(np.radians(azimuth))], axis=-1)


def through_the_rim() -> None:
    """The polarised sky above an ant at three times, what its dorsal rims make of it, and what
    three groups of a rim's ommatidia say while it turns."""
    rim, pairs = rim_eye()
    sky_eye, inside = dome()
    places = on_map(rim.axis)
    # The way microvilli "along" lie on the map.
    ends = on_map(rim.axis + 0.02 * rim.up) - places
    ends *= 0.035 / np.linalg.norm(ends, axis=1, keepdims=True)
    right = rim.axis[:, 0] > 0
    usual = np.array([0.0, 1, 0]) - rim.axis * rim.axis[:, 1:2]
    turn = np.degrees(
        np.arctan2(
            (rim.up * np.cross(rim.axis, usual)).sum(axis=1), (rim.up * usual).sum(axis=1)
        )
    ) % 180  # fmt: skip
    group = (turn // 60).astype(int)

    figure = Figure(figsize=(7.2, 5.3))
    grid = {"left": 0.1, "right": 0.88, "bottom": 0.085, "top": 0.915, "hspace": 0.08,
            "wspace": 0.12, "height_ratios": [1.0, 0.55, 0.75]}  # fmt: skip
    panels = figure.subplots(3, 3, gridspec_kw=grid)
    for name, (sky, rims, curves) in zip(TIMES, panels.T):
        world = lit(name)
        stokes = omma.Renderer(world, sky_eye, omma.Fixed(16)).render_stokes(ant_pose(0))
        polarised = draw_sky(sky, light_of(world), sky_eye, inside, stokes[0])
        for side in (right, ~right):
            hull = places[side][ConvexHull(places[side]).vertices]
            sky.fill(*hull.T, fill=False, edgecolor="white", linewidth=1.2)
        answers = omma.Renderer(world, rim, omma.Fixed(RIM_RAYS)).render_receptors(
            [ant_pose(heading) for heading in HEADINGS_DEG]
        )
        signal = opponent(answers, pairs)
        for at, along, value in zip(places, ends, signal[0]):
            rims.plot(
                *np.stack([at - along, at + along], axis=1), lw=2.2, solid_capstyle="round",
                color=SIGNAL_COLOURS(0.5 + 0.5 * value / FULL_SIGNAL),
            )  # fmt: skip
        for k, colour in enumerate(COLOURS[:3]):
            mine = right & (group == k)
            curves.plot(
                HEADINGS_DEG, signal[:, mine].mean(axis=1), color=colour,
                label=f"{60 * k}° to {60 * k + 60}°",
            )  # fmt: skip
        azimuth = sun_of(name).azimuth_deg
        curves.axvline(azimuth, color=GREY, lw=0.8, ls=":")
        curves.annotate("sun", (azimuth, 0.97), (2, 0), xycoords=("data", "axes fraction"),
                        textcoords="offset points", color=GREY, va="top")  # fmt: skip
        sky.set_title(title(name).replace(": the sun is ", "\nsun "), pad=2)
        frame(sky, azimuth, max(sun_of(name).elevation_deg, 0.0))
        rims.set(xlim=(-0.6, 0.6), ylim=(0.02, 0.62), aspect="equal", xticks=[], yticks=[])
        rims.spines[:].set_visible(False)
        curves.set(
            xlim=(0, 360), xticks=range(0, 361, 90), ylim=(-FULL_SIGNAL, FULL_SIGNAL),
            xlabel="heading (0°: north, 90°: east)",
        )  # fmt: skip
        curves.axhline(0, color=GREY, lw=0.5)
    panels[0, 0].set_ylabel("sky above the ant\n")
    panels[1, 0].set_ylabel("signals of its\ndorsal rims")
    panels[2, 0].set_ylabel("mean signals of the\nright rim as it turns")
    panels[2, 1].legend(
        title="microvilli, from up to the right", frameon=False, fontsize="x-small",
        title_fontsize="x-small", loc="lower center", ncols=3, columnspacing=0.8,
        handlelength=0.8, handletextpad=0.4,
    )  # fmt: skip
    for panel in panels[2, 1:]:
        panel.set_yticklabels([])
    for words, x in (("left", -0.3), ("right", 0.3)):
        panels[1, 0].text(x, 0.57, words, ha="center", fontsize="small", color=GREY)
    for row, marks, label in (
        (0, polarised, "degree of polarisation,\n350 to 375 nm"),
        (1, ScalarMappable(Normalize(-FULL_SIGNAL, FULL_SIGNAL), SIGNAL_COLOURS),
         "(along − across) /\n(along + across)"),
    ):  # fmt: skip
        box = panels[row, 2].get_position()
        place = figure.add_axes((0.895, box.y0 + 0.1 * box.height, 0.012, 0.8 * box.height))
        bar = figure.colorbar(marks, cax=place)
        bar.set_label(label)
        bar.outline.set_visible(False)
    save_figure(figure, [str(DOCS / "lit-rim.png")], dpi=143)


def draw_sky(
    panel: Any, light: Light, eye: omma.Eye, inside: NDArray[np.bool_], stokes: NDArray[Any]
) -> Any:
    """Degree of polarisation where there is sky, with bars along the electric vector; leaves."""
    i, q, u = stokes[:, :, ULTRAVIOLET_BAND].astype(float).T
    bare = light.radiance(eye.axis)[:, 0, ULTRAVIOLET_BAND]
    is_sky = np.abs(i / bare - 1) < 0.1
    degree, psi = np.full((2, *inside.shape), np.nan)
    degree[inside] = np.where(is_sky, np.hypot(q, u) / i, np.nan)
    psi[inside] = np.arctan2(u, q) / 2
    leaves = np.zeros((*inside.shape, 4))
    leaves[inside] = (0.35, 0.42, 0.3, 1)
    place: dict[str, Any] = {"extent": (-1, 1, -1, 1), "interpolation": "nearest"}
    panel.imshow(leaves, **place)
    marks = panel.imshow(degree, cmap="magma", vmin=0, vmax=0.8, **place)
    for r, count in ((0.15, 5), (0.37, 12), (0.6, 19), (0.8, 26)):
        for azimuth in 2 * np.pi * np.arange(count) / count:
            x, y = r * np.sin(azimuth), r * np.cos(azimuth)
            pixel = tuple(round((c + 1) / 2 * (DOME_PIXELS - 1)) for c in (-y, x))
            if not degree[pixel] > LEAST_POLARISED:
                continue
            # Who looks to the rim of the map has up behind and the right at the right.
            inwards, sideways = np.array([-x, -y]) / r, np.array([y, -x]) / r
            half = 0.055 * (np.cos(psi[pixel]) * inwards + np.sin(psi[pixel]) * sideways)
            panel.plot([x - half[0], x + half[0]], [y - half[1], y + half[1]], color="w", lw=0.7)
    return marks


def frame(panel: Any, sun_azimuth_deg: float, sun_elevation_deg: float) -> None:
    """Rings at 30° and 60°, the horizon, where north and the sun are."""
    turn = np.linspace(0, 2 * np.pi, 181)
    for elevation in (0, 30, 60):
        r = 1 - elevation / 90
        panel.plot(r * np.sin(turn), r * np.cos(turn), color=GREY, linewidth=0.4)
    for word, x, y in (("N", 0, 1.1), ("E", 1.1, 0), ("S", 0, -1.1), ("W", -1.1, 0)):
        panel.text(x, y, word, ha="center", va="center", fontsize="small", color=GREY)
    at = on_map(direction(sun_azimuth_deg, sun_elevation_deg)[None])[0]
    panel.plot(*at, "o", color="#ffd23f", markersize=6, markeredgecolor=INK, markeredgewidth=0.6)
    panel.set(xlim=(-1.17, 1.17), ylim=(-1.17, 1.17), aspect="equal", xticks=[], yticks=[])
    panel.spines[:].set_visible(False)


def main() -> None:
    asked = sys.argv[1:] or [*TIMES, "rim"]
    with figure_style(8.0):
        for name in asked:
            if name == "rim":
                through_the_rim()
            elif name in TIMES:
                through_the_bee(name)
            else:
                raise SystemExit(f"expected {', '.join(TIMES)} or rim, found {name}")


if __name__ == "__main__":
    main()
