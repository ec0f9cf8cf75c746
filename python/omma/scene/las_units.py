"""Units of LAS files: those that their coordinate systems state, as WKT text (OGC 01-009 and
18-010, Esri's too) or as GeoTIFF keys. What a system has by its EPSG number alone is not known.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from omma.scene.point_units import DEGREES, FEET, METRES, SURVEY_FEET, Unit, Units, length_unit

# Of WKT: what holds systems, what says angles or lengths across, and heights.
_AROUND = {"COMPD_CS", "COMPOUNDCRS", "BOUNDCRS", "SOURCECRS"}
_GEOGRAPHIC = {"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"}
_GEODETIC = {"GEODCRS", "GEODETICCRS"}  # geographic, or about the Earth's middle
_ACROSS = {"PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS", "ENGINEERINGCRS"}
_HEIGHTS = {"VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"}
_TOKEN = re.compile(r'"(?:[^"]|"")*"|[\[\](),]|[^\[\](),"\s]+')

# GeoTIFF keys (OGC 19-008): the model, of which 2 is geographic, and units of lengths, of which
# 32767 is one of a length of its own.
_MODEL, _LINEAR, _LINEAR_SIZE, _VERTICAL = 1024, 3076, 3077, 4099
_BY_NUMBER = {9001: METRES, 9002: FEET, 9003: SURVEY_FEET}
_OWN = 32767
_DOUBLES = 34736


def las_units(header: Any) -> Units:
    """What the records of a LAS file's header say, WKT before GeoTIFF keys."""
    records = [*header.vlrs, *(header.evlrs or ())]
    for record in records:
        found = wkt_units(getattr(record, "string", "") or "")
        if found != Units():
            return found
    return _key_units(records)


@dataclass
class _Node:
    """``WORD["value", 1, PART[...]]``."""

    word: str
    values: list[str] = field(default_factory=list)
    parts: list[_Node] = field(default_factory=list)


def _parsed(wkt: str) -> _Node:
    """A node around all of a text; brackets that are never closed end with it."""
    root = _Node("")
    around, word = [root], ""
    for token in _TOKEN.findall(wkt):
        if token in ("[", "("):
            node = _Node(word.upper())
            around[-1].parts.append(node)
            around.append(node)
        elif token in ("]", ")", ","):
            around[-1].values += [word] if word else []
            if token != "," and len(around) > 1:
                around.pop()
        word = "" if token in ("[", "(", "]", ")", ",") else token
    return root


def wkt_units(wkt: str) -> Units:
    """Those of a system, and of its heights, that a text states."""
    across: Unit | None = None
    heights: Unit | None = None
    waiting = _parsed(wkt).parts
    while waiting:
        one = waiting.pop(0)
        if one.word in _AROUND:
            waiting = one.parts + waiting
            continue
        units = _axis_units(one)
        if one.word in _HEIGHTS:
            heights = heights or units[0]
        elif _is_geographic(one) or one.word in _ACROSS:
            across = across or (DEGREES if _is_geographic(one) else units[0])
            heights = heights or (units[2] if len(units) > 2 else None)
    return Units(across, heights)


def _is_geographic(system: _Node) -> bool:
    if system.word in _GEODETIC:
        frames = [part for part in system.parts if part.word == "CS"]
        return any("ELLIPSOIDAL" in one.values[0].upper() for one in frames if one.values)
    return system.word in _GEOGRAPHIC


def _axis_units(system: _Node) -> list[Unit | None]:
    """Units of lengths by axis, that of all axes where they have none of their own."""
    common = _length(system, not _is_geographic(system))
    axes = [_length(part, True) or common for part in system.parts if part.word == "AXIS"]
    return axes or [common]


def _length(node: _Node, is_length: bool) -> Unit | None:
    """The unit that a node states; ``is_length``: whether UNIT is that of a length."""
    words = ("LENGTHUNIT", "UNIT") if is_length else ("LENGTHUNIT",)
    for part in node.parts:
        if part.word in words and len(part.values) > 1:
            return _number_unit(part.values[1])
    return None


def _number_unit(metres: str) -> Unit | None:
    try:
        return length_unit(float(metres))
    except ValueError:
        return None


def _key_units(records: Iterable[Any]) -> Units:
    keys = {key.id: key for record in records for key in getattr(record, "geo_keys", ())}
    doubles = [one.value for record in records for one in getattr(record, "doubles", ())]
    numbers = {name: one.value_offset for name, one in keys.items() if not one.tiff_tag_location}
    across = _BY_NUMBER.get(numbers.get(_LINEAR, 0))
    size = keys.get(_LINEAR_SIZE)
    if numbers.get(_LINEAR) == _OWN and size is not None and size.tiff_tag_location == _DOUBLES:
        across = next(map(length_unit, doubles[size.value_offset :]), None)
    is_geographic = numbers.get(_MODEL) == 2
    return Units(DEGREES if is_geographic else across, _BY_NUMBER.get(numbers.get(_VERTICAL, 0)))
