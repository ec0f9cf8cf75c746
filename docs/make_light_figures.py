"""Draws the figures of docs/light.md: how Stokes vectors are meant, a sky, skies with clouds, and
dark ones.

python docs/make_light_figures.py            (into docs/)
"""

from datetime import datetime, timezone
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import omma
from omma.base.directions import direction, normalized
from omma.base.figures import COLOURS, GREY, INK, figure_style, save_figure

DOCS = Path(__file__).resolve().parent
BLUE, RED, GREEN = COLOURS[0], COLOURS[1], COLOURS[2]


def main():
    with figure_style(8.0):
        save_figure(frames_figure(), [str(DOCS / "light-frames.svg")])
    bands = omma.light.Bands.from_edges([300, *range(305, 700, 10), 700])  # as omma light show
    light = omma.light.clear_sky(30, sun_azimuth_deg=135, bands=bands)
    omma.picture.plot_sky(DOCS / "light-sky.png", light)
    with figure_style(8.0):
        save_figure(clouds_figure(), [str(DOCS / "sky-clouds.png")])
        save_figure(nights_figure(), [str(DOCS / "sky-nights.png")])


def clouds_figure():
    """Skies with clouds, lying on the back with the head to the sun."""
    clear = omma.light.clear_sky(35)
    figure = Figure(figsize=(7.2, 3.5), layout="constrained")
    panels = figure.subplots(2, 4)
    side = np.linspace(-1, 1, 321)
    x, y = np.meshgrid(side, -side)
    out = np.hypot(x, y)
    towards = direction(np.degrees(np.arctan2(x, y)), np.maximum(90 * (1 - out), 0))
    white = clear.irradiance()[0] + clear.irradiance()[1]
    for (kind, fraction, seed), (colours, polarised) in zip(
        (("cumulus", 0.3, 1), ("cumulus", 0.7, 2), ("cirrus", 0.5, 3), ("deck", 0.8, 4)), panels.T
    ):
        stokes = omma.light.clouded(clear, fraction, kind, seed=seed).radiance(towards)
        # A white sheet on level ground, lit by the clear sky and its sun, is 0.8.
        share = 0.8 * np.pi * stokes[:, :, 0] / white
        rgb = np.stack([share[:, :, a:b].mean(axis=2) for a, b in ((11, 15), (8, 11), (5, 8))], -1)
        rgb = np.clip(rgb, 0, 1) ** (1 / 2.2)
        rgb[out > 1] = 1
        colours.imshow(rgb, interpolation="bilinear")
        colours.set_title(f"{kind}, {fraction:g} of the sky")
        degree = np.hypot(stokes[:, :, 1, 6], stokes[:, :, 2, 6]) / stokes[:, :, 0, 6]
        drawn = polarised.imshow(np.where(out > 1, np.nan, degree), vmin=0, vmax=0.6)
        for panel in (colours, polarised):
            panel.set_axis_off()
    figure.colorbar(
        drawn,
        ax=panels,
        shrink=0.5,
        anchor=(0, 0.05),
        label="degree of polarisation,\n450 to 475 nm",
    )
    return figure


def nights_figure():
    """Dark skies by time and place, as maps: north at the top, east at the right."""
    figure = Figure(figsize=(7.2, 2.5), layout="constrained")
    side = np.linspace(-1, 1, 321)
    x, y = np.meshgrid(side, -side)
    out = np.hypot(x, y)
    towards = direction(np.degrees(np.arctan2(x, y)), np.maximum(90 * (1 - out), 0))
    green = omma.light.Bands.from_edges([540, 560])
    for panel, (title, month, day, hour, latitude, longitude) in zip(
        figure.subplots(1, 3),
        (
            ("South Africa, 15 July, 22 h", 7, 15, 20, -24, 28),
            ("Berlin, 10 October, 22 h", 10, 10, 20, 52.5, 13.4),
            ("Canaries, 15 March, 20.30 h", 3, 15, 20.5, 28.8, -17.9),
        ),
    ):
        moment = datetime(2026, month, day, int(hour), int(60 * (hour % 1)), tzinfo=timezone.utc)
        light = omma.light.night_sky_at(moment, latitude, longitude, bands=green)
        seen = light.radiance(towards)[:, :, 0, 0] / 1e9
        drawn = panel.imshow(
            np.where(out > 1, np.nan, seen), vmin=5, vmax=25, cmap="inferno",
            interpolation="bilinear",
        )  # fmt: skip
        panel.set_title(title, pad=10)
        panel.set_axis_off()
        for name, at in (("N", (160, -8)), ("E", (330, 160)), ("S", (160, 330)), ("W", (-8, 160))):
            panel.text(*at, name, ha="center", va="center", color=GREY, fontsize="small")
    figure.colorbar(
        drawn,
        ax=figure.axes,
        shrink=0.8,
        extend="max",
        ticks=[5, 10, 15, 20, 25],
        label="radiance, 550 nm\n(10⁹ photons m⁻² s⁻¹ sr⁻¹ nm⁻¹)",
    )
    return figure


