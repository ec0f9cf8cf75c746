"""What files say of themselves, member by member: JSON objects and attributes, each of its type."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, NoReturn, TypeVar

from omma._core import Error

T = TypeVar("T")

_MISSING = object()
# No count or size in a file that Omma writes is larger.
_MOST = 1 << 53


def is_text(value: Any) -> bool:
    return isinstance(value, str)


def is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def is_count(value: Any) -> bool:
    """A whole number that is not negative."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= _MOST


def is_texts(value: Any) -> bool:
    """A list of texts, one at least."""
    return isinstance(value, list) and len(value) > 0 and all(map(is_text, value))


def is_span(value: Any) -> bool:
    """[first, stop], counts."""
    return is_list(value) and len(value) == 2 and all(map(is_count, value)) and value[0] <= value[1]


def is_list(value: Any) -> bool:
    return isinstance(value, list)


def is_object(value: Any) -> bool:
    return isinstance(value, dict)


def is_object_of_texts(value: Any) -> bool:
    """Names and texts."""
    return is_object(value) and all(map(is_text, value.values()))


_WORDS: dict[Callable[[Any], bool], str] = {
    is_text: "a text",
    is_number: "a number",
    is_count: "a whole number of at least 0",
    is_texts: "a list of texts",
    is_span: "[first, stop]",
    is_list: "a list",
    is_object: "an object",
    is_object_of_texts: "an object of texts",
}


class Said:
    """The members of an object in a file, taken one by one; ``where`` names file and object."""

    def __init__(self, values: Any, where: str) -> None:
        if not isinstance(values, Mapping):
            raise Error(f"{where}: expected an object, found {values!r:.60}")
        self.where = where
        self._values = values

    def take(self, name: str, is_right: Callable[[Any], bool], default: Any = _MISSING) -> Any:
        """The member of that name; ``default`` where it is not there.

        Raises:
            omma.Error: it is missing and has no default, or is something else.
        """
        value = self._values.get(name, default)
        if value is _MISSING:
            raise Error(f"{self.where}: {name}: is missing, expected {_WORDS[is_right]}")
        if value is not default and not is_right(value):
            self.refuse(name, _WORDS[is_right])
        return value

    def take_json(self, name: str, is_right: Callable[[Any], bool], default: Any = _MISSING) -> Any:
        """The same of a member that is JSON text."""
        text = self.take(name, is_text, default)
        if text is default:
            return default
        try:
            value = json.loads(text)
        except (ValueError, RecursionError):
            self.refuse(name, "JSON")
        if not is_right(value):
            self.refuse(name, f"JSON of {_WORDS[is_right]}")
        return value

    def refuse(self, name: str, expected: str) -> NoReturn:
        """omma.Error that a member is something else than what is expected."""
        raise Error(f"{self.where}: {name}: expected {expected}, found {self._values[name]!r:.60}")


def object_in(data: bytes, where: str, what: str) -> Said:
    """The JSON object that a file is.

    Raises:
        omma.Error: it is none; ``what`` says what was expected.
    """
    try:
        return Said(json.loads(data), where)
    except (ValueError, RecursionError, Error):
        raise Error(f"{where}: expected {what}, found something else") from None
