"""Makes the figures of docs/receptors.md.

.venv/bin/python docs/make_photoreceptor_figures.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import omma
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.figures import COLOURS, GREY, INK
from omma.photoreceptors import (
    EventSensor,
    ImpulseResponse,
    displace_axes,
    filter_frames,
    large_monopolar,
    logarithmic,
    microsaccades_rad,
    naka_rushton,
    photon_noise,
    published_response,
    van_hateren_snippe,
)

FOLDER = Path(__file__).resolve().parent
NAMES = {
    "blowfly": COLOURS[0],
    "bumblebee green": COLOURS[2],
    "bumblebee blue": COLOURS[5],
    "bumblebee ultraviolet": COLOURS[3],
}


def style(panel: Axes, title: str, x: str, y: str) -> None:
    panel.set_title(title, loc="left", fontsize=10, color=INK)
    panel.set_xlabel(x, fontsize=9)
    panel.set_ylabel(y, fontsize=9)
    panel.spines[["top", "right"]].set_visible(False)
    panel.tick_params(labelsize=8.5)


def legend(panel: Axes, **how: object) -> None:
    panel.legend(fontsize=8, frameon=False, **how)


def save(figure: Figure, name: str) -> None:
    figure.tight_layout()
    figure.savefig(FOLDER / f"photoreceptors-{name}.png", dpi=130)
    plt.close(figure)


def natural_light(count: int, rate_hz: float, mean: float) -> np.ndarray:
    """Light with a power spectrum of 1/f and log-normal values, as a fly meets in flight."""
    random = np.random.default_rng(4)
    spectrum = np.fft.rfft(random.standard_normal(count))
    frequency = np.fft.rfftfreq(count, 1 / rate_hz)
    spectrum[1:] /= np.sqrt(frequency[1:]) * (1 + (frequency[1:] / 100) ** 2)
    spectrum[0] = 0
    drive = np.fft.irfft(spectrum, count)
    light = np.exp(0.9 * drive / np.std(drive))
    return mean * light / np.mean(light)


def responses() -> None:
    """Impulse responses and what they leave of flicker."""
    figure, panels = plt.subplots(1, 3, figsize=(11, 3.3))
    time = np.linspace(0, 0.045, 900)
    frequency = np.geomspace(1, 200, 300)
    for name, color in NAMES.items():
        h = published_response(name)
        panels[0].plot(1e3 * time, 1e-3 * h.eval(time), color=color, lw=1.8, label=name)
        kept = h.transfer(frequency)
        panels[1].plot(frequency, np.abs(kept), color=color, lw=1.8)
        phase = np.degrees(np.unwrap(np.angle(kept)))
        panels[2].plot(
            frequency, np.where(np.abs(kept) > 0.003, phase, np.nan), color=color, lw=1.8
        )
    shutter = ImpulseResponse.box(0.010)
    panels[0].plot(
        1e3 * time, 1e-3 * shutter.eval(time), color=GREY, lw=1.2, label="shutter, 10 ms"
    )
    panels[1].plot(frequency, np.abs(shutter.transfer(frequency)), color=GREY, lw=1.2)
    style(panels[0], "Response to a flash", "time after the flash (ms)", "h (per ms)")
    legend(panels[0], loc="upper right")
    style(panels[1], "What is left of flicker", "frequency (Hz)", "|H|")
    style(panels[2], "How late it is", "frequency (Hz)", "phase of H (°)")
    panels[2].set_ylim(-720, 20)
    panels[2].set_yticks([0, -180, -360, -540, -720])
    for panel in panels[1:]:
        panel.set_xscale("log")
        panel.set_xticks([1, 10, 100], ["1", "10", "100"])
    save(figure, "responses")


def filters() -> None:
    """A target that crosses in 2 ms, and how well frames stand for time."""
    figure, panels = plt.subplots(1, 2, figsize=(9, 3.3))
    rate_hz = 5000.0
    time = np.arange(0, 0.06, 1 / rate_hz)
    crossing = np.where(np.abs(time - 0.006) < 0.001, 0.0, 1.0)
    panels[0].plot(1e3 * time, crossing, color=INK, lw=1.2, label="light")
    for name in ("blowfly", "bumblebee ultraviolet"):
        answer = filter_frames(crossing, rate_hz, published_response(name))
        panels[0].plot(1e3 * time, answer, color=NAMES[name], lw=1.8, label=name)
    style(panels[0], "A dark target passes in 2 ms", "time (ms)", "response")
    legend(panels[0], loc="lower right")
    frames = np.geomspace(3, 200, 60)
    h = published_response("bumblebee green")
    for frequency_hz, color in ((5.0, COLOURS[0]), (20.0, COLOURS[1]), (60.0, COLOURS[4])):
        error = [flicker_error(h, frequency_hz, float(n)) for n in frames]
        panels[1].loglog(frames, error, color=color, lw=1.8, label=f"{frequency_hz:g} Hz")
    panels[1].loglog(frames, np.pi**2 / 3 / frames**2, color=GREY, lw=1, ls="--", label="π²/3n²")
    style(panels[1], "Error of filtering frames", "frames n in a period", "error of |H|, relative")
    legend(panels[1])
    panels[1].set_xticks([3, 10, 30, 100], ["3", "10", "30", "100"])
    panels[1].minorticks_off()
    save(figure, "filters")


def flicker_error(h: ImpulseResponse, frequency_hz: float, frames: float) -> float:
    rate_hz = frequency_hz * frames
    count = int(np.ceil((0.15 + 2 / frequency_hz) * rate_hz))
    time = np.arange(count) / rate_hz
    answer = filter_frames(np.exp(2j * np.pi * frequency_hz * time).real, rate_hz, h)
    late = filter_frames(np.sin(2 * np.pi * frequency_hz * time), rate_hz, h)
    kept = np.hypot(answer[-1], late[-1])  # of a phasor that has settled
    exact = abs(h.transfer(frequency_hz))
    return float(abs(kept / exact - 1))


def noise() -> None:
    """The same scene at three light levels."""
    figure, panels = plt.subplots(1, 3, figsize=(11, 2.9), sharey=True)
    rate_hz, h = 1000.0, published_response("bumblebee green")
    time = np.arange(0, 1, 1 / rate_hz)
    light = 1 + 0.5 * np.sin(2 * np.pi * 4 * time)
    clean = filter_frames(light, rate_hz, h)
    for panel, photons in zip(panels, (1000.0, 30_000.0, 1_000_000.0)):
        drawn = photon_noise(light, 1, photons_per_s=photons, integration_time_s=1 / rate_hz)
        noisy = filter_frames(drawn, rate_hz, h)
        panel.plot(time, noisy, color=COLOURS[1], lw=1, label="with photon noise")
        panel.plot(time, clean, color=INK, lw=1, label="without")
        deviation = np.sqrt(1 / (photons * h.integration_time_s))
        title = f"{photons:,.0f} photons/s: ± {deviation:.2g}"
        style(panel, title, "time (s)", "response" if photons == 1000 else "")
    panels[0].set_ylim(-0.1, 2.7)
    legend(panels[1], loc="upper right")
    save(figure, "noise")


def static() -> None:
    figure, panel = plt.subplots(figsize=(5.2, 3.3))
    light = np.geomspace(1e-3, 1e4, 300)
    for exponent, color in ((0.6, COLOURS[5]), (1.0, COLOURS[0])):
        label = f"naka_rushton, n = {exponent:g}"
        panel.plot(light, naka_rushton(light, 1.0, exponent), color=color, lw=1.8, label=label)
    panel.plot(light, logarithmic(light, 1.0, 0.1), color=COLOURS[1], lw=1.8, label="logarithmic")
    panel.set_xscale("log")
    style(panel, "Static nonlinearities", "light / half, light / dark", "response")
    legend(panel)
    save(figure, "static")


def dynamic() -> None:
    """Steps, and a naturalistic time series."""
    figure, panels = plt.subplots(2, 2, figsize=(11, 5), sharex="col", height_ratios=[1, 1.5])
    rate_hz = 1000.0
    time = np.arange(0, 2.5, 1 / rate_hz)
    for k, contrast in enumerate((-0.8, -0.4, 0.4, 1.6, 6.4)):
        light = np.where((time >= 0.5) & (time < 1.5), 500 * (1 + contrast), 500.0)
        answer = van_hateren_snippe(light[:, None], rate_hz)[:, 0]
        color = COLOURS[k]
        panels[0, 0].plot(time, light, color=color, lw=1.4)
        panels[1, 0].plot(time, answer, color=color, lw=1.4, label=f"contrast {contrast:+g}")
    panels[0, 0].set_yscale("log")
    style(panels[0, 0], "Steps of light", "", "light (model's unit)")
    style(panels[1, 0], "The blowfly's potential", "time (s)", "potential (mV)")
    legend(panels[1, 0], loc="upper right", ncols=2)
    panels[1, 0].set_ylim(0, 62)
    time = np.arange(0, 5, 1 / rate_hz)
    light = natural_light(len(time), rate_hz, 600.0)
    answer = van_hateren_snippe(light[:, None], rate_hz, before=600.0)[:, 0]
    panels[0, 1].plot(time, light, color=INK, lw=0.8)
    panels[0, 1].set_yscale("log")
    panels[1, 1].plot(time, answer, color=COLOURS[0], lw=0.8, label="adapting")
    linear = filter_frames(light, rate_hz, published_response("blowfly"))
    # With the same mean and the same deviation, to be compared by eye.
    shown = (linear - linear.mean()) / linear.std() * answer.std() + answer.mean()
    panels[1, 1].plot(time, shown, color=GREY, lw=0.8, label="linear filter, scaled", zorder=0)
    style(panels[0, 1], "A naturalistic series, made up (1/f)", "", "light (model's unit)")
    style(panels[1, 1], "The blowfly's potential", "time (s)", "potential (mV)")
    legend(panels[1, 1], loc="upper left")
    save(figure, "adaptation")


def hexagons(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Places and neighbours of a hexagonal lattice, without an eye."""
    p, q = np.divmod(np.arange(size * size), size)
    columns = []
    for a, b in ((1, 1), (1, 0), (0, -1), (-1, -1), (-1, 0), (0, 1)):
        inside = (p + a >= 0) & (p + a < size) & (q + b >= 0) & (q + b < size)
        columns.append(np.where(inside, (p + a) * size + q + b, -1))
    place = np.stack([(p - q) * np.sqrt(3) / 2, (p + q) / 2], axis=1)
    return place, np.stack(columns, axis=1)