def frames_figure():
    figure = Figure(figsize=(7.2, 2.6), layout="constrained")
    dome, looking, eye = figure.subplots(1, 3, width_ratios=[1.15, 0.85, 1.1])
    draw_dome(dome)
    draw_looking(looking)
    draw_ommatidium(eye)
    return figure


def draw_dome(panel):
    """Light from afar: the reference axis of a direction of the sky points up."""
    view = camera(azimuth_deg=-18, elevation_deg=20)
    turn = np.radians(np.arange(0, 361, 3))
    around = np.stack([np.sin(turn), 0 * turn, -np.cos(turn)], -1)
    line(panel, view, around, GREY, 0.8)
    for azimuth, name in ((0, "−Z, north"), (90, "+X, east"), (180, ""), (270, "")):
        rim = direction(azimuth, 0)
        line(panel, view, np.array([0 * rim, rim]), GREY, 0.5, ":")
        if name:
            aside = np.array([0, 0, 0]) if azimuth else np.array([-0.42, 0, 0.02])
            text(panel, view, 1.35 * rim + aside, name, GREY)
    for azimuth in (0, 90):
        arc = direction(azimuth, np.arange(-0.0, 181, 3))
        line(panel, view, arc, GREY, 0.5)
    azimuth = 32
    d = direction(azimuth, 40)
    line(panel, view, direction(azimuth, np.arange(0, 91, 3)), BLUE, 0.7, "--")
    e1, e2 = axes_of(d)
    arrow(panel, view, 0 * d, d, INK, "d", (-0.12, -0.02))
    arrow(panel, view, d, d + 0.5 * e1, BLUE, "e₁, up", (0.27, 0.04))
    arrow(panel, view, d, d + 0.5 * e2, RED, "e₂ = d × e₁", (0.2, -0.11))
    text(panel, view, np.array([0, 1.1, 0]), "up, +Y", GREY)
    text(panel, view, np.array([0, -0.95, 0]), "d: from the eye towards the light", INK)
    ready(panel, "light from afar", (-1.15, 1.65))


def draw_looking(panel):
    """The same along d: angles of the electric vector turn from e1 to e2."""
    flat = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])
    turn = np.radians(np.arange(0, 361, 3))
    line(panel, flat, np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1), GREY, 0.6)
    zero = np.zeros(3)
    arrow(panel, flat, zero, np.array([0, 1.0, 0]), BLUE, "e₁", (0, 0.14))
    arrow(panel, flat, zero, np.array([1.0, 0, 0]), RED, "e₂", (0.16, 0))
    psi = np.radians(35)
    vector = np.array([np.sin(psi), np.cos(psi), 0])
    line(panel, flat, np.array([-0.85 * vector, 0.85 * vector]), INK, 2.0)
    text(panel, flat, np.array([-0.55, -1.14, 0]), "electric vector", INK)
    bend = np.radians(np.arange(0, 36))
    line(panel, flat, 0.5 * np.stack([np.sin(bend), np.cos(bend), 0 * bend], -1), INK, 0.8)
    text(panel, flat, np.array([0.20, 0.62, 0]), "ψ", INK)
    text(panel, flat, np.array([0, -1.55, 0]), "Q = p I cos 2ψ\nU = p I sin 2ψ", INK)
    ready(panel, "as one looks along d", (-1.35, 1.35))


