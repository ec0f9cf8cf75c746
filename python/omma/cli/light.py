"""``omma light show``: a figure of what a sky is like."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Literal

from omma._core import Error
from omma.base.arguments import as_named
from omma.base.figures import figure_names
from omma.cli.help import App
from omma.cli.parameters import option, out
from omma.cli.working import check_outputs, say, working
from omma.light.bands import Bands
from omma.light.lights import Light
from omma.light.nights import natural_sky, natural_sky_at
from omma.light.skies import clear_sky, clear_sky_at, moonlit_sky, overcast_sky
from omma.picture.sky_plots import plot_sky

LIGHT_HELP = """
Draw skies: their radiance, polarisation and spectrum.

**Examples**

`omma light show --sun 30 --azimuth 135 -o sky.png`
"""

SHOW_HELP = """
Draw a sky: its radiance, degree and angle of polarisation at some wavelengths, and the spectra of
what sky and sun give to level ground; .pdf, .svg or .png.

North is at the top, east at the right, the zenith in the middle. The sun stands where --sun and
--azimuth say, or where it is at a time (with its time zone) and place. A clear sky ends where the
sun is 8 degrees below the horizon, a natural one goes on into the night. docs/light.md says what
the skies are.

**Examples**

`omma light show --sun 30 --azimuth 135 -o sky.png`

`omma light show --time 2026-06-21T19:30:00+02:00 --place 52.5,13.4 -o evening.pdf`

`omma light show --sun 40 --kind overcast -o cloud.png --wavelength 500`

`omma light show --sun -12 --kind natural -o dusk.png --wavelength 440`
"""

# Of figures: finer than eyes need.
_BANDS = 40

light_app = App(help=LIGHT_HELP, no_args_is_help=True)


@light_app.callback()
def _light() -> None:
    pass


@light_app.command(help=SHOW_HELP, short_help="Draw a sky.")
def show(
    output: Annotated[list[Path], out("Figure to write: .pdf, .svg, .png. May be repeated.")],
    sun: Annotated[
        float | None, option("Elevation of the sun or the moon, degrees.", "DEG")
    ] = None,
    azimuth: Annotated[float, option("Its azimuth from north to the east, degrees.", "DEG")] = 0.0,
    time: Annotated[
        str | None, option("Instead: when, such as 2026-06-21T12:00:00+02:00.", "TIME")
    ] = None,
    place: Annotated[
        str | None, option("And where: latitude and longitude, degrees.", "LAT,LON")
    ] = None,
    kind: Annotated[
        Literal["clear", "natural", "moonlit", "overcast"], option("Which sky.")
    ] = "clear",
    aerosol: Annotated[float, option("Optical depth of haze at 550 nm.", "DEPTH")] = 0.1,
    ozone: Annotated[float, option("Ozone, Dobson units.", "DU")] = 300.0,
    albedo: Annotated[float, option("What land gives back, 0 to 1.", "ALBEDO")] = 0.1,
    height: Annotated[float, option("Of the land above the sea, m.", "M")] = 0.0,
    haze_kind: Annotated[
        Literal["rural", "urban", "maritime", "smoke"], option("Kind of haze.")
    ] = "rural",
    wavelength: Annotated[
        list[float] | None, option("To draw, nm; may be repeated. Default: 350, 440, 550.", "NM")
    ] = None,
    unit: Annotated[Literal["photons", "watts"], option("Of light.")] = "photons",
) -> None:
    """Draw a sky."""
    names = figure_names(output)
    check_outputs(*output)
    with working():
        with as_named(
            sun_elevation_deg="sun",
            sun_azimuth_deg="azimuth",
            ozone_du="ozone",
            height_m="height",
            latitude_deg="place",
            longitude_deg="place",
        ):
            air: dict[str, Any] = {"aerosol": aerosol, "ozone_du": ozone, "albedo": albedo}
            air |= {"height_m": height, "haze_kind": haze_kind}
            air |= {"bands": Bands.equal(_BANDS), "unit": unit}
            light = _sky(kind, sun, azimuth, time, place, air)
        plot_sky(names, light, wavelength or (350.0, 440.0, 550.0))
    for name in names:
        say(f"wrote {name}")


def _sky(
    kind: str,
    sun: float | None,
    azimuth: float,
    time: str | None,
    place: str | None,
    air: dict[str, Any],
) -> Light:
    """``air``: arguments that all skies take."""
    if (sun is None) == (time is None) or (time is None) != (place is None):
        raise Error("show: expected either --sun or --time and --place")
    if sun is None:
        if kind not in ("clear", "natural"):
            raise Error(f"kind: expected clear or natural with --time and --place, found {kind}")
        make = clear_sky_at if kind == "clear" else natural_sky_at
        return make(_moment(time or ""), *_place(place or ""), **air)
    if kind == "overcast":
        return overcast_sky(sun, **air)
    if kind == "moonlit":
        return moonlit_sky(sun, moon_azimuth_deg=azimuth, **air)
    if kind == "natural":
        return natural_sky(sun, sun_azimuth_deg=azimuth, **air)
    return clear_sky(sun, sun_azimuth_deg=azimuth, **air)


def _moment(text: str) -> datetime:
    try:
        moment = datetime.fromisoformat(text.replace("Z", "+00:00"))
    except ValueError:
        moment = None
    if moment is None or moment.tzinfo is None:
        raise Error(f"time: expected one such as 2026-06-21T12:00:00+02:00, found {text!r:.60}")
    return moment


def _place(text: str) -> tuple[float, float]:
    try:
        latitude, longitude = (float(word) for word in text.split(","))
    except ValueError:
        raise Error(f"place: expected latitude,longitude, found {text!r:.60}") from None
    return latitude, longitude
