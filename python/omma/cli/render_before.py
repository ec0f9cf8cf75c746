"""Options of ``omma render`` that are commands of their own now and work until 0.2, with a
warning."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import typer

from omma.cli.help import Command
from omma.cli.render_again import again_app
from omma.cli.render_cameras import cameras_app
from omma.cli.working import warn


class RenderCommand(Command):
    """``omma render``, which hands ``--like FILE`` and ``--all-cameras`` on to their commands."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        """Of the command that is meant."""
        for at, word in enumerate(args):
            name = word.split("=")[0]
            if name == "--like":
                return _hand_on("--like", "render-again", again_app, parent, _file_first(args, at))
            if name == "--all-cameras":
                rest = [*args[:at], *args[at + 1 :]]
                return _hand_on("--all-cameras", "render-cameras", cameras_app, parent, rest)
        return super().make_context(info_name, args, parent, **extra)


def _hand_on(old: str, new: str, app: typer.Typer, parent: Any, args: list[str]) -> Any:
    warn(f"{old} is the command omma {new} now; the old option works until 0.2")
    command: Any = typer.main.get_command(app)
    return command.make_context(new, args, parent)


def _file_first(args: Sequence[str], at: int) -> list[str]:
    """What was typed, of which ``--like`` has this index, as `render-again` takes it: the file
    before the scene."""
    _, *file = args[at].split("=", 1)
    end = at + 1 if file else at + 2
    return [*(file or args[at + 1 : end]), *args[:at], *args[end:]]