def monopolar() -> None:
    """Responses in time, gains in time and space, and an edge that passes."""
    figure, panels = plt.subplots(1, 3, figsize=(11, 3.3))
    place, neighbours = hexagons(15)
    rate_hz, middle = 2000.0, 7 * 15 + 7
    time = (np.arange(200) - 1) / rate_hz
    flash = np.zeros((200, len(place)))
    flash[1, middle] = rate_hz / 1000
    wide = np.zeros_like(flash)
    wide[1] = rate_hz / 1000
    for seen, color, label in (
        (flash, COLOURS[0], "one ommatidium sees the flash"),
        (wide, COLOURS[1], "all do"),
    ):
        answer = large_monopolar(seen, rate_hz, neighbours, 0.1)
        panels[0].plot(1e3 * time, answer[:, middle], color=color, lw=1.8, label=label)
        if seen is flash:
            beside = answer[:, neighbours[middle, 0]]
            panels[0].plot(1e3 * time, beside, color=GREY, lw=1.5, label="a neighbour of the one")
    panels[0].set_xlim(0, 50)
    panels[0].set_ylim(-0.09, 0.23)
    style(panels[0], "Response to a flash", "time after the flash (ms)", "per ms")
    legend(panels[0])
    excitation = ImpulseResponse.howard(10.3e-3, 0.236)
    inhibition = ImpulseResponse.howard(15.6e-3, 0.269)
    frequency = np.geomspace(0.5, 200, 200)
    for period, color in ((np.inf, COLOURS[1]), (6.0, COLOURS[4]), (2.0, COLOURS[0])):
        around = 0.4 + 0.6 * np.mean(
            np.cos(
                2 * np.pi / period * place[neighbours[middle]][:, 0]
                - 2 * np.pi / period * place[middle][0]
            )
        )
        gain = np.abs(excitation.transfer(frequency) - around * inhibition.transfer(frequency))
        label = "even field" if period == np.inf else f"bars, period {period:g} Δφ"
        panels[1].loglog(frequency, gain, color=color, lw=1.8, label=label)
    panels[1].set_ylim(0.01, 3)
    style(panels[1], "What is left of flicker", "frequency (Hz)", "gain")
    panels[1].set_xticks([1, 10, 100], ["1", "10", "100"])
    legend(panels[1], loc="lower center")
    edge = np.where(place[:, 0] < place[middle, 0], -0.4, 0.4)
    steady = np.tile(edge, (400, 1))
    answer = large_monopolar(steady, rate_hz, neighbours, 0.1)[-1]
    row = np.abs(place[:, 1] - place[middle, 1] + 0.25) < 0.3
    order = np.argsort(place[row, 0])
    x = (place[row, 0][order] - place[middle, 0]) / (np.sqrt(3) / 2)
    panels[2].plot(x, edge[row][order], "o-", color=GREY, lw=1.2, ms=4, label="contrast")
    panels[2].plot(x, answer[row][order], "o-", color=COLOURS[0], lw=1.8, ms=4, label="cells")
    style(panels[2], "An edge that stands still", "rows across the edge", "steady response")
    panels[2].set_xlim(-6.5, 6.5)
    legend(panels[2])
    save(figure, "monopolar")


