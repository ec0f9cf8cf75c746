"""glTF files as Blender's exporter writes them, .glb or .gltf with its .bin, opened to add to them.

Nothing here needs Blender.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from pathlib import Path

_JSON, _BINARY = 0x4E4F534A, 0x004E4942  # the two kinds of chunks of a .glb, glTF 2.0, 4.4.3


@dataclass
class GltfFile:
    """A document and the bytes of its first buffer."""

    document: dict
    binary: bytearray


def read_gltf(path: Path) -> GltfFile:
    if path.suffix.lower() == ".glb":
        data = path.read_bytes()
        at, chunks = 12, {}
        while at < len(data):
            length, kind = struct.unpack_from("<II", data, at)
            chunks[kind] = data[at + 8 : at + 8 + length]
            at += 8 + length
        return GltfFile(json.loads(chunks[_JSON]), bytearray(chunks.get(_BINARY, b"")))
    document = json.loads(path.read_text(encoding="utf-8"))
    buffers = document.get("buffers", [])
    binary = (path.parent / buffers[0]["uri"]).read_bytes() if buffers else b""
    return GltfFile(document, bytearray(binary))


def write_gltf(path: Path, gltf: GltfFile) -> None:
    document, binary = gltf.document, gltf.binary
    if binary:
        buffer = document.setdefault("buffers", [{}])[0]
        buffer["byteLength"] = len(binary)
        if path.suffix.lower() != ".glb":
            buffer.setdefault("uri", f"{path.stem}.bin")
            (path.parent / buffer["uri"]).write_bytes(binary)
    text = json.dumps(document, ensure_ascii=False, allow_nan=False).encode()
    if path.suffix.lower() != ".glb":
        path.write_bytes(text)
        return
    chunks = _chunk(_JSON, text, b" ") + (_chunk(_BINARY, bytes(binary), b"\0") if binary else b"")
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def _chunk(kind: int, data: bytes, filling: bytes) -> bytes:
    data += filling * (-len(data) % 4)
    return struct.pack("<II", len(data), kind) + data


def add_bytes(gltf: GltfFile, data: bytes) -> int:
    """Puts bytes behind those of the first buffer; the index of their buffer view."""
    gltf.binary += b"\0" * (-len(gltf.binary) % 4)
    view = {"buffer": 0, "byteOffset": len(gltf.binary), "byteLength": len(data)}
    gltf.binary += data
    views = gltf.document.setdefault("bufferViews", [])
    views.append(view)
    return len(views) - 1


def default_scene(gltf: GltfFile) -> dict:
    """The scene that is shown, with extras to add to."""
    scene = gltf.document["scenes"][gltf.document.get("scene", 0)]
    scene.setdefault("extras", {})
    return scene
