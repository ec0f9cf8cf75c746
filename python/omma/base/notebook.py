"""What notebooks show of a value."""

from __future__ import annotations

import html
import os
from collections.abc import Mapping


def without_folder(text: str, path: str) -> str:
    """Text with a file shown by its name alone: what notebooks show is seen on other machines."""
    return text.replace(path, os.path.basename(path)) if path else text


def html_table(title: str, rows: Mapping[str, str]) -> str:
    """A small HTML table with a title, and a line for each name and its text, if it has any."""
    lines = "".join(
        f"<tr><th style='text-align:left'>{html.escape(name)}</th>"
        f"<td style='text-align:left'>{html.escape(text)}</td></tr>"
        for name, text in rows.items()
        if text
    )
    return f"<div><b>{html.escape(title)}</b></div><table>{lines}</table>"
