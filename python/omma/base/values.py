"""Results and settings as values: compared, hashed, pickled and printed in one way."""

from __future__ import annotations

import dataclasses
from typing import Any, TypeVar

import numpy as np

from omma._core import Error
from omma.base.notebook import html_table

T = TypeVar("T")

# Limits of a repr: characters in all, of one text and of anything else, and items of a sequence.
_REPR, _TEXT, _THING, _ITEMS = 200, 40, 80, 3
# Of arrays that a repr in full spells out.
_NUMBERS = 16


def value_class(cls: type[T]) -> type[T]:
    """A frozen dataclass, made with ``eq=False, repr=False``, as a value, though it holds arrays.

    Equal is what has the same type and the same fields, element by element; NaN equals NaN. What
    holds an array, a list or a dictionary has no hash. A pickle of a version with other fields is
    refused. The repr is a line, unless the class has its own or inherits one.
    """
    methods = {
        "__eq__": _equal,
        "__hash__": _hash,
        "__getstate__": _state,
        "__setstate__": _set_state,
        "__repr__": _line,
    }
    for name, method in methods.items():
        if name != "__repr__" or cls.__repr__ is object.__repr__:
            setattr(cls, name, method)
    return cls


def in_full(self: Any) -> str:
    """All fields of what is written down with an experiment, in a line, as a call that makes it
    again; of arrays of many numbers their type and shape."""
    fields = ", ".join(f"{name}={_whole(value)}" for name, value in _fields(self).items())
    return f"{type(self).__name__}({fields})"


def table_of_fields(self: Any, title: str) -> str:
    """What notebooks show of a value: a line for each field that is not None, arrays by their type
    and shape."""
    rows = {name: _short(value) for name, value in _fields(self).items() if value is not None}
    return html_table(title, rows)


def same(one: Any, other: Any) -> bool:
    """Whether two values are the same: arrays by their elements, and NaN is the same as NaN."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        numbers = one.dtype.kind in "fc" and other.dtype.kind in "fc"
        return bool(np.array_equal(one, other, equal_nan=numbers))
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return False
    if isinstance(one, (tuple, list)) and type(one) is type(other):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return bool(one == other or (one != one and other != other))


def check_format(found: object, expected: int, name: str) -> None:
    """omma.Error where a pickle of ``name`` has another format than this version's."""
    if found != expected:
        raise Error(
            f"pickle of {name}: expected format {expected}, found {found!r:.40}: it is of another "
            "version of Omma"
        )


def _fields(self: Any) -> dict[str, Any]:
    kept = vars(self)
    return {field.name: kept[field.name] for field in dataclasses.fields(self)}


def _equal(self: Any, other: object) -> Any:
    if type(self) is not type(other):
        return NotImplemented
    return same(_fields(self), _fields(other))


def _hash(self: Any) -> int:
    hashes = (_hashed(self, name, value) for name, value in _fields(self).items())
    return hash((type(self), *hashes))


def _hashed(self: Any, name: str, value: Any) -> int:
    if isinstance(value, tuple):
        return hash(tuple(_hashed(self, name, item) for item in value))
    if isinstance(value, float) and value != value:
        return 0  # one NaN equals another, but their own hashes differ
    try:
        return hash(value)
    except TypeError:
        owner, kind = type(self).__name__, type(value).__name__
        raise TypeError(
            f"{owner}: has no hash, as its field {name} holds what can change ({kind})"
        ) from None


def _state(self: Any) -> dict[str, Any]:
    # Fields only: cached values are computed again.
    return _fields(self)


def _set_state(self: Any, state: dict[str, Any]) -> None:
    expected = [field.name for field in dataclasses.fields(self)]
    if set(state) != set(expected):
        raise Error(
            f"pickle of {type(self).__name__}: expected the fields {', '.join(expected)}, found "
            f"{', '.join(state)}: it is of another version of Omma"
        )
    vars(self).update(state)


def _line(self: Any) -> str:
    """Its fields in one line, arrays by their type and shape; fields at their default left out."""
    text = ""
    kept = _fields(self)
    for field in dataclasses.fields(self):
        value = kept[field.name]
        if field.default is not dataclasses.MISSING and same(value, field.default):
            continue
        added = f"{', ' if text else ''}{field.name}={_short(value)}"
        if len(text) + len(added) > _REPR - len(type(self).__name__) - len("(, ...)"):
            text += ", ..."
            break
        text += added
    return f"{type(self).__name__}({text})"


def _whole(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return repr(value.tolist()) if value.size <= _NUMBERS else _short(value)
    return repr(value)


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"<{value.dtype} {value.shape}>"
    if isinstance(value, np.generic):
        return repr(value.item())
    if isinstance(value, str) and len(value) > _TEXT:
        return repr(value[: _TEXT - 3] + "...")
    if isinstance(value, (tuple, list)):
        items = [_short(item) for item in value[:_ITEMS]]
        if len(value) > _ITEMS:
            items.append(f"... {len(value)} in all")
        comma = "," if isinstance(value, tuple) and len(value) == 1 else ""
        return (
            f"({', '.join(items)}{comma})" if isinstance(value, tuple) else f"[{', '.join(items)}]"
        )
    text = repr(value)
    return text if len(text) <= _THING else f"<{type(value).__name__}>"
