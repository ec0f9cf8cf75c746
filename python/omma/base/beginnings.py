"""How a file begins, in words, for what was expected to be another."""

from __future__ import annotations

# Characters that are shown of what was found, and bytes by which text is told.
_SHOWN = 60
_LOOKED_AT = 512
_OF_TEXT = bytes([9, 10, 12, 13, *range(32, 256)])


def shown(text: bytes) -> str:
    """Some text in quotes, shortened."""
    plain = text.decode("utf-8", "replace").strip()
    return f"'{plain[:_SHOWN]}{'...' if len(plain) > _SHOWN else ''}'"


def is_plain_text(head: bytes) -> bool:
    """Whether a file that begins so may be text of 8 bits a character; an empty one is not."""
    return bool(head) and not head[:_LOOKED_AT].translate(None, _OF_TEXT)


def beginning_of(head: bytes) -> str:
    """``head`` is what a file begins with, or all of it."""
    if not head:
        return "an empty file"
    if not is_plain_text(head):
        return "bytes that are no plain text"
    first = head.strip().partition(b"\n")[0]
    return f"a file that begins with {shown(first)}"