def microsaccades() -> None:
    figure, panels = plt.subplots(1, 2, figsize=(9, 3.3), width_ratios=[1.4, 1])
    rate_hz = 1000.0
    time = np.arange(-0.1, 1.6, 1 / rate_hz)
    for flash, color in ((10.0, COLOURS[5]), (100.0, COLOURS[0]), (1000.0, COLOURS[3])):
        light = np.where((time >= 0) & (time < 0.7), flash, 0.0)
        angle = microsaccades_rad(light[:, None], rate_hz, dark=1.0)[:, 0]
        panels[0].plot(time, np.degrees(angle), color=color, lw=1.8, label=f"{flash:g} × dark")
    panels[0].axvspan(0, 0.7, color="0.93", lw=0)
    panels[0].text(0.35, -2.6, "light on", ha="center", fontsize=8.5, color="0.35")
    style(panels[0], "An axis that turns when light comes and goes", "time (s)", "angle (°)")
    legend(panels[0])
    eye = omma.eye.generate_eye(800)
    to_the_back = np.where(eye.axis[:, 0] > 0, 1, -1) * np.pi / 2  # right in a right eye
    turned = displace_axes(eye.axis, eye.up, np.full(len(eye), np.radians(4.0)), to_the_back)
    start, end = (np.stack(azimuth_elevation_deg_of(axis)) for axis in (eye.axis, turned))
    shown = np.all(np.abs(start) < [[62], [37]], axis=0)
    panels[1].quiver(
        *start[:, shown], *(end - start)[:, shown], angles="xy", scale_units="xy", scale=1,
        width=0.004, color=np.where(to_the_back[shown] > 0, COLOURS[1], COLOURS[0]),
    )  # fmt: skip
    panels[1].set_aspect("equal")
    style(panels[1], "Two eyes' axes, turned 4° to the back", "azimuth (°)", "elevation (°)")
    save(figure, "microsaccades")


