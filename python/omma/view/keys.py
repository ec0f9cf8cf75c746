"""The keys of the page: one table, from which its scripts and its list of keys are made."""

from __future__ import annotations

import json
from dataclasses import dataclass


@dataclass(frozen=True)
class Key:
    """keys: as browsers name them (``KeyboardEvent.key``, letters small); shown: on the list;
    does: what `Hands` or the page's scripts know it as; repeats: while it is held."""

    keys: tuple[str, ...]
    shown: str
    does: str
    says: str
    repeats: bool = False


KEYS = (
    Key(("v",), "V", "layout", "the picture fills the page, then stands beside the scene, then in "
        "the panel"),
    Key(("f",), "F", "fly", "fly, and stop"),
    Key((".",), ".", "faster", "fly faster", True),
    Key((",",), ",", "slower", "fly slower", True),
    Key(("c",), "C", "next_camera", "to the scene's next camera"),
    Key(("Shift+c",), "Shift C", "previous_camera", "to the one before"),
    Key(("+", "PageUp"), "+  Page Up", "more_rays", "twice as many rays"),
    Key(("-", "PageDown"), "−  Page Down", "fewer_rays", "half as many rays"),
    Key(("p",), "P", "save", "save the picture (PNG)"),
    Key(("i",), "I", "step_ahead", "a step ahead", True),
    Key(("k",), "K", "step_back", "a step back", True),
    Key(("j",), "J", "step_left", "a step to the left", True),
    Key(("l",), "L", "step_right", "a step to the right", True),
    Key(("u",), "U", "step_up", "a step up", True),
    Key(("o",), "O", "step_down", "a step down", True),
    Key(("n",), "N", "turn_left", "turn left by 3°", True),
    Key(("m",), "M", "turn_right", "turn right by 3°", True),
    Key(("h", "?"), "H  ?", "help", "this list"),
    Key(("Escape",), "Esc", "leave", "close this list, stop flying, leave the full page"),
)  # fmt: skip

#: What is done otherwise than by one key.
MORE = (
    ("flying: W A S D", "ahead, left, back, right"),
    ("flying: Q E", "down, up"),
    ("flying: mouse, arrows", "look round"),
    ("flying: wheel", "faster, slower"),
    ("not flying: W A S D Q E, arrows, mouse", "the camera of the scene on this page"),
    ("click on the picture", "pick the ommatidium"),
    ("drag the picture", "turn the head"),
)


def page_settings() -> str:
    """JSON of what the page's scripts need to know."""
    keys = [{"keys": one.keys, "does": one.does, "repeats": one.repeats} for one in KEYS]
    listed = [*((one.shown, one.says) for one in KEYS), *MORE]
    return json.dumps({"keys": keys, "help": listed})
