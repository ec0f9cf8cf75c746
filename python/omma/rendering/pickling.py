"""A renderer as what it is made of: world, eye and settings, from which it is made again."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from omma.base.values import check_format

if TYPE_CHECKING:
    from omma.rendering.renderer import Renderer

# Raised where what is pickled changes.
_FORMAT = 1
_NAMES = (
    "samples", "error", "max_samples", "seed", "kernel", "sampling", "footprints", "share_rays",
    "noise",
)  # fmt: skip


def options_of(renderer: Renderer) -> dict[str, Any]:
    """The arguments that make the renderer, besides world and eye, as they were asked for."""
    return {name: getattr(renderer, name) for name in _NAMES} | {
        "min_samples": renderer._min_samples,
        "threads": renderer._asked_threads,
    }


def parts_of(renderer: Renderer) -> tuple[Callable[..., Renderer], tuple[Any, ...]]:
    """What ``Renderer.__reduce__`` returns."""
    state = {
        "format": _FORMAT,
        "world": renderer.world,
        "eye": renderer.eye,
        "options": options_of(renderer),
    }
    return _made_again, (type(renderer), state)


def _made_again(kind: type[Renderer], state: dict[str, Any]) -> Renderer:
    check_format(state["format"], _FORMAT, "Renderer")
    return kind(state["world"], state["eye"], **state["options"])