def events() -> None:
    """What is told of a sine, how often of a ramp, and when a bar passes a row of ommatidia."""
    figure, panels = plt.subplots(1, 3, figsize=(11, 3.3))
    polarities = ((1, COLOURS[1], "ON"), (-1, COLOURS[0], "OFF"))
    time = np.arange(0, 1, 1e-3)
    signal = 0.8 * np.sin(2 * np.pi * 2 * time)
    told = EventSensor(0.25).run(np.exp(signal)[:, None], time)
    kept = 0.25 * np.cumsum(told["polarity"])
    panels[0].plot(time, signal, color=INK, lw=1.4, label="ln light")
    panels[0].step(np.r_[0, told["time_s"], 1], np.r_[0, kept, kept[-1]], where="post",
                   color=GREY, lw=1, label="at the last event")  # fmt: skip
    for polarity, color, label in polarities:
        own = told["polarity"] == polarity
        panels[0].plot(told["time_s"][own], kept[own], "o", ms=4, color=color, label=label)
    panels[0].set_ylim(-0.9, 1.6)
    style(panels[0], "A sine, thresholds of 0.25", "time (s)", "logarithm of light")
    legend(panels[0], loc="upper right", ncols=2)
    slopes = np.geomspace(0.5, 200, 100)
    for refractory_s, color in ((0.0, GREY), (0.002, COLOURS[0]), (0.02, COLOURS[1])):
        label = f"in reset for {1e3 * refractory_s:g} ms"
        panels[1].loglog(slopes, 1 / (0.25 / slopes + refractory_s), color=color, lw=1.4)
        sensor = EventSensor(0.25, refractory_s=refractory_s)
        dots = np.geomspace(0.5, 200, 9)
        rates = []
        for slope in dots:
            lasts = 40 * (0.25 / slope + refractory_s)
            ramp = np.exp(slope * np.linspace(0, lasts, 50) - slope * lasts / 2)
            told = sensor.run(ramp[:, None], np.linspace(0, lasts, 50))
            rates.append(1 / np.diff(told["time_s"]).mean())
        panels[1].plot(dots, rates, "o", ms=4, color=color, label=label)
    style(panels[1], "Ramps: dots on 1/(C/s + reset)", "slope of ln light (per s)", "events per s")
    legend(panels[1], loc="upper left")
    azimuth = np.arange(-40, 41, 2)
    eye = omma.Eye(np.zeros((len(azimuth), 3)), omma.eye.direction(azimuth, 0), np.radians(4.0))
    bar = omma.stimuli.Bar(15.0, bar=0.9, background=0.1)
    time = np.arange(-0.8, 0.8, 2e-3)
    poses = np.stack([omma.look_at((0, 0, 0), omma.eye.direction(60 * t, 0)) for t in time])
    light = omma.Renderer(bar.world(), eye, omma.Fixed(64)).render(poses)[:, :, 1]
    told = EventSensor(0.4, refractory_s=0.002).run(light, time)
    for polarity, color, label in polarities:
        own = told["polarity"] == polarity
        at = azimuth[told["ommatidium"][own]]
        panels[2].plot(told["time_s"][own], at, ".", ms=3, color=color, label=label)
    style(panels[2], "A head turns past a bright bar, 60°/s", "time (s)", "azimuth (°)")
    legend(panels[2], loc="upper right", markerscale=3)
    save(figure, "events")


if __name__ == "__main__":
    for make in (responses, filters, noise, static, dynamic, monopolar, events, microsaccades):
        make()
