"""Makes docs/light-water.png: the light under water at three depths, with Snell's window.

    .venv/bin/python docs/make_water_figure.py

Some seconds.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import omma
from omma.base.figures import figure_style, save_figure
from omma.light import Bands, Light, clear_sky, under_water

DOCS = Path(__file__).resolve().parent
DEPTHS_M, TYPES = (1.0, 5.0, 20.0), {"IB": "clear ocean, IB", "3C": "coast, 3C"}
ELEVATION_DEG = 40.0


def directions() -> NDArray[np.float64]:
    """Of a panorama, a degree a pixel, the horizon in the middle: (180, 360, 3)."""
    azimuth = np.radians(np.arange(360) - 179.5)
    elevation = np.radians(89.5 - np.arange(180))[:, None]
    across, up = np.broadcast_arrays(azimuth, elevation)
    return np.stack(
        [np.sin(across) * np.cos(up), np.sin(up), -np.cos(across) * np.cos(up)], axis=-1
    )


def picture(light: Light) -> NDArray[np.uint8]:
    """As people see it, exposed for its depth."""
    seen = light.radiance(directions())[..., 0, :]
    colours = omma.picture.bands_to_rgb(seen.reshape(-1, len(light.bands)), light)
    bright = np.quantile(colours.max(axis=1), 0.8)
    return omma.picture.display(1 - np.exp(-colours.reshape(180, 360, 3) / bright))


def polarisation(light: Light) -> NDArray[np.float64]:
    """The degree of polarisation in the green."""
    stokes = light.radiance(directions())[..., 7]
    return np.hypot(stokes[..., 1], stokes[..., 2]) / stokes[..., 0]


def main() -> None:
    figure_style()
    figure = Figure(figsize=(9.2, 5.2), layout="constrained")
    panels = figure.subplots(3, 3)
    above = clear_sky(ELEVATION_DEG, bands=Bands.equal(12, 400, 700))
    extent = (-180, 180, -90, 90)
    shown = None
    for column, depth_m in enumerate(DEPTHS_M):
        for row, (kind, words) in enumerate(TYPES.items()):
            light = under_water(above, depth_m, kind)
            panels[row, column].imshow(picture(light), extent=extent, aspect="auto")
            panels[row, column].set_title(f"{words}, {depth_m:g} m", loc="left")
            if kind == "IB":
                shown = panels[2, column].imshow(
                    polarisation(light), extent=extent, aspect="auto", vmin=0, vmax=0.6
                )
        panels[2, column].set_title(f"polarisation, IB, {depth_m:g} m", loc="left")
    for (row, column), panel in np.ndenumerate(panels):
        panel.set_xticks([-90, 0, 90], ["left", "ahead", "right"] if row == 2 else [""] * 3)
        panel.set_yticks(
            [-90, 0, 41.7, 90], ["down", "0°", "42°", "up"] if column == 0 else [""] * 4
        )
        panel.tick_params(length=2, labelsize="small")
    assert shown is not None
    figure.colorbar(shown, ax=panels[2, :], shrink=0.9, label="degree at 587 nm")
    save_figure(figure, [str(DOCS / "light-water.png")], dpi=102)


if __name__ == "__main__":
    main()
