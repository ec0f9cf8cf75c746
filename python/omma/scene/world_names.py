"""What things of a world are called, for arguments that name some."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

from omma._core import Error
from omma.scene.world import World

# Names that a message lists.
_MOST_NAMED = 5


def names_in(world: World) -> list[str]:
    """Of instances, and behind these of clouds of splats."""
    names = [instance.name for instance in world.instances]
    return names + [cloud.name for cloud in world.scene.splats]


def check_named(names: Sequence[str], name: str, argument: str) -> None:
    """omma.Error where none of the names (`names_in`) is this one, with what nearly is."""
    if name in names:
        return
    alike = difflib.get_close_matches(str(name), dict.fromkeys(names), _MOST_NAMED, 0.0)
    near = ", ".join(repr(one) for one in alike)
    there = f"nearest to it are {near}" if near else "the scene is empty"
    raise Error(f"{argument}: expected the name of a thing in the world, found {name!r}; {there}")


def index_of(world: World, name: str, argument: str) -> int:
    """`World.index`, of which an error names the argument where nothing is called so."""
    try:
        return world.index(name)
    except Error:
        check_named(names_in(world), name, argument)
        raise
