"""Docstrings as Sphinx wants them, for docs/conf.py: they are written to be read as they are.

Names between single backquotes become links where they are public, lines `name: what it is` of
values a list, indented lines of a subpackage's docstring code, and |x| stays |x|.
"""

from __future__ import annotations

import functools
import inspect
import re
from typing import Any

from site_moved import page_of

import omma

PAGE = re.compile(r"(?<!`)\bdocs/([\w-]+)\.md")
FIELD = re.compile(r"^(\*{0,2}\w+(?:, \*{0,2}\w+)*): ")


def subpackages(package: Any = omma, full: str = "omma") -> dict[str, Any]:
    """The package and its public subpackages and modules of these, by their full names."""
    found = {full: package}
    for name in package.__all__:
        if inspect.ismodule(getattr(package, name)):
            found |= subpackages(getattr(package, name), f"{full}.{name}")
    return found


@functools.cache
def places() -> dict[str, str]:
    """The full name of each public thing by what docstrings may call it: alone, where that is said
    of one thing only, and with its subpackage."""
    found: dict[str, str] = {}
    twice = set()
    for subpackage, module in subpackages().items():
        found[subpackage] = subpackage
        for name in module.__all__:
            full = f"{subpackage}.{name}"
            thing = getattr(module, name)
            if inspect.ismodule(thing):
                continue
            if name in found:
                twice.add(name)
            found[name] = found[full] = full
            for member in vars(thing) if inspect.isclass(thing) else ():
                if not member.startswith("_"):
                    found[f"{name}.{member}"] = found[f"{full}.{member}"] = f"{full}.{member}"
    return {name: full for name, full in found.items() if name not in twice}


def linked(match: re.Match[str]) -> str:
    """A name between single backquotes as a link, or else as code."""
    name = match[1]
    full = places().get(name.removesuffix("()"))
    return f":py:obj:`{name} <{full}>`" if full else f"``{name}``"


def as_list(block: list[str]) -> list[str]:
    """Lines `name: what it is`, with what goes on indented, as a list."""
    lines = []
    for line in block:
        field = FIELD.match(line)
        lines.append(f"* **{field[1]}**: {line[field.end() :]}" if field else f"  {line.strip()}")
    return lines


def is_fields(block: list[str]) -> bool:
    """Whether each line that is not indented begins with a name and a colon."""
    heads = [line for line in block if not line.startswith(" ")]
    return bool(heads) and len(heads[0]) < 101 and all(FIELD.match(line) for line in heads)


def rewrite(what: str, lines: list[str]) -> list[str]:
    """The lines of a docstring, as Sphinx (with napoleon) reads them."""
    blocks: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            blocks[-1].append(line)
        elif blocks[-1]:
            blocks.append([])
    out: list[str] = []
    for block in blocks:
        if len(block) > 2 and set(block[1]) == {"-"}:  # NumPy's heading, in the compiled part
            block = [
                f"**{block[0]}**",
                "",
                *as_list([one.replace(" : ", ": ") for one in block[2:]]),
            ]
        if what == "class" and is_fields(block) and len(block) > 1:
            block = as_list(block)
        if what == "module" and block and all(line.startswith("    ") for line in block):
            goes_on = len(out) > 1 and out[-2].startswith("    ")
            block = block if goes_on else [".. code-block:: python", "", *block]
        elif not any(">>>" in line for line in block):
            text = "\n".join(block)
            text = re.sub(r"(?<!`)`([^`<>\n]+)`(?!`)", linked, text)
            text = PAGE.sub(lambda page: f":doc:`docs/{page[1]}.md </{page_of(page[1])}>`", text)
            parts = re.split(r"(``.*?``)", text, flags=re.DOTALL)
            parts[::2] = [re.sub(r"\|", r"\\|", one) for one in parts[::2]]
            block = "".join(parts).split("\n")
        out += [*block, ""]
    return out


def docstring(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """For Sphinx's event autodoc-process-docstring."""
    lines[:] = rewrite(what, lines)
