"""How commands declare arguments and options: what help says of them, and what stands there for the
value."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

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


def keeping_inputs(command: Callable[..., Any]) -> Callable[..., Any]:
    """The same command, which ends with omma.Error where it is to write a file that it reads."""
    parameters = inspect.signature(command, eval_str=True).parameters.values()
    outputs = {one.name for one in parameters if _is_output(one.annotation)}
    if not outputs:
        return command

    @functools.wraps(command)
    def checked(**given: Any) -> Any:
        # Here, as it needs NumPy, which help does not.
        from omma.base.files import check_kept

        written: list[str] = []
        read: list[Path] = []
        for name, value in given.items():
            several = value if isinstance(value, (list, tuple)) else [value]
            if name in outputs:
                written += [str(one) for one in several if one is not None]
            else:
                read += [one for one in several if isinstance(one, Path)]
        check_kept(written, read)
        return command(**given)

    return checked


def _is_output(annotation: Any) -> bool:
    """Whether a parameter names a file or folder to write."""
    return any(
        getattr(one, "metavar", None) == "OUT" or "-o" in (getattr(one, "param_decls", None) or ())
        for one in get_args(annotation)[1:]
    )
