"""What a light is called in a figure's title: how it was made, and what was done to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any

from omma.light.lights import Light

# By the ends of names of arguments.
_UNITS = {"deg": "°", "du": " DU", "m": " m"}
_SHARES = {0.5: "half", 1.0: "all"}


def light_title(light: Light) -> str:
    """Such as "clear sky, sun elevation 30°, half cirrus, 3 m under water 3C"."""
    if light.recipe is None:
        return f"{len(light.bands)} bands"
    name, arguments = light.recipe
    before = arguments.get("light")
    if isinstance(before, Light):
        of_before = light_title(before)
        if name == "plus":
            return f"{of_before} + {light_title(arguments['other'])}"
        if before.recipe is not None and before.recipe[0] == "plus":
            of_before = f"({of_before})"
        if name == "scaled":
            return f"{arguments['factor']:g} × {of_before}"
        change = _CHANGES.get(name)
        return f"{of_before}, {change(arguments) if change else name.replace('_', ' ')}"
    words = []
    for key, value in arguments.items():
        quantity, _, ending = key.rpartition("_")
        if isinstance(value, (int, float)):
            unit = _UNITS.get(ending, "")
            value = _within_a_turn(value) if key.endswith("azimuth_deg") else value
            # Hundredths, as times are told to the minute, in which the sun goes a quarter degree.
            value = round(value, 2) if ending == "deg" else value
            words.append(f"{(quantity if unit else key).replace('_', ' ')} {value:g}{unit}")
        elif key == "haze_kind":
            words.append(f"{value} haze")
    called = name.replace("_", " ")
    moment = arguments.get("date_time")
    if isinstance(moment, datetime):
        called += f" {moment.isoformat(' ', 'minutes')}"  # "clear sky at ..."
    return ", ".join([called, *words])


def _clouds(arguments: Mapping[str, Any]) -> str:
    share = arguments["cloud_fraction"]
    return f"{_SHARES.get(share, f'{share:.0%}')} {arguments.get('kind', 'cumulus')}"


def _water(arguments: Mapping[str, Any]) -> str:
    measured = arguments.get("absorption_per_m") is not None
    kind = " as measured" if measured else f" {arguments.get('water') or 'IB'}"
    return f"{arguments['depth_m']:g} m under water{kind}"


def _air(arguments: Mapping[str, Any]) -> str:
    height_m = arguments.get("layer_height_m")
    layer = f", {height_m:g} m high" if height_m else ""
    if arguments.get("extinction_per_m") is not None:
        return f"air as measured{layer}"
    visibility_m = arguments.get("visibility_m")
    if visibility_m is None:
        return "its own air"
    return f"air of visibility {visibility_m:g} m{layer}"


def _within_a_turn(azimuth_deg: float) -> float:
    """Without whole turns."""
    return math.fmod(azimuth_deg, 360.0)


_CHANGES: Mapping[str, Callable[[Mapping[str, Any]], str]] = {
    "clouded": _clouds,
    "under_water": _water,
    "with_air": _air,
    "turned": lambda arguments: f"turned by {_within_a_turn(arguments['azimuth_deg']):g}°",
}
