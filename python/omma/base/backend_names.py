"""What a backend's name says of responses."""

from __future__ import annotations

import re


def without_ordinals(backend: str) -> str:
    """What of a backend's name responses depend on: of cards the kinds, not which and how many."""
    parts = re.split(r", (?=cuda:\d)", backend)
    return ", ".join(sorted({re.sub(r"^cuda:\d+", "cuda", part) for part in parts}))
