"""Light from text, as the command line takes it."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from typing import Any

from omma import light as skies
from omma._core import Error, Scene
from omma.base.arguments import one_of
from omma.light import Bands, Light
from omma.scene.lighting import checked_lighting
from omma.scene.without_light import is_of_light

# Functions of `omma.light`.
SKIES = (
    "clear_sky", "clear_sky_at", "cloudy_sky", "overcast_sky", "cie_sky", "natural_sky",
    "natural_sky_at", "moonlit_sky", "night_sky", "night_sky_at", "uniform_sky", "lamps",
)  # fmt: skip
# What else a world is told of its light.
OF_WORLD = ("lighting", "depth", "polarized", "ultraviolet", "sun", "emission_cd_m2")
_BANDS = "bands"
_AIR = ("visibility_m", "layer_height_m")  # of `with_air`
# Bands that have names: how many, from which wavelength to which, nm. Of visible light alone no
# material needs to say what it reflects in the ultraviolet.
_NAMED_BANDS = {"visible": (12, 400.0, 700.0)}


def parse_light(text: str, bands: Bands | None = None) -> dict[str, Any]:
    """The arguments of `omma.World` that light it, from words such as "clear_sky
    sun_elevation_deg=30 ultraviolet=dark".

    The first word is a function of `omma.light`: `SKIES`. The others are its arguments by name
    (numbers, and times such as date_time=2026-06-21T12:00:00+02:00), how many ``bands`` of the same
    width there are from 300 to 700 nm, or bands=visible, 12 from 400 nm on, ``visibility_m`` and
    ``layer_height_m`` of `omma.light.with_air`, and ``lighting``, ``depth``, ``polarized``,
    ``ultraviolet``, ``sun`` and ``emission_cd_m2`` of `omma.World`.

    Args:
        bands: where the words do not say.

    Raises:
        omma.Error: it is no such text, or an argument is out of its range.
    """
    words = text.split()
    such = " and its arguments, such as 'clear_sky sun_elevation_deg=30'"
    first = words[0] if words else ""
    if first not in SKIES and callable(getattr(skies, first, None)):
        raise Error(
            f"light: {first} is for Python alone, omma.light.{first}; expected one of "
            f"{', '.join(SKIES)}{such}"
        )
    sky = one_of(first, SKIES, "light", such)
    make = getattr(skies, sky)
    of_sky = [name for name in inspect.signature(make).parameters if name != _BANDS]
    names = [*of_sky, _BANDS, *_AIR, *OF_WORLD]
    given: dict[str, Any] = {}
    for word in words[1:]:
        name, is_said, value = word.partition("=")
        if not is_said:
            raise Error(
                f"light: {sky}: expected name=value, with a name of {', '.join(names)}, found "
                f"{word!r:.60}"
            )
        one_of(name, names, f"light: {sky}")
        if name in given:
            raise Error(f"light: {name}: is said twice")
        given[name] = _value(name, value)
    of_world = {name: given.pop(name) for name in OF_WORLD if name in given}
    air = {name: given.pop(name) for name in _AIR if name in given}
    try:
        if _BANDS in given:
            given[_BANDS] = Bands.equal(*_NAMED_BANDS.get(given[_BANDS], (given[_BANDS],)))
        elif bands is not None:
            given[_BANDS] = bands
        _check_all_said(sky, make, given, words[1:])
        light: Light = make(**given)
        if air:
            light = skies.with_air(light, **air)
        checked_lighting(
            light, of_world.get("lighting"), of_world.get("depth"),
            of_world.get("polarized", False), of_world.get("ultraviolet"),
            of_world.get("sun", "exact"), None, of_world.get("emission_cd_m2", 1.0),
        )  # fmt: skip
    except (Error, TypeError) as error:
        raise Error(f"light: {error}") from None
    return {"light": light, **of_world}


def _check_all_said(
    sky: str, make: Callable[..., Light], given: Mapping[str, Any], words: Sequence[str]
) -> None:
    """omma.Error where an argument is missing that a sky needs; it names the words that are there,
    as one of them may be meant to be it."""
    parameters = inspect.signature(make).parameters
    needed = [
        name
        for name, one in parameters.items()
        if one.default is one.empty
        and one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)
        and name not in given
    ]
    if needed:
        wanted = " and ".join(f"{name}=..." for name in needed)
        raise Error(f"{sky}: expected {wanted}, found {' '.join(words)[:60] or 'none'}")


def full_words(text: str) -> str:
    """The same words with how the world is lit said in any case, for files that tell them."""
    return text if _says_lighting(text) else f"{text} lighting=path"


def words_of_before(text: str | None) -> str | None:
    """Words that a file tells. Files of before Omma said how worlds are lit were baked, unless a
    depth was given."""
    if text is None or _says_lighting(text):
        return text
    has_depth = any(word.startswith("depth=") for word in text.split())
    return f"{text} lighting={'path' if has_depth else 'baked'}"


def _says_lighting(text: str) -> bool:
    return any(word.startswith("lighting=") for word in text.split())


def warnings_of(scene: Scene, is_lit: bool) -> list[str]:
    """What the loader of a scene passed over; in a world with light nothing of that."""
    return [one for one in scene.warnings if not (is_lit and is_of_light(one))]


def _value(name: str, text: str) -> Any:
    if name == "date_time":
        try:
            return datetime.fromisoformat(text.replace("Z", "+00:00"))
        except ValueError:
            raise Error(
                "light: date_time: expected one such as 2026-06-21T12:00:00+02:00, found "
                f"{text!r:.60}"
            ) from None
    if name == "polarized":
        if text.lower() not in ("true", "false"):
            raise Error(f"light: polarized: expected True or False, found {text!r:.60}")
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
