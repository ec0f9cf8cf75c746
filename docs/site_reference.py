"""The site's reference, made from the package itself: a page for each subpackage with every public
name, the command line's help, and the C++ headers. For docs/make_site.py."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

import typer
from site_docstrings import linked, subpackages


def first_sentence(text: str | None) -> str:
    """Of a docstring, in one line."""
    paragraphs = (text or "").strip().split("\n\n")
    # The compiled part's docstrings begin with a signature.
    paragraph = paragraphs[1] if "->" in paragraphs[0] and len(paragraphs) > 1 else paragraphs[0]
    line = " ".join(paragraph.split())
    return re.split(r"(?<=[.])\s", line)[0]


def public(subpackage: Any) -> dict[str, list[str]]:
    """What a subpackage has: names of classes, of functions and of other things."""
    kinds: dict[str, list[str]] = {"Classes": [], "Functions": [], "Constants": []}
    for name in subpackage.__all__:
        thing = getattr(subpackage, name)
        if inspect.ismodule(thing):
            continue
        kind = "Classes" if inspect.isclass(thing) else "Functions"
        kinds[kind if callable(thing) else "Constants"].append(name)
    return {kind: names for kind, names in kinds.items() if names}


def members(cls: Any) -> list[tuple[str, str]]:
    """(directive, name) of what belongs to a class and is public."""
    found = []
    for one in reversed(cls.__mro__):
        if not one.__module__.startswith("omma"):
            continue
        for name, value in vars(one).items():
            if name.startswith("_"):
                continue
            kind = type(value).__name__
            if isinstance(value, property):
                found.append(("autoproperty", name))
            elif callable(value) or kind in ("classmethod", "staticmethod"):
                found.append(("automethod", name))
            elif name not in getattr(cls, "__dataclass_fields__", {}):
                found.append(("autoattribute", name))
    return list(dict.fromkeys(found))


def entry(full: str, thing: Any) -> list[str]:
    """The directives for one public thing."""
    if inspect.isclass(thing):
        lines = [f".. autoclass:: {full}", ""]
        for directive, name in members(thing):
            lines += [f"   .. {directive}:: {full}.{name}", ""]
        return lines
    if callable(thing):
        return [f".. autofunction:: {full}", ""]
    subpackage, name = full.rsplit(".", 1)
    return [f".. py:data:: {name}", f"   :module: {subpackage}", "", f"   ``{thing!r}``", ""]


def subpackage_page(full: str, subpackage: Any) -> str:
    """A subpackage's page, reStructuredText, as docstrings are."""
    lines = [full, "=" * len(full), "", f".. automodule:: {full}", "   :no-members:", ""]
    kinds = public(subpackage)
    for kind, names in kinds.items():
        lines += [f"{kind} of {full}", "-" * (len(kind) + 4 + len(full)), ""]
        lines += [".. list-table::", "   :widths: 30 70", "   :class: names", ""]
        for name in names:
            thing = getattr(subpackage, name)
            said = first_sentence(thing.__doc__) if callable(thing) else ""
            said = re.sub(r"(?<!`)`([^`]+)`(?!`)", linked, said).replace("|", "\\|")
            lines += [f"   * - :py:obj:`{name} <{full}.{name}>`", f"     - {said}"]
        lines += [""]
        for name in names:
            lines += entry(f"{full}.{name}", getattr(subpackage, name))
    return "\n".join(lines) + "\n"


def headers_page(root: Path) -> str:
    """The C++ headers, each with what its opening comment says."""
    lines = [
        "# C++",
        "",
        "The engine's public headers are in `include/omma` of the repository; each says in its",
        "comments what shapes, units and errors there are. `#include <omma/omma.h>` is them all.",
        "`examples/cpp` is a worked project that uses the installed CMake package",
        "(`find_package(omma)`, target `omma::omma`).",
        "",
        "| header | what it says of itself |",
        "| --- | --- |",
    ]
    for header in sorted((root / "include" / "omma").glob("*.h")):
        comment = re.match(r"(?://[^\n]*\n)+", header.read_text(encoding="utf-8"))
        text = " ".join(line[2:].strip() for line in comment[0].splitlines()) if comment else ""
        said = re.split(r"(?<=\.)\s", text)[0].replace("|", "\\|").replace("<", "\\<")
        lines.append(f"| `omma/{header.name}` | {said} |")
    return "\n".join(lines) + "\n"


