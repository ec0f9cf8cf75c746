"""A renderer as what it is made of: world, eye and settings, from which it is made again."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from omma.base.values import check_format

if TYPE_CHECKING:
    from omma.rendering.renderer import Renderer

# Raised where what is pickled changes.
_FORMAT = 1


def parts_of(renderer: Renderer, threads: int) -> tuple[Callable[..., Renderer], tuple[Any, ...]]:
    """What ``Renderer.__reduce__`` returns; ``threads`` are as they were asked for."""
    state = {
        "format": _FORMAT,
        "world": renderer.world,
        "eye": renderer.eye,
        "settings": renderer.settings,
        "threads": threads,
    }
    return _made_again, (type(renderer), state)


def _made_again(kind: type[Renderer], state: dict[str, Any]) -> Renderer:
    check_format(state["format"], _FORMAT, "Renderer")
    settings = state["settings"]
    return kind(
        state["world"],
        state["eye"],
        settings.sampling,
        threads=state["threads"],
        **settings.options(),
    )
