"""Tables of a TOML file, read with checks: what is wrong is named by its where in the file."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import array_of, one_of, positive, whole

T = TypeVar("T")

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")
_MISSING = object()


class Table:
    """One table: its values are taken one by one, and `end` says what nobody took."""

    def __init__(self, values: Any, where: str) -> None:
        if not isinstance(values, Mapping):
            raise Error(f"{where}: expected a table, found {values!r:.60}")
        self.where = where
        self._values = dict(values)
        self._known: dict[str, None] = {}  # in their order, each once

    def take(self, key: str, read: Callable[[Any, str], T], default: Any = _MISSING) -> T:
        """The value of a key as ``read(value, where)`` gives it; ``default`` where it is not there.

        Raises:
            omma.Error: it is missing and has no default, or ``read`` refuses it.
        """
        self._known[key] = None
        where = f"{self.where}.{key}"
        if key not in self._values:
            if default is _MISSING:
                raise Error(f"{where}: expected a value, found none")
            return default  # type: ignore[no-any-return]
        try:
            return read(self._values.pop(key), where)
        except TypeError as error:
            raise Error(str(error)) from None

    def has(self, key: str) -> bool:
        """Whether there is such a key."""
        return key in self._values

    def rest(self) -> dict[str, Any]:
        """All that nobody has taken."""
        left, self._values = self._values, {}
        return left

    def end(self) -> None:
        """omma.Error where something is left that nobody has taken."""
        for key in self._values:
            one_of(key, self._known, self.where)


def tables(values: Any, where: str) -> list[Table]:
    """An array of tables."""
    if not isinstance(values, list) or not values:
        raise Error(f"{where}: expected one or more tables [[{where.rsplit('.')[-1]}]]")
    return [Table(one, f"{where}[{k}]") for k, one in enumerate(values)]


def text(value: Any, where: str) -> str:
    """A text that is not empty."""
    if not isinstance(value, str) or not value:
        raise Error(f"{where}: expected a text, found {value!r:.60}")
    return value


def texts(value: Any, where: str) -> tuple[str, ...]:
    """One text or several."""
    several = [value] if isinstance(value, str) else value
    if not isinstance(several, list) or not several:
        raise Error(f"{where}: expected one text or more, found {value!r:.60}")
    return tuple(text(one, where) for one in several)


def name(value: Any, where: str) -> str:
    """A name that does for groups and files: letters, digits, _ and -."""
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise Error(f"{where}: expected a name of letters, digits, _ and -, found {value!r:.60}")
    return value


def count(value: Any, where: str) -> int:
    """A whole number from 1 on."""
    if isinstance(value, bool):
        raise Error(f"{where}: expected a whole number, found {value}")
    return whole(value, where, 1, 1 << 40)


def number_above_0(value: Any, where: str) -> float:
    """A finite number above 0."""
    return positive(value, where)


def numbers(length: int) -> Callable[[Any, str], tuple[float, ...]]:
    """Reads so many finite numbers."""

    def read(value: Any, where: str) -> tuple[float, ...]:
        found: NDArray[np.float64] = array_of(value, where, (length,))
        if not np.isfinite(found).all():
            raise Error(f"{where}: expected finite numbers, found {value!r:.60}")
        return tuple(found.tolist())

    return read


def span(value: Any, where: str) -> tuple[float, float]:
    """A range: [low, high], or one number for both."""
    both = value if isinstance(value, list) else [value, value]
    low, high = numbers(2)(both, where)
    if low > high:
        raise Error(f"{where}: expected [low, high], found {value!r:.60}")
    return low, high


def choices(known: Sequence[str]) -> Callable[[Any, str], str]:
    """Reads one of these texts."""
    return lambda value, where: one_of(value, known, where)


def check_unlike(names: Sequence[str], where: str) -> None:
    """omma.Error where two have one name."""
    for k, one in enumerate(names):
        if one in names[:k]:
            raise Error(f"{where}: expected names that differ, found {one!r} twice")
