"""Contrasts without colour, of one receptor class, such as the green one by which bees see motion
and small things."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats
from omma.colour_vision.catches import pair_of


@checked
def weber_contrast(target: ArrayLike, background: ArrayLike) -> Floats:
    """(Q_T - Q_B) / Q_B: (...), -1 to any size; of small things before a large background.

    Args:
        target, background: (...), catches of one receptor class.

    Example:
        >>> float(omma.colour_vision.weber_contrast(3.0, 2.0))
        0.5

    Raises:
        omma.Error: catches that are negative or not finite, a background of 0, or shapes that do
            not go together.
    """
    seen, behind = _pair(target, background)
    if not np.all(behind > 0):
        raise Error("background: expected numbers above 0, found 0")
    with np.errstate(over="ignore"):
        return np.asarray(seen / behind - 1)


@checked
def michelson_contrast(target: ArrayLike, background: ArrayLike) -> Floats:
    """(Q_T - Q_B) / (Q_T + Q_B): (...), -1 to 1; of things that are as large as what is between
    them. Where both are 0 it is 0.

    Args:
        target, background: (...), catches of one receptor class.

    Example:
        >>> float(omma.colour_vision.michelson_contrast(3.0, 1.0))
        0.5

    Raises:
        omma.Error: catches that are negative or not finite, or shapes that do not go together.
    """
    seen, behind = _pair(target, background)
    total = seen + behind
    return np.asarray((seen - behind) / np.where(total > 0, total, 1.0))


def _pair(target: ArrayLike, background: ArrayLike) -> tuple[Floats, Floats]:
    names = ("target", "background")
    both = [array_of(value, name)[..., None] for value, name in zip((target, background), names)]
    seen, behind = pair_of(both[0], both[1], names)
    return seen[..., 0], behind[..., 0]
