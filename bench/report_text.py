"""Markdown of RESULTS.md: tables and paragraphs."""

from __future__ import annotations

import textwrap


def table(head: str, rows: list[list[object]]) -> list[str]:
    """Markdown; columns of the head are separated by |."""
    names = [name.strip() for name in head.split("|")]
    lines = [f"| {' | '.join(names)} |", "|" + " --- |" * len(names)]
    return [*lines, *(f"| {' | '.join(str(cell) for cell in row)} |" for row in rows), ""]


def number(value: float) -> str:
    """Three digits that count."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def text(*sentences: str) -> list[str]:
    """A paragraph."""
    return [*textwrap.wrap(" ".join(sentences), 98, break_on_hyphens=False), ""]
