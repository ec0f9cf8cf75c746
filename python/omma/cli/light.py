"""``omma light show``: a figure of what a sky is like."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
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
from omma.picture.light_titles import light_title
from omma.picture.sky_plots import plot_sky
from omma.scene.light_words import parse_light

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
sun is 8 degrees below the horizon, a natural one goes on into the night. --light draws any light
that omma render takes, by the same words. docs/light.md says what the skies are.

**Examples**

`omma light show --sun 30 --azimuth 135 -o sky.png`

`omma light show --time 2026-06-21T19:30:00+02:00 --place 52.5,13.4 -o evening.pdf`

`omma light show --sun 40 --kind overcast -o cloud.png --wavelength 500`

`omma light show --sun -12 --kind natural -o dusk.png --wavelength 440`

`omma light show --light 'cloudy_sky sun_elevation_deg=30 cloud_fraction=0.3' -o clouds.png`
"""

# Of figures: finer than eyes need, 10 nm about 310, 320 to 690, so that these are what is drawn.
_EDGES_NM = (300, *range(305, 700, 10), 700)
_KINDS = ("clear", "natural", "moonlit", "overcast")

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
    azimuth: Annotated[
        float | None, option("Its azimuth from north to the east, degrees. Default: 0.", "DEG")
    ] = None,
    time: Annotated[
        str | None, option("Instead: when, such as 2026-06-21T12:00:00+02:00.", "TIME")
    ] = None,
    place: Annotated[
        str | None, option("And where: latitude and longitude, degrees.", "LAT,LON")
    ] = None,
    light: Annotated[
        str | None,
        option(
            "Instead: any light, in the words of omma render, such as 'cloudy_sky "
            "sun_elevation_deg=30 cloud_fraction=0.3'.",
            "WORDS",
        ),
    ] = None,
    kind: Annotated[
        str | None, option("Which sky. Default: clear.", "[clear|natural|moonlit|overcast]")
    ] = None,
    aerosol: Annotated[
        float | None, option("Optical depth of haze at 550 nm. Default: 0.1.", "DEPTH")
    ] = None,
    ozone: Annotated[float | None, option("Ozone, Dobson units. Default: 300.", "DU")] = None,
    albedo: Annotated[
        float | None, option("What land gives back, 0 to 1. Default: 0.1.", "ALBEDO")
    ] = None,
    height: Annotated[
        float | None, option("Of the land above the sea, m. Default: 0.", "M")
    ] = None,
    haze_kind: Annotated[
        Literal["rural", "urban", "maritime", "smoke"] | None,
        option("Kind of haze. Default: rural."),
    ] = None,
    wavelength: Annotated[
        list[float] | None,
        option(
            "To draw, nm, 300 to 700: each in the band of 10 nm that it lies in, of those about "
            "310, 320 to 690, or in that of --light, where it says its bands. May be repeated. "
            "Default: 350, 440, 550.",
            "NM",
        ),
    ] = None,
    unit: Annotated[
        Literal["photons", "watts"] | None, option("Of light. Default: photons.")
    ] = None,
) -> None:
    """Draw a sky."""
    names = figure_names(output)
    check_outputs(*output)
    with working():
        air: dict[str, Any] = {"aerosol": aerosol, "ozone_du": ozone, "albedo": albedo}
        air |= {"height_m": height, "haze_kind": haze_kind, "unit": unit}
        said = {name: one for name, one in air.items() if one is not None}
        if light is not None:
            beside = {"sun": sun, "azimuth": azimuth, "time": time, "place": place, "kind": kind}
            beside |= {"ozone": ozone, "height": height, **said}
            shown = _in_words(light, [name for name, one in beside.items() if one is not None])
        else:
            chosen = _checked_kind(kind or "clear")
            named = {
                "sun_elevation_deg": "sun",
                "moon_elevation_deg": "sun",
                "sun_azimuth_deg": "azimuth",
                "moon_azimuth_deg": "azimuth",
                "ozone_du": "ozone",
                "height_m": "height",
                "date_time": "time",
                "latitude_deg": "place",
                "longitude_deg": "place",
            }
            with _skies_by_kind(), as_named(**named):
                said["bands"] = Bands.from_edges(_EDGES_NM)
                shown = _sky(chosen, sun, azimuth or 0.0, time, place, said)
        with as_named(wavelengths_nm="wavelength"):
            plot_sky(names, shown, wavelength or None, title=_title(shown, time, place))
    for name in names:
        say(f"wrote {name}")


def _in_words(words: str, others: list[str]) -> Light:
    """The light of --light; ``others``: arguments that were given beside it."""
    if others:
        raise Error(f"{others[0]}: goes without --light, whose words say it all")
    light: Light = parse_light(words, Bands.from_edges(_EDGES_NM))["light"]
    return light


def _checked_kind(kind: str) -> str:
    if kind not in _KINDS:
        raise Error(
            f"kind: expected one of {', '.join(_KINDS)}, found {kind!r:.40}; --light draws all "
            "others, such as --light 'cloudy_sky sun_elevation_deg=30'"
        )
    return kind


@contextmanager
def _skies_by_kind() -> Iterator[None]:
    """Errors inside say --kind where they name the sky that goes on where a clear one ends."""
    try:
        yield
    except Error as error:
        raise Error(
            re.sub("; natural_sky(_at)? goes", "; --kind natural goes", str(error))
        ) from None


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
        raise Error("show: expected either --sun or --time and --place, or --light")
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


def _title(light: Light, time: str | None, place: str | None) -> str | None:
    """Time and place as they were asked for, ahead of the sky that they gave; None: no time was."""
    if time is None or place is None:
        return None
    said = light_title(light)
    when = _moment(time).isoformat(" ", "minutes")
    if when in said:
        return said
    latitude, longitude = _place(place)
    return f"{when}, latitude {latitude:g}°, longitude {longitude:g}°: {said}"


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
