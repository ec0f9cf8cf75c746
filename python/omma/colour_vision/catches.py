"""What all models of colours take: catches (..., receptor class), checked, and adapted to a
background.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats

# Of a catch: far more than there are, and its square is a number still.
MOST = 1e100


def as_catches(
    value: ArrayLike, name: str, classes: int | None = None, *, above_zero: bool = False
) -> Floats:
    """Finite numbers (..., classes) from 0 on; omma.Error names the argument."""
    catches = array_of(value, name)
    found = catches.shape[-1] if catches.ndim else 0
    if found == 0 or found != (classes or found):
        wanted = "receptor classes" if classes is None else str(classes)
        raise Error(f"{name}: expected shape (..., {wanted}), found {catches.shape}")
    if not np.all((catches >= 0) & (catches <= MOST)):
        raise Error(f"{name}: expected finite numbers from 0 on")
    if above_zero and not np.all(catches > 0):
        raise Error(f"{name}: expected numbers above 0, found {np.min(catches):g}")
    return catches


def pair_of(
    first: ArrayLike, second: ArrayLike, names: tuple[str, str], *, above_zero: bool = False
) -> tuple[Floats, Floats]:
    """Both, of as many classes and of shapes that go together."""
    one = as_catches(first, names[0], above_zero=above_zero)
    other = as_catches(second, names[1], one.shape[-1], above_zero=above_zero)
    try:
        one, other = np.broadcast_arrays(one, other)
    except ValueError:
        raise Error(
            f"{', '.join(names)}: expected shapes that go together, found {one.shape}, "
            f"{other.shape}"
        ) from None
    return one, other


def relative(value: ArrayLike, name: str, classes: int) -> Floats:
    """Catches as shares that add up to 1."""
    catches = as_catches(value, name, classes)
    total = catches.sum(axis=-1, keepdims=True)
    if not np.all((total > 0) & np.isfinite(total)):
        raise Error(f"{name}: expected a catch above 0 for each colour, and finite sums")
    return np.asarray(catches / total)


@checked
def von_kries(catches: ArrayLike, adapting: ArrayLike) -> Floats:
    """Catches of receptors that are adapted: each class divided by what it catches of the
    background, or of white in the light that there is. The background itself becomes 1.

    Von Kries' rule as in Vorobyev & Osorio 1998, Proc R Soc B 265:351, and Chittka 1992, J Comp
    Physiol A 170:533.

    Args:
        catches: (..., N), of N receptor classes.
        adapting: (N,) or a shape that goes with ``catches``, in the same unit; above 0.

    Returns:
        Of the shape of both.

    Example:
        >>> omma.colour_vision.von_kries([10.0, 50.0, 90.0], [20.0, 50.0, 60.0]).tolist()
        [0.5, 1.0, 1.5]

    Raises:
        omma.Error: catches that are negative or not finite, or shapes that do not go together.
    """
    seen, by = pair_of(catches, adapting, ("catches", "adapting"))
    as_catches(adapting, "adapting", above_zero=True)
    with np.errstate(over="ignore"):
        return np.asarray(seen / by)
