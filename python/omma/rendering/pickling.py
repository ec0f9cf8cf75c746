"""A renderer as what it is made of: world, eye and settings, from which it is made again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from omma.base.values import check_format
from omma.rendering.call import Prepared

P = TypeVar("P", bound=Prepared)
# Raised where what is pickled changes.
_FORMAT = 1


def parts_of(renderer: P, threads: int) -> tuple[Callable[..., P], tuple[Any, ...]]:
    """What ``Renderer.__reduce__`` returns; ``threads`` are as they were asked for."""
    state = {
        "format": _FORMAT,
        "world": renderer.world,
        "eye": renderer.eye,
        "settings": renderer.settings,
        "threads": threads,
    }
    return _made_again, (type(renderer), state)


def _made_again(kind: Callable[..., P], state: dict[str, Any]) -> P:
    check_format(state["format"], _FORMAT, "Renderer")
    settings = state["settings"]
    return kind(
        state["world"],
        state["eye"],
        settings.sampling,
        threads=state["threads"],
        **settings.options(),
    )
