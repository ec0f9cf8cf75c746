"""Figures of light: the sky's radiance and polarisation at some wavelengths, and the spectra of
what sky and sun give to level ground.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from omma._core import Error
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Floats
from omma.base.directions import direction
from omma.base.figures import (
    COLOURS,
    GREY,
    INK,
    MM,
    figure_names,
    figure_style,
    load_matplotlib,
    plain,
    wrapped,
)
from omma.base.figures import save_figure as save
from omma.base.files import PathLike
from omma.light.bands import Bands
from omma.light.lights import Light
from omma.picture.light_titles import light_title
from omma.picture.neutral_points import neutral_points
from omma.picture.sky_marks import mark_discs, mark_neutral, shining
from omma.picture.unseen import CYCLIC_COLOURS, NOT_KNOWN

_PIXELS = 301  # across a sky
_LEAST_POLARISED = 0.01  # below it there is no angle to draw
_DRAWN_NM = (350.0, 440.0, 550.0)  # where nobody says
_MOST_WAVELENGTHS = 6
_LETTERS = 100  # of a title across the figure
#: Of spectral radiance and irradiance.
RADIANCE_UNITS = {"photons": "photons m⁻² s⁻¹ sr⁻¹ nm⁻¹", "watts": "W m⁻² sr⁻¹ nm⁻¹"}
_IRRADIANCE_UNITS = {"photons": "photons m⁻² s⁻¹ nm⁻¹", "watts": "W m⁻² nm⁻¹"}


@checked
def plot_sky(
    paths: PathLike | Sequence[PathLike],
    light: Light,
    wavelengths_nm: Sequence[float] | None = None,
    *,
    title: str | None = None,
    size_mm: float = 180.0,
) -> None:
    """Draw a light: radiance, degree and angle of polarisation of the sky above, in the bands that
    some wavelengths lie in, and the spectra of what sky and discs give to level ground.

    The sky as a map, seen from above: -Z (north) at the top, +X (east) at the right, the zenith in
    the middle, equal angles equally far. Crosses are neutral points, where nothing is polarised, on
    the meridian of the sun or the moon; all over the sky where both light it, by night and in
    twilight; in a sky that was changed or put together, by clouds say, only those with polarised
    light around them. Names are of those above water that lie where the sky's own do, on the
    meridian within 45° of the sun, the moon or the point opposite. A yellow dot is the sun or the
    moon, where it gives a hundredth of what the sky does or more: none behind clouds.

    Args:
        paths: .pdf, .svg or .png, one or several.
        wavelengths_nm: 1 to 6, within the bands of the light. Each row says the middle of its band.
            None: of 350, 440 and 550 those that are, or else the middle of the bands.
        title: by default how the light was made.
        size_mm: width of the figure.

    Raises:
        omma.Error: Matplotlib is missing, a name ends in something else, an argument is out of
            range, a file cannot be written.
    """
    names = figure_names(paths)
    bands = _bands_drawn(light.bands, wavelengths_nm)
    positive(size_mm, "size_mm")
    with figure_style(max(3.0, 7 * size_mm / 180)):
        called = title or light_title(light)
        if "\n" not in called:
            called = wrapped(called, _LETTERS)
        save(_figure(light, bands, called, size_mm), names)


def _bands_drawn(bands: Bands, wavelengths_nm: Sequence[float] | None) -> list[int]:
    """The numbers of the bands that wavelengths lie in; where bands are no intervals, the nearest.

    Raises:
        omma.Error: too few, too many, or one that lies in no band.
    """
    low, high = _range_nm(bands)
    if wavelengths_nm is None:
        within = [nm for nm in _DRAWN_NM if low <= nm <= high] or [(low + high) / 2]
        return list(dict.fromkeys(_band_of(bands, nm) for nm in within))
    chosen = array_of(wavelengths_nm, "wavelengths_nm", (None,))
    if not 1 <= len(chosen) <= _MOST_WAVELENGTHS or not np.all(np.isfinite(chosen)):
        raise Error(f"wavelengths_nm: expected 1 to {_MOST_WAVELENGTHS} wavelengths")
    for nm in chosen.tolist():
        if not low <= nm <= high:
            meant = f"; {nm:g} µm would be {1000 * nm:g} nm" if low <= 1000 * nm <= high else ""
            raise Error(
                f"wavelengths_nm: expected {low:g} to {high:g} nm, where the bands of this light "
                f"are, found {nm:g}{meant}"
            )
    return [_band_of(bands, nm) for nm in chosen.tolist()]


def _range_nm(bands: Bands) -> tuple[float, float]:
    """From where to where there is light in bands."""
    if bands.edges_nm is not None:
        return float(bands.edges_nm[0]), float(bands.edges_nm[-1])
    used = np.any(bands.weight > 0, axis=0)
    nm, half = bands.wavelength_nm[used], bands.steps_nm[used] / 2
    return float(nm[0] - half[0]), float(nm[-1] + half[-1])


def _band_of(bands: Bands, nm: float) -> int:
    if bands.edges_nm is not None:
        return max(int(np.searchsorted(bands.edges_nm, nm)) - 1, 0)
    return int(np.argmin(np.abs(bands.centers_nm - nm)))


def _figure(light: Light, bands: list[int], title: str, size_mm: float) -> Any:
    figure = load_matplotlib()(
        figsize=(size_mm * MM, size_mm * MM * (0.25 * len(bands) + 0.27)), layout="constrained"
    )
    # Labels of bars of colours reach beyond what the layout knows of.
    layout: Any = figure.get_layout_engine()
    layout.set(rect=(0, 0, 0.98, 1))
    figure.suptitle(plain(title))
    grid = figure.add_gridspec(len(bands) + 1, 3, height_ratios=[1.0] * len(bands) + [0.8])
    span = np.linspace(-1, 1, _PIXELS)
    east, north = np.meshgrid(span, span)
    from_zenith = np.hypot(east, north) * 90
    inside = from_zenith <= 90
    towards = direction(np.degrees(np.arctan2(east, north)), np.maximum(90 - from_zenith, 0))
    stokes = light._radiance_of(towards, bands)
    discs = shining(light)
    skies = [[figure.add_subplot(grid[row, k]) for k in range(3)] for row in range(len(bands))]
    for row, band in enumerate(bands):
        i, q, u = (np.where(inside, stokes[:, :, k, row], np.nan) for k in range(3))
        label = f"{light.bands.centers_nm[band]:.0f} nm"
        _radiance(figure, skies[row][0], light, i, label)
        with np.errstate(divide="ignore", invalid="ignore"):
            degree = np.hypot(q, u) / i
        _degree(figure, skies[row][1], degree)
        _angle(figure, skies[row][2], np.degrees(np.arctan2(u, q)) / 2, degree)
        for panel in skies[row]:
            _sky_frame(panel)
            mark_discs(panel, discs)
        points = neutral_points(light, band)
        for panel in skies[row][1:]:
            mark_neutral(panel, points, discs)
    for panel, name in zip(
        skies[0], ("radiance", "degree of polarisation", "angle of polarisation"), strict=True
    ):
        panel.set_title(name)
    _note(skies[-1][0], "as seen from above, like a map of land: east at the right")
    _spectra(figure.add_subplot(grid[-1, :]), light)
    return figure


def _radiance(figure: Any, panel: Any, light: Light, values: Floats, label: str) -> None:
    from matplotlib.colors import LogNorm

    lit = values[np.isfinite(values) & (values > 0)]
    panel.set_ylabel(label, rotation=0, labelpad=20, fontsize="large")
    if not len(lit):
        panel.text(0, 0, "dark", ha="center", va="center", color=GREY)
        return
    # A disc of a pixel or two is not to set the scale.
    high = float(np.percentile(lit, 99.9))
    low = max(float(lit.min()), high * 1e-3)
    image = panel.imshow(
        values, origin="lower", extent=(-1, 1, -1, 1), norm=LogNorm(low / 1.05, high * 1.05),
        cmap="viridis",
    )  # fmt: skip
    _bar(figure, image, panel, RADIANCE_UNITS[light.unit])


def _degree(figure: Any, panel: Any, degree: Floats) -> None:
    image = panel.imshow(
        degree, origin="lower", extent=(-1, 1, -1, 1), vmin=0, vmax=1, cmap="magma"
    )
    _bar(figure, image, panel, "polarised share of I")


def _angle(figure: Any, panel: Any, angle_deg: Floats, degree: Floats) -> None:
    extent = (-1, 1, -1, 1)
    has_angle = degree >= _LEAST_POLARISED
    shown = np.where(has_angle, angle_deg, np.nan)
    image = panel.imshow(
        shown, origin="lower", extent=extent, vmin=-90, vmax=90, cmap=CYCLIC_COLOURS
    )
    bar = _bar(figure, image, panel, "from up, to the right")
    bar.set_ticks([-90, -45, 0, 45, 90], labels=["−90°", "−45°", "0°", "45°", "90°"])
    has_none = np.isfinite(angle_deg) & ~has_angle
    grey = np.full((*shown.shape, 4), NOT_KNOWN)
    grey[..., 3] = has_none
    panel.imshow(grey, origin="lower", extent=extent, zorder=0)
    if not has_angle.any():
        panel.text(0, 0, "unpolarised", ha="center", va="center", color=INK)
        return
    if has_none.any():
        _note(panel, f"grey: less than {_LEAST_POLARISED:.0%} polarised")
    # The electric vector, as it lies in the map: up points to the middle.
    rings = [(r, k / n * 2 * np.pi) for r, n in ((0.2, 6), (0.45, 14), (0.7, 22), (0.93, 30))
             for k in range(n)]  # fmt: skip
    for r, azimuth in rings:
        x, y = r * np.sin(azimuth), r * np.cos(azimuth)
        pixel = tuple(round((c + 1) / 2 * (_PIXELS - 1)) for c in (y, x))
        if not np.isfinite(shown[pixel]):
            continue
        # Who looks to the rim of the map has up behind and the right at the right.
        psi = np.radians(shown[pixel])
        inwards, sideways = np.array([-x, -y]) / r, np.array([y, -x]) / r
        half = 0.05 * (np.cos(psi) * inwards + np.sin(psi) * sideways)
        panel.plot([x - half[0], x + half[0]], [y - half[1], y + half[1]], color="k", linewidth=0.7)


def _note(panel: Any, text: str) -> None:
    panel.text(0, -1.24, text, ha="center", va="top", fontsize="x-small", color=GREY)


def _bar(figure: Any, image: Any, panel: Any, label: str) -> Any:
    bar = figure.colorbar(image, cax=panel.inset_axes((1.04, 0.12, 0.045, 0.76)))
    bar.set_label(label, fontsize="small")
    bar.outline.set_linewidth(0.4)
    return bar


def _sky_frame(panel: Any) -> None:
    for elevation in (30, 60):
        turn = np.linspace(0, 2 * np.pi, 181)
        r = 1 - elevation / 90
        panel.plot(r * np.sin(turn), r * np.cos(turn), color="w", linewidth=0.3, alpha=0.6)
    for name, x, y in (("N", 0, 1.09), ("E", 1.09, 0), ("S", 0, -1.09), ("W", -1.09, 0)):
        panel.text(x, y, name, ha="center", va="center", fontsize="x-small", color=GREY)
    panel.set(xlim=(-1.17, 1.17), ylim=(-1.17, 1.17), aspect="equal", xticks=[], yticks=[])
    panel.spines[:].set_visible(False)


def _disc_name(light: Light) -> str:
    """Whose the discs are, where the light was made by one sky alone."""
    name, arguments = light.recipe or ("", {})
    within = arguments.get("light")
    if isinstance(within, Light) and name != "plus":
        return _disc_name(within)
    return {"clear_sky": "sun", "cloudy_sky": "sun", "moonlit_sky": "moon"}.get(name, "sun or moon")


def _spectra(panel: Any, light: Light) -> None:
    sky, discs = light.irradiance()
    curves = [("sky", sky, COLOURS[0])]
    if light.discs:
        curves.append((_disc_name(light), discs, COLOURS[1]))
        curves.append(("both", sky + discs, INK))
    for name, values, colour in curves:
        if np.any(values > 0):
            # The sum is broad and below its parts, which are seen on it where they are all of it.
            wide = {"linewidth": 2.6, "markersize": 4, "zorder": 1.5} if name == "both" else {}
            style = {"markersize": 2, **wide}
            panel.plot(light.bands.centers_nm, values, "o-", color=colour, label=name, **style)
    # The power of ten beside the unit, not alone above the axis.
    unit = _IRRADIANCE_UNITS[light.unit]
    most = max((float(np.max(values)) for _, values, _ in curves), default=0.0)
    if most > 0 and not 1e-2 <= most < 1e4:
        power = math.floor(math.log10(most))
        panel.yaxis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
        unit = f"$10^{{{power}}}$ {unit}"
    panel.set(xlabel="wavelength (nm)", ylabel=f"on level ground\n({unit})", ylim=(0, None))
    if panel.lines:
        panel.legend(frameon=False, loc="upper left")
