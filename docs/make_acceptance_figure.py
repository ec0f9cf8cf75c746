"""Draws docs/acceptance.png: what lenses and rhabdoms accept, their transfer, and their widths.

python docs/make_acceptance_figure.py
"""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import omma

# A fly's facet and rhabdomere (Stavenga 2003, J Comp Physiol A 189:1): D 25 um, F-number 2.2.
FACET_M, FOCAL_M, WAVELENGTH_NM = 25e-6, 55e-6, 500.0
RHABDOM_M = 1.9e-6
COLOURS = {"Airy": "#999999", "waveguide": "#0072b2", "geometric": "#d55e00", "Snyder": "#009e73"}


def kinds(rhabdom_m: float) -> dict[str, omma.Acceptance]:
    """The same lens and rhabdom, by each model."""

    def with_model(model: str) -> omma.Acceptance:
        return omma.Acceptance.lens_rhabdom(FACET_M, FOCAL_M, rhabdom_m, WAVELENGTH_NM, model=model)

    return {
        "Airy": omma.Acceptance.airy(FACET_M, WAVELENGTH_NM),
        "waveguide": with_model("waveguide"),
        "geometric": with_model("geometric"),
        "Snyder": with_model("snyder"),
    }


def main() -> None:
    """Draw and save."""
    figure, panels = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
    profile, transfer, widths = panels
    theta = np.radians(np.linspace(-3.2, 3.2, 641))
    frequency = np.linspace(0, FACET_M / (WAVELENGTH_NM * 1e-9), 200)
    for name, acceptance in kinds(RHABDOM_M).items():
        style = {"color": COLOURS[name], "linewidth": 1.5, "label": name}
        profile.plot(np.degrees(theta), acceptance.eval(np.abs(theta)), **style)
        transfer.plot(np.radians(frequency), acceptance.mtf(frequency), **style)
    profile.axhline(0.5, color="#cccccc", linewidth=0.8, zorder=0)
    profile.set(xlabel="angle from the axis (°)", ylabel="sensitivity S(θ)")
    profile.set_title("Facet 25 µm, f 55 µm,\nrhabdomere 1.9 µm, 500 nm", fontsize="medium")
    profile.legend(frameon=False, fontsize="small")
    transfer.set(xlabel="spatial frequency (cycles/°)", ylabel="modulation transfer")
    transfer.set_title("Their modulation transfer", fontsize="medium")

    diffraction_rad = WAVELENGTH_NM * 1e-9 / FACET_M
    ratio = np.linspace(0.62, 2.9, 45)  # below, hardly any light stays in the rhabdomere
    found: dict[str, list[float]] = {"waveguide": [], "geometric": [], "Snyder": []}
    for w in ratio:
        for name, acceptance in kinds(w * diffraction_rad * FOCAL_M).items():
            if name in found:
                found[name].append(acceptance.width_rad() / diffraction_rad)
    for name, values in found.items():
        widths.plot(ratio, values, color=COLOURS[name], linewidth=1.5)
    widths.axhline(1.029, color=COLOURS["Airy"], linewidth=1.5, zorder=0)
    widths.set(xlabel="(d/f) / (λ/D)", ylabel="acceptance angle (λ/D)", ylim=(0, None))
    widths.set_title("Width by rhabdomere", fontsize="medium")
    # The rhabdomere carries a second mode from V = 2.405 on.
    for cut_off in (2.405, 3.832, 5.136):
        diameter_m = cut_off * WAVELENGTH_NM * 1e-9 / (math.pi * math.sqrt(1.363**2 - 1.34**2))
        at = diameter_m / FOCAL_M / diffraction_rad
        if at < ratio[-1]:
            widths.axvline(at, color="#0072b2", linewidth=0.6, linestyle=":")
            widths.text(at, 0.08, f" V = {cut_off}", fontsize="x-small", color="#0072b2")
    for axes in (profile, transfer, widths):
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(Path(__file__).resolve().parent / "acceptance.png", dpi=150)


if __name__ == "__main__":
    main()