def draw_ommatidium(panel):
    """A ray beside the axis: the ommatidium's up, carried along by the shortest turn."""
    view = camera(azimuth_deg=-35, elevation_deg=28)
    axis, up = np.array([0, 0, -1.0]), np.array([0, 1.0, 0])
    right = np.cross(axis, up)
    middle = np.zeros(3)
    arrow(panel, view, middle, 1.25 * axis, INK, "axis", (0.14, 0.08))
    arrow(panel, view, middle, 0.8 * up, BLUE, "up", (0, 0.1))
    arrow(panel, view, middle, 0.8 * right, RED, "right", (0.12, -0.1))
    phi = np.radians(40)
    microvilli = np.cos(phi) * up + np.sin(phi) * right
    for k in np.linspace(-0.16, 0.16, 4):
        across = np.cross(axis, microvilli)
        ends = np.array([-0.3 * microvilli, 0.3 * microvilli]) + k * across
        line(panel, view, ends, GREEN, 1.3)
    bend = np.radians(np.arange(0, 41, 2))[:, None]
    line(panel, view, 0.55 * (np.cos(bend) * up + np.sin(bend) * right), GREEN, 0.8)
    text(panel, view, 0.68 * (np.cos(phi / 2) * up + np.sin(phi / 2) * right), "φ", GREEN)
    text(panel, view, np.array([-0.62, -0.52, 0]), "microvilli", GREEN)
    ray = direction(52, 4)
    arrow(panel, view, middle, 1.25 * ray, INK, "ray", (-0.3, -0.14))
    carried = shortest_turn(axis, ray) @ up
    end = 1.25 * ray
    arrow(panel, view, end, end + 0.45 * carried, BLUE, "e₁", (0, 0.09))
    arrow(panel, view, end, end + 0.45 * np.cross(ray, carried), RED, "e₂", (0.10, -0.08))
    between = normalized(np.array([axis * (1 - t) + ray * t for t in np.linspace(0, 1, 20)]))
    line(panel, view, 0.9 * between, GREY, 0.8, ":")
    panel.text(
        0.45, -1.2, "a receptor sees\nI + m (Q cos 2φ + U sin 2φ)", ha="center", fontsize="small"
    )
    ready(panel, "a ray of an ommatidium", (-0.95, 1.85))


def axes_of(d):
    """e1, which points up, and e2 of light from afar in a direction d."""
    up = np.array([0, 1.0, 0])
    e1 = normalized(up - (up @ d) * d)
    return e1, np.cross(d, e1)


def shortest_turn(one, other):
    """The rotation (3, 3) that takes one direction to another by the shortest way."""
    v, c = np.cross(one, other), one @ other
    skew = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + skew + skew @ skew / (1 + c)


def camera(azimuth_deg, elevation_deg):
    """Rows right, up and towards the viewer, who looks from behind the one who sees, from above."""
    towards = -direction(azimuth_deg, -elevation_deg)
    right = normalized(np.cross([0, 1.0, 0], towards))
    return np.array([right, np.cross(towards, right), towards])


def line(panel, view, points, colour, width, style="-"):
    x, y, _ = view @ points.T
    panel.plot(x, y, style, color=colour, linewidth=width, solid_capstyle="round")


def arrow(panel, view, start, end, colour, name, aside):
    a, b = (view @ start)[:2], (view @ end)[:2]
    style = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
    panel.annotate("", b, a, arrowprops=style)
    panel.text(*(b + aside), name, color=colour, ha="center", va="center")


def text(panel, view, at, words, colour):
    panel.text(*(view @ at)[:2], words, color=colour, ha="center", va="center", fontsize="small")


def ready(panel, title, width):
    panel.set(xlim=width, ylim=(-1.75, 1.3), aspect="equal")
    panel.set_axis_off()
    panel.set_title(title)


if __name__ == "__main__":
    main()
