"""Arguments, fields and public names under their old names, which work for one more version with a
warning."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable, Iterable
from typing import Any, TypeVar, cast

from omma.base.warn import warn_caller

F = TypeVar("F", bound=Callable[..., Any])
C = TypeVar("C", bound=type)


def renamed_arguments(**new_names: str) -> Callable[[F], F]:
    """A decorator: the same function, which takes old names of arguments too.

    Args:
        new_names: the new name of each old one.
    """

    def decorate(function: F) -> F:
        @functools.wraps(function)
        def with_old_names(*arguments: Any, **named: Any) -> Any:
            for old, new in new_names.items():
                if old in named:
                    _warn(old, new)
                    if new in named:
                        raise TypeError(f"{new}: given twice, as {old} too")
                    named[new] = named.pop(old)
            return function(*arguments, **named)

        return cast(F, with_old_names)

    return decorate


def renamed_fields(**new_names: str) -> Callable[[C], C]:
    """A decorator: the same dataclass, whose fields can be given and read by old names too.

    Args:
        new_names: the new name of each old one.
    """

    def decorate(cls: C) -> C:
        initialise: Any = cls.__init__  # type: ignore[misc]
        cls.__init__ = renamed_arguments(**new_names)(initialise)  # type: ignore[misc]
        for old, new in new_names.items():
            told = f"The old name of `{new}`, with a warning."
            setattr(cls, old, property(functools.partial(_read, old, new), doc=told))
        return cls

    return decorate


def moved_names(
    getter: Callable[[str], Any], package: str, **moved: Iterable[str]
) -> Callable[[str], Any]:
    """The ``__getattr__`` of a package, which gives names that have moved to its submodules too.

    Args:
        getter: the one without them.
        moved: the names by the submodule that they are in.
    """
    homes = {name: f"{package}.{module}" for module, names in moved.items() for name in names}

    def get(name: str) -> Any:
        if name not in homes:
            return getter(name)
        _warn(f"{package}.{name}", f"{homes[name]}.{name}")
        return getattr(importlib.import_module(homes[name]), name)

    return get


def _read(old: str, new: str, value: Any) -> Any:
    _warn(old, new)
    return getattr(value, new)


def _warn(old: str, new: str) -> None:
    warn_caller(f"{old}: is called {new} now; the old name works until 0.2", DeprecationWarning)
