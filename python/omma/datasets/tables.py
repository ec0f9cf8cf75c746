"""Tables of a TOML file, read with checks: what is wrong is named by its place in the file."""

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

    def __init__(self, values: Any, place: str) -> None:
        if not isinstance(values, Mapping):
            raise Error(f"{place}: expected a table, found {values!r:.60}")
        self.place = place
        self._values = dict(values)
        self._known: list[str] = []

    def take(self, key: str, read: Callable[[Any, str], T], default: Any = _MISSING) -> T:
        """The value of a key as ``read(value, place)`` gives it; ``default`` where it is not there.

        Raises:
            omma.Error: it is missing and has no default, or ``read`` refuses it.
        """
        self._known.append(key)
        where = f"{self.place}.{key}"
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
            one_of(key, self._known, self.place)


def tables(values: Any, place: str) -> list[Table]:
    """An array of tables."""
    if not isinstance(values, list) or not values:
        raise Error(f"{place}: expected one or more tables [[{place.rsplit('.')[-1]}]]")
    return [Table(one, f"{place}[{k}]") for k, one in enumerate(values)]


def text(value: Any, place: str) -> str:
    """A text that is not empty."""
    if not isinstance(value, str) or not value:
        raise Error(f"{place}: expected a text, found {value!r:.60}")
    return value


def texts(value: Any, place: str) -> tuple[str, ...]:
    """One text or several."""
    several = [value] if isinstance(value, str) else value
    if not isinstance(several, list) or not several:
        raise Error(f"{place}: expected one text or more, found {value!r:.60}")
    return tuple(text(one, place) for one in several)


def name(value: Any, place: str) -> str:
    """A name that does for groups and files: letters, digits, _ and -."""
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise Error(f"{place}: expected a name of letters, digits, _ and -, found {value!r:.60}")
    return value


def count(value: Any, place: str) -> int:
    """A whole number from 1 on."""
    if isinstance(value, bool):
        raise Error(f"{place}: expected a whole number, found {value}")
    return whole(value, place, 1, 1 << 40)


def number_above_0(value: Any, place: str) -> float:
    """A finite number above 0."""
    return positive(value, place)


def numbers(length: int) -> Callable[[Any, str], tuple[float, ...]]:
    """Reads so many finite numbers."""

    def read(value: Any, place: str) -> tuple[float, ...]:
        found: NDArray[np.float64] = array_of(value, place, (length,))
        if not np.isfinite(found).all():
            raise Error(f"{place}: expected finite numbers, found {value!r:.60}")
        return tuple(found.tolist())

    return read


def span(value: Any, place: str) -> tuple[float, float]:
    """A range: [low, high], or one number for both."""
    both = value if isinstance(value, list) else [value, value]
    low, high = numbers(2)(both, place)
    if low > high:
        raise Error(f"{place}: expected [low, high], found {value!r:.60}")
    return low, high


def choices(known: Sequence[str]) -> Callable[[Any, str], str]:
    """Reads one of these texts."""
    return lambda value, place: one_of(value, known, place)


def check_unlike(names: Sequence[str], place: str) -> None:
    """omma.Error where two have one name."""
    for k, one in enumerate(names):
        if one in names[:k]:
            raise Error(f"{place}: expected names that differ, found {one!r} twice")
