"""Makes the figures of docs/motion-detection.md.

.venv/bin/python docs/make_motion_figures.py [folder]

motion-tuning.png: detectors run on signals (dots) and the closed form (lines), over temporal
frequency, velocity, wavelength and contrast. motion-example.png: examples/python/
looming_and_target.py, a minute on two cores.
"""

import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np

import omma

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parents[1]
STEP_DEG, WIDTH_DEG = 5.0, 5.0  # a fruit fly's Δφ and Δρ, roughly
TAU_S, HIGH_PASS_TAU_S = 0.035, 0.25
FRAMES = 64  # a period
COLOURS = ("#0072b2", "#009e73", "#d55e00", "#cc79a7")


def measured(wavelength_deg, frequency_hz, contrast=1.0, high_pass_tau_s=None, width_deg=WIDTH_DEG):
    """The mean output of a detector, run frame by frame until it is steady."""
    eye = omma.Eye(np.zeros((2, 3)), omma.eye.direction([0, STEP_DEG], 0), np.radians(width_deg))
    rate = FRAMES * frequency_hz
    detectors = omma.motion.detector_array(
        eye, TAU_S, rate, pairs=[[0, 1]], high_pass_tau_s=high_pass_tau_s
    )
    settling = int(np.ceil(16 * max(TAU_S, high_pass_tau_s or 0) * frequency_hz)) * FRAMES
    turn = 2 * np.pi * np.arange(settling + FRAMES) / FRAMES
    transfer = np.exp(-(np.pi**2) / (4 * np.log(2)) * (width_deg / wavelength_deg) ** 2)
    phase = 2 * np.pi * np.array([0, STEP_DEG]) / wavelength_deg
    light = 1 + contrast * transfer * np.cos(turn[:, None] - phase)
    return detectors.run(light)[-FRAMES:].mean()


def closed_form(wavelength_deg, frequency_hz, contrast=1.0, high_pass_tau_s=None,
                width_deg=WIDTH_DEG):  # fmt: skip
    return omma.motion.grating_response(
        contrast, np.radians(wavelength_deg), frequency_hz, np.radians(STEP_DEG), TAU_S,
        high_pass_tau_s=high_pass_tau_s, acceptance_angle_rad=np.radians(width_deg),
    )  # fmt: skip


def over_frequency_and_velocity(by_frequency, by_velocity):
    frequencies = np.geomspace(0.1, 100, 200)
    dots = np.geomspace(0.1, 100, 10)
    for wavelength, colour in zip((15, 30, 60, 90), COLOURS):
        for panel, unit in ((by_frequency, 1), (by_velocity, wavelength)):
            panel.plot(unit * frequencies, closed_form(wavelength, frequencies), color=colour,
                       label=f"{wavelength}°")  # fmt: skip
            found = [measured(wavelength, f) for f in dots]
            panel.plot(unit * dots, found, "o", ms=4, color=colour)
    high = closed_form(30, frequencies, high_pass_tau_s=HIGH_PASS_TAU_S)
    by_frequency.plot(frequencies, high, "--", color=COLOURS[1], lw=1.2, label="30°, high-pass")
    found = [measured(30, f, high_pass_tau_s=HIGH_PASS_TAU_S) for f in dots]
    by_frequency.plot(dots, found, "o", ms=4, color=COLOURS[1], mfc="white")
    best = omma.motion.best_frequency_hz(TAU_S)
    by_frequency.axvline(best, color="0.7", lw=1, zorder=0)
    by_frequency.text(1.06 * best, 0.01, f"1/(2πτ) = {best:.2f} Hz", fontsize=8, color="0.35")
    by_frequency.set(xscale="log", xlabel="temporal frequency, Hz", ylim=(0, None))
    by_frequency.set_title("One best temporal frequency for all wavelengths", fontsize=10)
    by_frequency.legend(title="wavelength", fontsize=8, title_fontsize=8, frameon=False)
    by_velocity.set(xscale="log", xlabel="velocity, ° per second", ylim=(0, None))
    by_velocity.set_title("... so that each has a best velocity of its own", fontsize=10)


def over_wavelength(panel):
    best = omma.motion.best_frequency_hz(TAU_S)
    wavelengths = np.linspace(4.2, 60, 800)
    dots = np.array([4.5, 5.5, 6, 6.67, 7.5, 8.5, 9.5, 11, 13, 16, 20, 25, 32, 40, 50, 58])
    for width, colour, label in ((0.0, COLOURS[2], "Δρ = 0"), (WIDTH_DEG, COLOURS[0], "Δρ = Δφ")):
        panel.plot(wavelengths, closed_form(wavelengths, best, width_deg=width), color=colour,
                   label=label)  # fmt: skip
        found = [measured(w, best, width_deg=width) for w in dots]
        panel.plot(dots, found, "o", ms=4, color=colour)
    panel.axhline(0, color="0.6", lw=0.8)
    panel.axvline(2 * STEP_DEG, color="0.7", lw=1, zorder=0)
    panel.text(2.15 * STEP_DEG, -0.42, "λ = 2Δφ: shorter ones\nseem to go the other way",
               fontsize=8, color="0.35")  # fmt: skip
    panel.set(xlabel=f"wavelength, ° (Δφ = {STEP_DEG:g}°)", xlim=(4, 60))
    panel.set_title("Over wavelength, at the best frequency", fontsize=10)
    panel.legend(fontsize=8, frameon=False)


def over_contrast(panel):
    best = omma.motion.best_frequency_hz(TAU_S)
    contrasts, dots = np.geomspace(0.01, 1, 50), np.geomspace(0.01, 1, 9)
    panel.plot(contrasts, closed_form(30, best, contrasts), color=COLOURS[0])
    panel.plot(dots, [measured(30, best, c) for c in dots], "o", ms=4, color=COLOURS[0])
    panel.set(xscale="log", yscale="log", xlabel="contrast")
    panel.text(0.05, 0.85, "slope 2", transform=panel.transAxes, fontsize=8, color="0.35")
    panel.set_title("Contrast squared (λ = 30°)", fontsize=10)


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs"
    figure, panels = plt.subplots(2, 2, figsize=(11, 7.6), layout="constrained")
    over_frequency_and_velocity(*panels[0])
    over_wavelength(panels[1, 0])
    over_contrast(panels[1, 1])
    for panel in panels.ravel():
        panel.set_ylabel("mean output / mean light²")
        panel.spines[["top", "right"]].set_visible(False)
    figure.suptitle(
        f"A detector of τ = {1e3 * TAU_S:g} ms: run frame by frame (dots), closed form (lines)",
        fontsize=11,
    )
    figure.savefig(folder / "motion-tuning.png", dpi=110)
    print("wrote motion-tuning.png")
    example = ROOT / "examples" / "python" / "looming_and_target.py"
    made = folder / "motion-example.png"
    subprocess.run([sys.executable, example, "-o", made], check=True)


if __name__ == "__main__":
    main()
