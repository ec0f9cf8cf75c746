"""What E57 files say of themselves, checked before libE57 reads them."""

from __future__ import annotations

import os

from omma._core import Error
from omma.base.beginnings import beginning_of

# Of the header (ASTM E2807, table 1): its length, and where the length of the file stands.
_HEADER = 48
_LENGTH = slice(16, 24)


def check_e57_head(path: str) -> None:
    """omma.Error where a file is no E57 file, or is shorter or longer than it says."""
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        head = file.read(512)
    if not head.startswith(b"ASTM-E57"):
        raise Error(
            f"{path}: expected a file that begins with ASTM-E57, found {beginning_of(head)}"
        )
    length = int.from_bytes(head[_LENGTH], "little") if len(head) >= _HEADER else _HEADER
    if size != length:
        raise Error(f"{path}: expected {length:,} bytes as its header says, found {size:,}")
