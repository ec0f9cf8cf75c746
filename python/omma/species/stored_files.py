"""The files in which eyes of animals are kept (stored.py)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

_FOLDER = Path(__file__).parent / "data"


def open_stored(name: str) -> Any:
    """The arrays of an animal, read where they are asked for."""
    return np.load(_FOLDER / f"{name}.npz")


def stored_receptors(name: str) -> list[str]:
    """Names of an animal's types of receptors."""
    with open_stored(name) as arrays:
        names: list[str] = arrays["receptor_name"].tolist()
    return names
