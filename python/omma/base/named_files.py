"""The files that files of scenes name: buffers, pictures and eyes of glTF files, materials of OBJ
files and their pictures, the picture of a PLY file."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from omma import _core
from omma._core import Error

# Endings of files that name others.
NAMING = (".gltf", ".glb", ".obj", ".ply")

# No name of a file that a glTF file can mean is longer.
_LONGEST_NAME = 1000

MATERIAL_LIBRARY = re.compile(rb"^[ \t]*mtllib\b[ \t]*([^\r\n]*)\r?$", re.MULTILINE)
# A keyword of a picture in a .mtl file, also of those that are not read, and the rest of its line.
_MATERIAL_PICTURE = re.compile(
    r"^[ \t]*(?:map_\w+|bump|norm|disp|decal|refl)[ \t]+([^\r\n]*)", re.MULTILINE | re.IGNORECASE
)
_PLY_PICTURE = re.compile(rb"^comment[ \t]+TextureFile([^\r\n]*)", re.MULTILINE)
_PLY_END = b"\nend_header"
# No header of a PLY file is longer.
_PLY_HEADER_BYTES = 1 << 20


def files_named_by(name: str) -> list[str]:
    """Files that are there, of those that a file of a scene names; none where it is none: who reads
    it says what is wrong."""
    ending = Path(name).suffix.lower()
    if ending not in NAMING or not os.path.isfile(name):
        return []
    try:
        if ending == ".ply":  # may be gigabytes, of which the header says it
            with open(name, "rb") as file:
                return list(files_in(name, file.read(_PLY_HEADER_BYTES)))
        return list(files_in(name, _core.read_file(name)))
    except (Error, OSError):
        return []


def files_in(name: str, data: bytes) -> Iterator[str]:
    """The files that are there, of those that a file of that name and these bytes names.

    Raises:
        omma.Error: a glTF file that is none.
    """
    ending = Path(name).suffix.lower()
    if ending in (".gltf", ".glb"):
        yield from _of_gltf(name, data)
    elif ending == ".obj":
        yield from dict.fromkeys(_of_obj(os.path.dirname(name), data))
    elif ending == ".ply":
        head = data[: data.find(_PLY_END)]
        for found in _PLY_PICTURE.findall(head):
            file = found_beside(os.path.dirname(name), text_of_name(found).strip())
            if file is not None:
                yield file


def text_of_name(name: bytes) -> str:
    """As most programs write names; in the encoding of old ones where it is not that."""
    try:
        return name.decode()
    except UnicodeDecodeError:
        return name.decode("latin-1")


def found_beside(folder: str, name: str) -> str | None:
    """The file of that name; a back slash is what other systems have between folders."""
    for one in (name, name.replace("\\\\", "/").replace("\\", "/")):
        file = os.path.join(folder, one)
        try:
            if one and os.path.isfile(file):
                return file
        except ValueError:  # a zero byte
            return None
    return None


def material_libraries(folder: str, line: str) -> list[str]:
    """The names in a line of an OBJ file, of one file, perhaps with spaces, or of several."""
    return [line] if found_beside(folder, line) or " " not in line else line.split()


def _of_gltf(name: str, data: bytes) -> Iterator[str]:
    binary = data[:4] == b"glTF"
    # Of a .glb the first chunk is the JSON text.
    text = data[20 : 20 + int.from_bytes(data[12:16], "little")] if binary else data
    # URIs of all kinds: buffers, images, eyes, extensions.
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        raise Error(f"{name}: is not a glTF file: its JSON is malformed") from None
    for other in sorted(set(_texts(document))):
        for beside in {other, unquote(other)}:
            file = os.path.join(os.path.dirname(name), beside)
            if 0 < len(beside) < _LONGEST_NAME and "\0" not in beside and os.path.isfile(file):
                yield file


def _texts(document: Any) -> Iterable[str]:
    waiting = [document]
    while waiting:
        value = waiting.pop()
        if isinstance(value, str):
            yield value
        elif isinstance(value, dict):
            waiting.extend(value.values())
        elif isinstance(value, list):
            waiting.extend(value)


def _of_obj(folder: str, data: bytes) -> Iterator[str]:
    for line in MATERIAL_LIBRARY.findall(_joined(data)):
        for name in material_libraries(folder, text_of_name(line).strip()):
            library = found_beside(folder, name)
            if library is None:
                continue
            yield library
            text = _joined(_core.read_file(library)).decode("utf-8", "replace")
            for rest in _MATERIAL_PICTURE.findall(text):
                # Options stand before the name, which may have spaces in it.
                words = rest.strip().split(" ")
                for k in range(len(words)):
                    picture = found_beside(folder, " ".join(words[k:]).strip().strip('"'))
                    if picture is not None:
                        yield picture
                        break


def _joined(data: bytes) -> bytes:
    """Lines that go on after a backslash as one."""
    return data.replace(b"\\\n", b" ").replace(b"\\\r\n", b" ")
