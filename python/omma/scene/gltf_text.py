"""The JSON of a glTF file, for those who ask what it may hold before it is read as a scene."""

from __future__ import annotations

import os
from pathlib import Path

_GLTF = (".gltf", ".glb")
# What files with Gaussian splats name, in whatever draft: the extension, or SPZ alone.
_OF_SPLATS = (b"KHR_gaussian_splatting", b"KHR_spz_gaussian_splats_compression")


def gltf_text(path: str) -> tuple[bytes, int, int]:
    """The JSON text of a `.gltf` or `.glb` file, and where the binary chunk of the latter begins
    and how long it is, 0 and 0 where there is none.

    What is no such file, or cut off, has no text: the reader of scenes says what is wrong with it.
    """
    if Path(path).suffix.lower() not in _GLTF or not os.path.isfile(path):
        return b"", 0, 0
    try:
        with open(path, "rb") as file:
            head = file.read(20)
            if head[:4] != b"glTF":
                return head + file.read(), 0, 0
            size = int.from_bytes(head[12:16], "little")
            text, chunk = file.read(size), file.read(8)
            if len(text) < size or head[16:20] != b"JSON":
                return b"", 0, 0
            is_binary = chunk[4:] == b"BIN\0"
            length = int.from_bytes(chunk[:4], "little") if is_binary else 0
            return text, 20 + size + 8 if is_binary else 0, length
    except OSError:
        return b"", 0, 0


def names_splats(path: str) -> bool:
    """Whether a glTF file may hold Gaussian splats."""
    text, _, _ = gltf_text(path)
    return any(name in text for name in _OF_SPLATS)