def option_rows(command: Any, context: Any) -> list[str]:
    """A table of a command's arguments and options."""
    rows = []
    for parameter in command.get_params(context):
        if getattr(parameter, "hidden", False) or parameter.name == "help":
            continue
        names = ", ".join(f"`{name}`" for name in (*parameter.opts, *parameter.secondary_opts))
        if parameter.param_type_name == "argument":
            names = f"`{(parameter.metavar or parameter.name).upper()}`"
        said = " ".join((getattr(parameter, "help", "") or "").split()).replace("|", "\\|")
        rows.append(f"| {names} | {said} |")
    return ["| argument, option | what it does |", "| --- | --- |", *rows, ""] if rows else []


def help_text(text: str) -> str:
    """A command's help, Markdown, with paragraphs that are a command alone as blocks."""
    paragraphs = inspect.cleandoc(text).split("\n\n")
    for i, one in enumerate(paragraphs):
        if re.fullmatch(r"`[^`]+`", one):
            paragraphs[i] = "```bash\n" + one.strip("`").replace("\n", " \\\n    ") + "\n```"
    return "\n\n".join(paragraphs)


def command_section(command: Any, name: str, level: int) -> list[str]:
    """A command's help and, below it, those of its own commands."""
    if hasattr(command, "load"):
        command = command.load()
    context = command.context_class(command, info_name=name.split(" ", 1)[-1])
    usage = " ".join(command.collect_usage_pieces(context))
    lines = [f"{'#' * level} {name}", "", f"    {name} {usage}", ""]
    lines += [help_text(command.help or ""), "", *option_rows(command, context)]
    for inner in getattr(command, "commands", {}):
        lines += command_section(command.commands[inner], f"{name} {inner}", level + 1)
    return lines


def command_line_page() -> str:
    """`omma --help` and that of all commands."""
    from omma.cli.main import app

    return "\n".join(
        ["# Command line", ""] + command_section(typer.main.get_command(app), "omma", 2)
    )


def reference_pages(root: Path) -> dict[str, str]:
    """All pages of the reference, by their place in the site."""
    pages = {
        f"reference/{full}.rst": subpackage_page(full, subpackage)
        for full, subpackage in subpackages().items()
    }
    pages["reference/command-line.md"] = command_line_page()
    pages["reference/cpp.md"] = headers_page(root)
    lines = [
        "# Reference",
        "",
        "Every public name, by the subpackage it is in: what it takes and gives, with shapes,",
        "units and the errors that it raises; every command with its options; the C++ headers.",
        "Without the site the same is in `help(omma)`, `help(omma.eye)` and so on, and in",
        "`omma --help`.",
        "",
        "`import omma` has what a first hour needs; subpackages are loaded when first used.",
        "",
    ]
    for full, subpackage in subpackages().items():
        count = sum(len(names) for names in public(subpackage).values())
        lines.append(
            f"- [{full}](reference/{full}.rst): {first_sentence(subpackage.__doc__)} {count} names."
        )
    lines += [
        "- [Command line](reference/command-line.md): every command and option of `omma`.",
        "- [C++](reference/cpp.md): the engine's headers.",
        "- [Conventions](CONVENTIONS.md): the quantity, frames, units and names, on one page.",
        "",
        "```{toctree}",
        ":hidden:",
        "",
        *(f"reference/{full}" for full in subpackages()),
        "reference/command-line",
        "reference/cpp",
        "```",
    ]
    pages["reference.md"] = "\n".join(lines) + "\n"
    return pages
