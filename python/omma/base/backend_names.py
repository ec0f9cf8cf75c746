"""What a backend's name says of responses, and what files say of the backend that made them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from omma.base.processors import instruction_set


def without_ordinals(backend: str) -> str:
    """What of a backend's name responses depend on: of cards the kinds, not which and how many."""
    parts = re.split(r", (?=cuda:\d)", backend)
    return ", ".join(sorted({re.sub(r"^cuda:\d+", "cuda", part) for part in parts}))


def instruction_set_of(backend: str) -> str | None:
    """The instruction set that responses depend on: of Embree, which has code for several; None of
    backends that give the same bits on all."""
    return instruction_set() if backend.startswith("embree") else None


def backend_record(backend: str) -> dict[str, str]:
    """A backend's name and, where responses depend on it, the instruction set."""
    found = instruction_set_of(backend)
    return {"backend": backend} | ({} if found is None else {"instruction_set": found})


def backend_words(record: Mapping[str, Any]) -> str:
    """A `backend_record` as words."""
    found = record.get("instruction_set")
    return f"{record['backend']}" + (f" on {found}" if found else "")


def backend_differences(then: Mapping[str, Any], now: Mapping[str, str]) -> Iterator[str]:
    """In what two `backend_record` differ; older versions told no instruction set, of which nothing
    is said then."""
    if without_ordinals(str(then.get("backend"))) != without_ordinals(now["backend"]):
        yield f"backend was {then.get('backend')!r}, is {now['backend']!r}"
    before, after = then.get("instruction_set"), now.get("instruction_set")
    if None not in (before, after) and before != after:
        yield f"instruction_set was {before!r}, is {after!r}"
