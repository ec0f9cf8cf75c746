"""Backgrounds from text, as the command line takes them."""

from __future__ import annotations

from pathlib import Path

from omma._core import Background, Error

NAMED_BACKGROUNDS = {
    "simple_sky": Background.simple_sky,
    "test_pattern": Background.test_pattern,
}


def parse_background(text: str) -> Background:
    """A background from text: "R,G,B" (linear radiance), one of `NAMED_BACKGROUNDS`, or the name of
    an equirectangular image file, which is turned as its EXIF says.

    Raises:
        omma.Error: it is none of these.
    """
    if text in NAMED_BACKGROUNDS:
        return NAMED_BACKGROUNDS[text]()
    if text.count(",") == 2 and not Path(text).exists():
        try:
            return Background.constant([float(part) for part in text.split(",")])
        except ValueError:
            raise Error(f"background: expected three numbers R,G,B, found '{text}'") from None
    if not Path(text).exists():
        raise Error(
            f"background: expected R,G,B or {' or '.join(NAMED_BACKGROUNDS)} or an image file, "
            f"found '{text}'"
        )
    return Background.image(text)
