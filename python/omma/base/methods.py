"""Methods that stand in modules of their own, beside the class that lists them."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


def method_of(module: str, class_name: str) -> Callable[[F], F]:
    """A decorator: the same function, known in messages, help and pickles as the method that it is
    of a class of that module."""

    def decorate(function: F) -> F:
        signature = inspect.signature(function)
        own, *others = signature.parameters.values()
        parameters = [own.replace(annotation=inspect.Parameter.empty), *others]
        returned = signature.return_annotation
        function.__signature__ = signature.replace(  # type: ignore[attr-defined]
            parameters=parameters,
            return_annotation=class_name if returned == own.annotation else returned,
        )
        function.__qualname__ = f"{class_name}.{function.__name__}"
        function.__module__ = module
        return function

    return decorate
