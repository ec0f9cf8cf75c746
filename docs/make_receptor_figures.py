"""Makes docs/receptors.png and docs/neural-superposition.png.

.venv/bin/python docs/make_receptor_figures.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap

import omma
from omma.eye.trapezoid import TRAPEZOID

FOLDER = Path(__file__).resolve().parent
RECEPTORS = {"ultraviolet": "#7b3fa0", "blue": "#2166ac", "green": "#4d9221"}
PRIMARIES = {"red": "#d6302a", "green": "#3a9a3a", "blue": "#3465c8"}
NM = np.arange(300, 701)


def style(panel: Axes, title: str) -> None:
    panel.set_title(title, loc="left", fontsize=10)
    panel.spines[["top", "right"]].set_visible(False)
    panel.tick_params(labelsize=8.5)


def spectra(panel: Axes) -> None:
    panel.axvspan(300, 400, color="0.93", lw=0)
    panel.set_xlim(300, 700)
    panel.set_ylim(0, 1.12)
    panel.set_xlabel("wavelength (nm)", fontsize=9)


def fraction(panel: Axes, x: float, row: int, value: float, color: str) -> None:
    panel.text(x, row, f"{value:.2f}", ha="center", va="center", color=color, fontsize=7.5)


def receptor_figure() -> None:
    types = {
        receptor.name: receptor
        for kind in omma.receptors.honeybee_ommatidia()
        for receptor in kind.receptors
    }
    figure, panels = plt.subplots(1, 3, figsize=(11, 3.4), width_ratios=[1.2, 1.2, 1])
    spectra(panels[0])
    style(panels[0], "What a honeybee's receptors are sensitive to")
    for name, color in RECEPTORS.items():
        panels[0].plot(NM, omma.receptors.spectral_sensitivity(types[name], NM), color=color, lw=2)
        peak = types[name].peak_wavelength_nm
        panels[0].text(peak, 1.04, f"{peak:.0f} nm", color=color, ha="center", fontsize=8.5)
    panels[0].set_ylabel("relative sensitivity", fontsize=9)
    spectra(panels[1])
    style(panels[1], "What red, green and blue stand for")
    fractions = omma.light.primary_spectra(NM[100:])
    for k, (name, color) in enumerate(PRIMARIES.items()):
        panels[1].plot(NM[100:], fractions[:, k], color=color, lw=2)
        middle = {"red": 650, "green": 545, "blue": 430}[name]
        panels[1].text(middle, 1.04, name, color=color, ha="center", fontsize=8.5)
    panels[1].text(350, 0.5, "RGB says\nnothing\nhere", ha="center", fontsize=8.5, color="0.35")
    panels[1].set_ylabel("share of white's photons", fontsize=9)
    style(panels[2], "What a receptor gets of each")
    matrix = omma.receptors.receptor_matrix([types[name] for name in RECEPTORS])
    for row in range(3):
        left = 0.0
        for k, color in enumerate(PRIMARIES.values()):
            value = matrix[row, k]
            panels[2].barh(row, value, left=left, color=color, height=0.6)
            if value > 0.1:
                at = left + value / 2
                fraction(panels[2], at, row, value, "w")
            left += value
        panels[2].barh(row, 1 - left, left=left, color="0.9", height=0.6)
        if 1 - left > 0.1:
            at = (1 + left) / 2
            fraction(panels[2], at, row, 1 - left, "0.3")
    panels[2].set_yticks(range(3), list(RECEPTORS))
    panels[2].invert_yaxis()
    panels[2].set_xlim(0, 1)
    panels[2].set_xlabel("share of its sensitivity (grey: below 400 nm)", fontsize=9)
    figure.tight_layout()
    figure.savefig(FOLDER / "receptors.png", dpi=130)


def fly_eye(spacing_rad: float, steps: int) -> tuple[omma.Eye, np.ndarray]:
    """A hexagonal lattice of axes around the right, and its places in steps."""
    a, b = np.mgrid[-2 * steps : 2 * steps + 1, -2 * steps : 2 * steps + 1].reshape(2, -1)
    place = np.stack([a * np.sqrt(3) / 2, b + a / 2], axis=1)
    place = place[np.hypot(*place.T) < steps + 0.01]
    angle = np.hypot(*place.T) * spacing_rad
    shrink = np.sinc(angle / np.pi) * spacing_rad
    axis = np.stack([np.cos(angle), shrink * place[:, 1], shrink * place[:, 0]], axis=1)
    return omma.Eye(1e-3 * axis, axis, spacing_rad), place


def superposition_figure() -> None:
    spacing = np.radians(4.5)
    eye, place = fly_eye(spacing, 13)
    fly = omma.eye.superposition.fly_receptors(eye)
    wiring = omma.eye.superposition.neural_superposition_wiring(fly)
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.6), width_ratios=[1, 1.15])
    style(panels[0], "Where two ommatidia look (right eye)")
    panels[0].scatter(*place.T, s=60, facecolors="none", edgecolors="0.8")
    looking = omma.receptors.receptor_axis(fly)
    owner = omma.receptors.ommatidium_of_receptor(fly)
    for middle, color in (((0.0, 4.0), "#2166ac"), ((0.0, -4.0), "#b35806")):
        one = int(np.argmin(np.hypot(*(place - middle).T)))
        for r in np.flatnonzero(owner == one):
            kind = fly.receptor_types[fly.receptor_type[r]]
            view = looking[r].astype(float)
            angle = np.arccos(view[0]) / np.hypot(view[1], view[2]) / spacing
            at = angle * view[[2, 1]]
            panels[0].scatter(*at, s=60, color=color)
            if kind.name[:2] != "R8":  # it looks where R7 looks
                name = kind.name if kind.name in TRAPEZOID else "R7, R8"
                panels[0].annotate(
                    name, at, (9, -3), textcoords="offset points", fontsize=8.5, color=color,
                    bbox={"color": "w", "pad": 0.5, "lw": 0},
                )  # fmt: skip
    panels[0].axhline(0, color="0.5", lw=1, ls="--")
    panels[0].text(-4.5, 0.12, "equator", fontsize=8.5, color="0.35")
    panels[0].set_xlim(-4.6, 5)
    panels[0].set_ylim(-6.4, 6.4)
    style(panels[1], "How many R1 to R6 meet in a cartridge")
    colors = ListedColormap(plt.get_cmap("viridis")(np.linspace(0.05, 0.95, 8)))
    shown = panels[1].scatter(
        *place.T, c=wiring.members, s=46, marker="h", cmap=colors,
        norm=BoundaryNorm(np.arange(0.5, 9), 8),
    )  # fmt: skip
    bar = figure.colorbar(shown, ax=panels[1], ticks=range(1, 9), shrink=0.85)
    bar.set_label("receptors", fontsize=9)
    for panel in panels:
        panel.set_aspect("equal")
        panel.set_xlabel("front  ←  interommatidial angles  →  back", fontsize=9)
        panel.set_ylabel("interommatidial angles upwards", fontsize=9)
    figure.tight_layout()
    figure.savefig(FOLDER / "neural-superposition.png", dpi=130)


if __name__ == "__main__":
    receptor_figure()
    superposition_figure()
