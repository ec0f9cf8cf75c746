"""Places in words: where a thing is, or from where to where."""

from __future__ import annotations

from collections.abc import Iterable

# Below it four digits say it; above, hundredths: places far from the origin, as in UTM, differ by
# less than their fourth digit.
_FAR_M = 100.0


def place_words(place_m: Iterable[float]) -> str:
    """(x, y, z), metres, to four digits and at least to the centimetre."""
    return "(" + ", ".join(_metres(float(one)) for one in place_m) + ")"


def _metres(value: float) -> str:
    return f"{round(value, 2):.12g}" if abs(value) >= _FAR_M else f"{value:.4g}"
