"""How commands declare arguments and options: what help says of them, and what stands there for the
value."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import typer

Callback = Callable[[Any, Any], Any] | Callable[[Any], Any]


def argument(told: str, metavar: str) -> Any:
    """An argument, known by its place."""
    return typer.Argument(help=told, metavar=metavar)


def option(
    told: str, metavar: str | None = None, callback: Callback | None = None, name: str | None = None
) -> Any:
    """An option, by default of the parameter's name."""
    names = () if name is None else (name,)
    return typer.Option(*names, help=told, metavar=metavar, callback=callback)


def switch(name: str, told: str) -> Any:
    """An option that takes no word behind it."""
    return typer.Option(name, help=told)


def out(told: str, metavar: str = "OUT", callback: Callback | None = None) -> Any:
    """The option ``-o``, ``--output``."""
    return typer.Option("-o", "--output", help=told, metavar=metavar, callback=callback)
