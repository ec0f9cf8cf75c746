"""Makes the figures of docs/scenes.md: docs/stimuli.png and docs/stimuli-time.png.

.venv/bin/python docs/make_stimuli_figures.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import omma
from omma import stimuli
from omma.base.directions import direction
from omma.base.figures import COLOURS, GREY, INK, figure_style, save_figure

HERE = Path(__file__).resolve().parent
# A panorama, one ray a pixel of 1.5°; and as ommatidia of 5° all over it would answer.
ROWS, COLUMNS = 120, 240
BLUR_DEG = 5.0

GRATING = stimuli.DrumGrating(30, 2.0)
SHOWN = {
    "DrumGrating(20, 1.0)": stimuli.DrumGrating(20, 1.0),
    'SphereGrating(30, 1.0, "square",\ndirection_deg=60)': stimuli.SphereGrating(
        30, 1.0, "square", direction_deg=60
    ),
    "PlaneGrating(0.8, 1.0, size_m=(4, 3))": stimuli.PlaneGrating(
        0.8, 1.0, size_m=(4, 3), background=0.25
    ),
    "PlaneGrating(1.0, 1.0, center_m=(0, -1, 0),\ndirection_deg=90)": stimuli.PlaneGrating(
        1.0, 1.0, center_m=(0, -1, 0), direction_deg=90, background=0.8
    ),
    "optomotor_drum(12, 60.0)": stimuli.optomotor_drum(12, 60.0),
    "Bar(15, 100, 60.0, direction_deg=30)": stimuli.Bar(15, 100, 60.0, direction_deg=30),
    "edge(60.0)": stimuli.edge(60.0),
    "LoomingDisc(0.1, 0.6, azimuth_deg=40)": stimuli.LoomingDisc(0.1, 0.6, azimuth_deg=40),
    "Target(6, [0, 1], [-60, 60], [0, 20])": stimuli.Target(6, [0, 1], [-60, 60], [0, 20]),
    "RandomDots(400, 6.0)": stimuli.RandomDots(400, 6.0),
    "Starfield(400, 0.05)": stimuli.Starfield(400, 0.05),
    "NoisePanorama()": stimuli.NoisePanorama(),
    "LedArena(DrumGrating(30, 2.0), 0.5)": stimuli.LedArena(GRATING, 0.5),
    "LedArena(RandomDots(100, 12.0), 0.5, bits=1)": stimuli.LedArena(
        stimuli.RandomDots(100, 12.0), 0.5, 1
    ),
}


def eye_of(axes: np.ndarray, acceptance_deg: float) -> omma.Eye:
    """Ommatidia at the origin that look along axes (N, 3)."""
    return omma.Eye(np.zeros_like(axes), axes, np.radians(acceptance_deg))


def panoramas() -> None:
    """Each stimulus half a second after its start, all around."""
    azimuth = ((np.arange(COLUMNS) + 0.5) / COLUMNS - 0.5) * 360
    elevation = (0.5 - (np.arange(ROWS) + 0.5) / ROWS) * 180
    axes = direction(*np.meshgrid(azimuth, elevation)).reshape(-1, 3)
    figure = Figure(figsize=(9.6, 9.6), layout="constrained")
    panels = figure.subplots(len(SHOWN) // 2, 4)
    for number, (title, stimulus) in enumerate(SHOWN.items()):
        row, side = divmod(number, 2)
        world = stimulus.world()
        for column, (width_deg, rays) in enumerate(((0.0, 1), (BLUR_DEG, 64))):
            renderer = omma.Renderer(world, eye_of(axes, width_deg), omma.Fixed(rays))
            seen = stimulus.play(renderer, [0.5])[0, :, 1].reshape(ROWS, COLUMNS)
            panel = panels[row, 2 * side + column]
            panel.imshow(
                seen, cmap="gray", vmin=0, vmax=1, extent=(-180, 180, -90, 90),
                interpolation="nearest",
            )  # fmt: skip
            panel.set_xticks([-180, -90, 0, 90, 180])
            panel.set_yticks([-90, 0, 90])
            for spine in panel.spines.values():
                spine.set_visible(True)
            if column:
                panel.set_title(f"ommatidia of {BLUR_DEG:g}°", color=GREY, fontsize=7)
                panel.set_yticklabels([])
            else:
                panel.set_title(title, fontsize=7, loc="left")
                panel.set_ylabel("elevation, °")
            if row == len(SHOWN) // 2 - 1:
                panel.set_xlabel("azimuth, °")
            else:
                panel.set_xticklabels([])
    save_figure(figure, [str(HERE / "stimuli.png")], dpi=130)


def over_time() -> None:
    """What ommatidia answer, from formulas (lines) and rendered (dots)."""
    figure = Figure(figsize=(9.0, 5.4), layout="constrained")
    panels = figure.subplots(2, 2).ravel()

    times = np.linspace(0, 1, 201)
    grating = stimuli.DrumGrating(20, 2.0, contrast=0.9)
    for colour, width in zip(COLOURS, (2.0, 8.0, 16.0)):
        compare(panels[0], grating, times, direction([0.0], [0.0]), width, f"Δρ {width:g}°", colour)
    panels[0].set_title("DrumGrating(20, 2.0, contrast=0.9), ahead")

    disc = stimuli.LoomingDisc(l_over_v_s=0.05, collision_s=1.0)
    for colour, away in zip(COLOURS, (0.0, 10.0, 30.0)):
        axis = direction([away], [0.0])
        compare(panels[1], disc, times, axis, 5.0, f"{away:g}° off its centre", colour)
    panels[1].set_title("LoomingDisc(0.05, 1.0), Δρ 5°")

    fly = stimuli.Target(2, [0, 1], [-30, 30], [0, 0], background=0.8)
    for colour, elevation in zip(COLOURS, (0.0, 2.0, 4.0)):
        axis = direction([0.0], [elevation])
        compare(panels[2], fly, times, axis, 5.0, f"{elevation:g}° above its path", colour)
    panels[2].set_title("Target(2, [0, 1], [-30, 30], [0, 0]), Δρ 5°")

    arena = stimuli.LedArena(GRATING, 0.5, bits=2, refresh_hz=24)
    axis, fine = direction([0.0], [0.0]), np.linspace(0, 1, 961)
    compare(panels[3], arena, fine, axis, 5.0, "2 bits, 24 Hz", COLOURS[0])
    panels[3].plot(
        fine, GRATING.expected(axis, np.radians(5.0), fine), color=GREY, lw=0.8, label="the grating"
    )
    panels[3].set_title("LedArena(DrumGrating(30, 2.0), 0.5, bits=2, refresh_hz=24)")

    for panel in panels:
        panel.set_xlabel("time, s")
        panel.set_ylabel("response")
        panel.legend(frameon=False, loc="best")
        panel.margins(y=0.15)
    panels[0].plot([], [], ".", color=INK, ms=3)
    figure.suptitle("lines: expected   dots: rendered, 1,024 rays", fontsize=8)
    save_figure(figure, [str(HERE / "stimuli-time.png")], dpi=150)


def compare(panel, stimulus, times, axis, width_deg, label, colour) -> None:
    """A line of what is expected and dots of what is rendered."""
    expected = stimulus.expected(axis, np.radians(width_deg), times)[:, 0]
    panel.plot(times, expected, color=colour, label=label)
    renderer = omma.Renderer(stimulus.world(), eye_of(axis, width_deg), omma.Fixed(1024))
    some = times[:: max(len(times) // 40, 1)]
    panel.plot(some, stimulus.play(renderer, some)[:, 0, 1], ".", color=colour, ms=4)


def main() -> None:
    with figure_style():
        panoramas()
        over_time()


if __name__ == "__main__":
    main()
