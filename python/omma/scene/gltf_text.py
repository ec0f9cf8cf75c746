"""The JSON of a glTF file, for those who ask what it may hold before it is read as a scene."""

from __future__ import annotations

import mmap
import os
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

GLTF_FILES = (".gltf", ".glb")
# What files with Gaussian splats name, in whatever draft: the extension, or SPZ alone.
_OF_SPLATS = ("KHR_gaussian_splatting", "KHR_spz_gaussian_splats_compression")
# What trimesh calls itself as the generator (to its version 5.2 at least), and vertex colours.
_TRIMESH, _COLORS = "mikedh/trimesh", "COLOR_0"


class GltfPlaces(NamedTuple):
    """Where the parts of a glTF file are, in bytes; sizes are 0 of what there is none."""

    text: int
    text_size: int
    binary: int
    binary_size: int


def begins_as_gltf(path: str) -> bool:
    """Whether a file begins as glTF does, as text or binary, whatever its name."""
    if not os.path.isfile(path):  # opening a pipe may wait for ever
        return False
    try:
        with open(path, "rb") as file:
            begin = file.read(256)
    except OSError:
        return False
    return begin[:4] == b"glTF" or begin.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{"


def gltf_places(path: str) -> GltfPlaces:
    """Of a `.gltf` or `.glb` file. What is no such file, or cut off, has no text: the reader of
    scenes says what is wrong with it."""
    nothing = GltfPlaces(0, 0, 0, 0)
    if Path(path).suffix.lower() not in GLTF_FILES or not os.path.isfile(path):
        return nothing
    try:
        with open(path, "rb") as file:
            whole = os.fstat(file.fileno()).st_size
            head = file.read(20)
            if head[:4] != b"glTF":
                return GltfPlaces(0, whole, 0, 0)
            size = int.from_bytes(head[12:16], "little")
            if head[16:20] != b"JSON" or 20 + size > whole:
                return nothing
            file.seek(20 + size)
            chunk = file.read(8)
    except OSError:
        return nothing
    if chunk[4:] != b"BIN\0":
        return GltfPlaces(20, size, 0, 0)
    return GltfPlaces(20, size, 20 + size + 8, int.from_bytes(chunk[:4], "little"))


def gltf_names(path: str, names: Iterable[str]) -> bool:
    """Whether the JSON of a glTF file has any of these names, without reading it into memory: a
    text with its buffers in it may be as large as that is."""
    places = gltf_places(path)
    if places.text_size == 0:
        return False
    try:
        with (
            open(path, "rb") as file,
            mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped,
        ):
            end = places.text + places.text_size
            return any(mapped.find(name.encode(), places.text, end) >= 0 for name in names)
    except (OSError, ValueError):  # gone, or cut meanwhile
        return False


def names_splats(path: str) -> bool:
    """Whether a glTF file may hold Gaussian splats."""
    return gltf_names(path, _OF_SPLATS)


def colors_of_trimesh(path: str) -> list[str]:
    """What there is to warn of where trimesh wrote the vertex colours of a glTF file: it writes the
    bytes that it has, sRGB in most files of meshes, where glTF 2.0 (3.7.2.1) says linear."""
    if not (gltf_names(path, [_TRIMESH]) and gltf_names(path, [_COLORS])):
        return []
    return [
        "its vertex colours are taken as linear, as glTF says, but trimesh, which wrote it, writes "
        "the bytes that it has: where they are sRGB, as those of PLY and OBJ files, they are too "
        "bright here; load the .ply or .obj instead, or "
        "omma.scene.from_trimesh(trimesh.load(...)), which takes them as sRGB"
    ]
