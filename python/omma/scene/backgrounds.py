"""Backgrounds from text, as the command line takes them."""

from __future__ import annotations

from pathlib import Path

from omma._core import Background, Error


def parse_background(text: str) -> Background:
    """A background from text: "R,G,B" (linear radiance), "simple_sky", "test_pattern", or the name
    of an equirectangular image file.

    Raises:
        omma.Error: it is none of these.
    """
    if text in ("simple_sky", "test_pattern"):
        return Background.simple_sky() if text == "simple_sky" else Background.test_pattern()
    if text.count(",") == 2 and not Path(text).exists():
        try:
            return Background.constant([float(part) for part in text.split(",")])
        except ValueError:
            raise Error(f"background: expected three numbers R,G,B, found '{text}'") from None
    if not Path(text).exists():
        raise Error(
            "background: expected R,G,B or simple_sky or test_pattern or an image file, "
            f"found '{text}'"
        )
    return Background.image(text)
