"""The word that a loaded scene is made for light, told where it is seen without: once a session."""

from __future__ import annotations

from omma._core import Scene
from omma.base.warn import warn_caller

# How the loader's sentence about what only a light shows begins.
WITHOUT_LIGHT = "without a light "
# Files that `load_scene` has read whose sentence has not been told, and what was told.
_loaded: set[str] = set()
_told: list[str] = []


def is_of_light(sentence: str) -> bool:
    """Whether one of `Scene.warnings` is that sentence, which a world with light makes untrue."""
    return sentence.startswith(WITHOUT_LIGHT)


def remember_loaded(scene: Scene) -> None:
    """Of a scene for whose warnings nobody else cares."""
    if any(map(is_of_light, scene.warnings)):
        _loaded.add(scene.path)


def tell_without_light(scene: Scene) -> None:
    """Warns of a world without light, where such a file was loaded."""
    if _told or scene.path not in _loaded:
        return
    sentence = next(filter(is_of_light, scene.warnings), None)
    if sentence is None:
        return
    warn_caller(f"{scene.path}: {sentence}", UserWarning)
    # Where warnings are errors it is not told before somebody lets it pass.
    _told.append(sentence)
