"""Makes the figures of docs/light.md: docs/sky-*.png.

.venv/bin/python docs/make_sky_figures.py
"""

from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm, Normalize

from omma.light.sky_tables import clear_sky_map
from omma.picture.unseen import CYCLIC_COLOURS

FOLDER = Path(__file__).resolve().parent
SUNS_DEG = (60, 30, 5, -3)
NM = np.array([350.0, 440.0, 540.0])
FINE_NM = np.arange(300.0, 701.0, 2.0)

Values = Callable[[np.ndarray], np.ndarray]


def radiance(stokes: np.ndarray) -> np.ndarray:
    return stokes[:, :, 0]


def degree(stokes: np.ndarray) -> np.ndarray:
    return np.hypot(stokes[:, :, 1], stokes[:, :, 2]) / stokes[:, :, 0]


def angle(stokes: np.ndarray) -> np.ndarray:
    return np.degrees(np.arctan2(stokes[:, :, 2], stokes[:, :, 1])) / 2


def all_sky(
    name: str, title: str, of: Values, colours: str, norm: Callable[[np.ndarray], Normalize]
) -> None:
    """Discs of the whole sky as one sees it lying on the back: suns across, wavelengths down."""
    figure, panels = plt.subplots(
        3, 4, figsize=(10, 7.6), subplot_kw={"projection": "polar"}, layout="constrained"
    )
    skies = [clear_sky_map(NM, np.eye(3), sun, 0.0)[0][0] for sun in SUNS_DEG]
    azimuth = np.radians(np.arange(361))
    zenith = np.arange(90, -1, -1)
    for row, nm in enumerate(NM):
        for column, (sun, sky) in enumerate(zip(SUNS_DEG, skies)):
            panel = panels[row, column]
            values = of(sky[:, :, :, row])
            # The sun's meridian up, azimuth to the left: one looks up at the sky.
            panel.set_theta_zero_location("N")
            panel.set_theta_direction(1)
            picture = panel.pcolormesh(
                azimuth,
                zenith,
                np.concatenate([values, values[:, :1]], axis=1),
                cmap=colours,
                norm=norm(values),
                shading="nearest" if of is angle else "gouraud",
                rasterized=True,
            )
            panel.set_rlim(0, 90)
            panel.set_rgrids([30, 60], ["", ""])
            panel.set_thetagrids([0, 90, 180, 270], ["sun", "", "", ""] if row == 0 else [""] * 4)
            panel.tick_params(labelsize=8, pad=0)
            panel.grid(color="white", lw=0.3, alpha=0.5)
            panel.scatter([0], [90 - max(sun, 0)], s=30, color="#ffd23f", edgecolor="black", lw=0.6)
            if row == 0:
                panel.set_title(f"sun at {sun}°".replace("-", "−"), fontsize=10, pad=12)
            if column == 0:
                panel.set_ylabel(f"{nm:.0f} nm", fontsize=10, labelpad=22)
            if of is radiance:
                bar = figure.colorbar(picture, ax=panel, shrink=0.75, pad=0.04)
                bar.ax.tick_params(which="both", labelsize=6.5)
    if of is not radiance:
        bar = figure.colorbar(picture, ax=panels, shrink=0.5, aspect=30)
        bar.set_label(title, fontsize=9)
        bar.ax.tick_params(labelsize=8)
    else:
        figure.supxlabel(title, fontsize=9)
    figure.savefig(FOLDER / f"sky-{name}.png", dpi=90)
    plt.close(figure)


def spectra() -> None:
    """Irradiance on the ground: of sky and sun, by wavelength."""
    edge = np.radians(np.concatenate([[0], np.arange(0.5, 90), [90]]))
    ring = np.pi * np.diff(np.sin(edge) ** 2) / 360
    figure, panels = plt.subplots(1, 2, figsize=(9.5, 3.6), layout="constrained")
    suns = (60, 30, 10, 5, 0, -3, -6)
    for sun, colour in zip(suns, plt.get_cmap("viridis_r")(np.linspace(0.1, 1, len(suns)))):
        sky, direct = clear_sky_map(FINE_NM, np.eye(len(FINE_NM)), sun, 0.0)
        from_sky = np.einsum("e,eab->b", ring, sky[0, :, :, 0].astype(float))
        total = from_sky + direct * max(0.0, np.sin(np.radians(sun)))
        label = f"{sun}°".replace("-", "−")
        panels[0].plot(FINE_NM, total, color=colour, label=label, lw=1.3)
        if sun > 0:
            panels[1].plot(FINE_NM, from_sky / total, color=colour, label=label, lw=1.5)
    panels[0].set_yscale("log")
    panels[0].set_ylim(1e11, 1e19)
    panels[0].set_ylabel("photons m$^{-2}$ s$^{-1}$ nm$^{-1}$", fontsize=9)
    panels[0].set_title("Light on level ground, sun at", loc="left", fontsize=10)
    panels[1].set_ylim(0, 1)
    panels[1].set_title("The sky's share of it", loc="left", fontsize=10)
    for panel in panels:
        panel.set_xlim(300, 700)
        panel.set_xlabel("wavelength (nm)", fontsize=9)
        panel.spines[["top", "right"]].set_visible(False)
        panel.tick_params(labelsize=8.5)
        panel.legend(fontsize=8, frameon=False, ncols=2)
    figure.savefig(FOLDER / "sky-spectra.png", dpi=110)
    plt.close(figure)


def main() -> None:
    all_sky(
        "radiance",
        "radiance, photons m$^{-2}$ s$^{-1}$ sr$^{-1}$ nm$^{-1}$",
        radiance,
        "viridis",
        lambda values: LogNorm(values.min(), values.max()),
    )
    all_sky("degree", "degree of polarisation", degree, "magma", lambda _: Normalize(0, 0.9))
    all_sky(
        "angle",
        "angle of polarisation from the vertical, to the right (degrees)",
        angle,
        CYCLIC_COLOURS,
        lambda _: Normalize(-90, 90),
    )
    spectra()


if __name__ == "__main__":
    main()
