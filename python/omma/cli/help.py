"""What ``--help`` prints: plain text in which no name is ever cut, with examples to be copied."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Sequence
from typing import Any

import typer
import typer.core

from omma.cli.parameters import keeping_inputs

# A word of a command, or several in quotes.
_WORD = re.compile(r"(?:'[^']*'|[^\s'])+")
# Names that are longer have a line of their own.
_LONGEST_NAME = 30


class App(typer.Typer):
    """A command or a group of commands whose help is that of this file."""

    def __init__(self, cls: type[Group] | None = None, **given: Any) -> None:
        super().__init__(cls=cls or Group, add_completion=False, rich_markup_mode=None, **given)

    def command(self, name: str | None = None, **given: Any) -> Callable[[Any], Any]:
        """As of typer, but the command does not write over what it reads."""
        register = super().command(name, **{"cls": Command, **given})

        def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
            register(keeping_inputs(function))
            return function

        return decorate


class Command(typer.core.TyperCommand):
    """A command with its help as text."""

    def format_help_text(self, ctx: Any, formatter: Any) -> None:
        """What the command is for, with its examples."""
        _write(self.help or "", formatter)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Its arguments and options."""
        _write_parameters(self.get_params(ctx), ctx, formatter)


class Group(typer.core.TyperGroup):
    """Commands below one name, with their help as text."""

    def format_help_text(self, ctx: Any, formatter: Any) -> None:
        """What the commands are for, with examples."""
        _write(self.help or "", formatter)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Their common options, and the commands."""
        _write_parameters(self.get_params(ctx), ctx, formatter)
        commands = [self.commands[name] for name in self.list_commands(ctx)]
        rows = [(one.name or "", one.short_help or one.help or "") for one in commands]
        _write_rows("Commands", rows, formatter)


def _write_parameters(parameters: Any, ctx: Any, formatter: Any) -> None:
    for title, kind in (("Arguments", "argument"), ("Options", "option")):
        rows = []
        for one in parameters:
            told = one.get_help_record(ctx) if one.param_type_name == kind else None
            if told is not None:
                # Some versions of typer escape brackets, for rich.
                name = one.metavar if kind == "argument" else told[0]
                rows.append((name, told[1].replace("\\[", "[")))
        if rows:
            _write_rows(title, rows, formatter)


def _write_rows(title: str, rows: Sequence[tuple[str, str]], formatter: Any) -> None:
    """Names and what is said of each, in two columns."""
    wide = min(max(len(name) for name, _ in rows), _LONGEST_NAME)
    formatter.write(f"\n{title}:\n")
    for name, told in rows:
        lines = _wrapped(told, formatter.width - wide - 4)
        if len(name) > wide:
            formatter.write(f"  {name}\n")
            name = ""
        for line in lines:
            formatter.write(f"  {name:<{wide}}  {line}\n")
            name = ""


def _write(text: str, formatter: Any) -> None:
    """Markdown of paragraphs; those that are a command alone as lines that a shell takes."""
    for paragraph in text.strip().split("\n\n"):
        if re.fullmatch(r"`[^`]+`", paragraph):
            lines = [
                f"  {line}" for line in command_lines(paragraph.strip("`"), formatter.width - 4)
            ]
        else:
            paragraph = re.sub(r"^\*\*(.*)\*\*$", r"\1:", paragraph)
            lines = _wrapped(re.sub(r"\*\*|`", "", paragraph), formatter.width - 2)
        formatter.write("\n" + "".join(f"  {line}\n" for line in lines))


def _wrapped(text: str, width: int) -> list[str]:
    # Names of options have hyphens, at which they are not broken.
    return textwrap.wrap(text, width, break_on_hyphens=False)


def command_lines(command: str, width: int) -> list[str]:
    """A command on lines of at most so many characters where that is possible, broken before
    options, with what tells a shell that it goes on."""
    parts: list[str] = []
    for word in _WORD.findall(command):
        if parts and not word.startswith("-"):
            parts[-1] += f" {word}"
        else:
            parts.append(word)
    lines = parts[:1]
    for part in parts[1:]:
        # Two more for " \".
        if len(lines[-1]) + 1 + len(part) + 2 > width:
            lines[-1] += " \\"
            lines.append(f"  {part}")
        else:
            lines[-1] += f" {part}"
    return lines
