"""The cache of baked light: files that are named by all that their light depends on, of bakes that
are finished, and of those that were stopped."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import time
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from omma import _core
from omma._core import Error, Scene, __version__
from omma.base.backend_names import backend_record, backend_words, without_ordinals
from omma.base.directories import cache_folder
from omma.base.files import WholeFiles, make_directory
from omma.base.warn import warn_caller

# Of keys and files; raised where either changes.
_FORMAT = 5
_MAGIC = b"omma baked light\n"
_NUMBER = 8  # bytes of each of the two numbers behind that: check sum, length of the header
_ENDING, _UNFINISHED = ".baked", ".unfinished"

_MOST_BYTES = 2 << 30
_DAY_S = 86400.0

# Fields of a scene that light depends on; names are not among them.
_FIELDS = ("meshes", "instances", "materials", "textures", "images", "lights", "color_rule")
_ARRAYS = ("values", "errors", "first_cell", "probe_values")
_PROBE_GRID = ("probe_origin_m", "probe_spacing_m")


def cache_directory(cache: bool | str | os.PathLike[str]) -> Path | None:
    """The folder to look in and write to; None for none."""
    if not isinstance(cache, bool):
        return Path(cache)
    return cache_folder("baked-light") if cache else None


def scene_digest(scene: Scene) -> bytes:
    """Of all of a scene that light depends on."""
    digest = hashlib.blake2b(digest_size=32)
    for name in _FIELDS:
        _add(digest, name)
        _add(digest, getattr(scene, name))
    return digest.digest()


def world_key(
    engine: _core.World, of_scene: bytes, light: dict[str, Any], settings: tuple[Any, ...]
) -> str:
    """The name of what is baked: 64 hexadecimal digits of all that it depends on.

    Args:
        of_scene: of `scene_digest`.
        light: the arguments of the engine's light.
        settings: of the bake.
    """
    digest = hashlib.blake2b(digest_size=32)
    transforms = [one.world_from_node for one in engine.instances]
    backend = backend_words(backend_record(without_ordinals(engine.backend)))
    for one in (_FORMAT, __version__, backend, of_scene, transforms, light, settings):
        _add(digest, one)
    return digest.hexdigest()


def _add(digest: Any, value: Any) -> None:
    """A value to a digest, with its type and length, so that no two values read alike."""
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).reshape(-1).view(np.uint8))
    elif isinstance(value, (list, tuple)):
        digest.update(f"[{len(value)}]".encode())
        for item in value:
            _add(digest, item)
    elif isinstance(value, dict):
        digest.update(f"{{{len(value)}}}".encode())
        for key, item in value.items():
            _add(digest, key)
            _add(digest, item)
    elif value is None or isinstance(value, (bool, int, float, str, bytes)):
        text = repr(value).encode("utf-8", "surrogateescape")
        digest.update(f"{type(value).__name__}{len(text)} ".encode() + text)
    else:
        # A value of the scene: its pickle is all that it is.
        make = value.__reduce__()[0]
        assert isinstance(make, functools.partial)
        _add(digest, type(value).__name__)
        _add(digest, {name: item for name, item in make.keywords.items() if name != "name"})


def read_baked_light(directory: Path, key: str) -> _core.BakedLight | None:
    """What is kept under that name; None where nothing is, or what is there is not whole."""
    path = directory / (key + _ENDING)
    try:
        header, arrays = _read(path, key)
        cells = arrays.pop("cell_of_triangle")
        ends = np.cumsum(header["triangles"])[:-1]
        baked = _core.BakedLight(
            cell_of_triangle=np.split(cells, ends) if header["triangles"] else [],
            **arrays,
            **{name: header[name] for name in ("unit", "numbers", *_PROBE_GRID)},
        )
    except _NOT_WHOLE:
        return None  # baked and written anew
    with contextlib.suppress(OSError):  # of a folder that can only be read
        os.utime(path)  # used last
    return baked


def write_baked_light(directory: Path, key: str, baked: _core.BakedLight) -> None:
    """Keeps it under that name; a UserWarning where that cannot be."""
    cells = baked.cell_of_triangle
    arrays = {name: getattr(baked, name) for name in _ARRAYS}
    arrays["cell_of_triangle"] = np.concatenate([np.empty(0, np.int32), *cells])
    header = {
        "unit": baked.unit,
        "numbers": baked.numbers,
        **{name: getattr(baked, name).tolist() for name in _PROBE_GRID},
        "triangles": [len(first) for first in cells],
    }
    problem = _write(directory / (key + _ENDING), key, header, arrays)
    if problem is None:
        with contextlib.suppress(OSError):
            os.remove(directory / (key + _UNFINISHED))
        _remove_oldest(directory, key + _ENDING)
        return
    warn_caller(
        f"cache of baked light: {directory}: {problem}; the light is baked again next time "
        "(OMMA_CACHE or omma.scene.Bake(cache=...) names another folder)",
        UserWarning,
    )


def read_unfinished(directory: Path, key: str) -> _core.UnfinishedBake:
    """What is kept of a bake that was stopped; nothing where it was not."""
    try:
        header, arrays = _read(directory / (key + _UNFINISHED), key)
        lines = [arrays[f"lines{k}"] for k in range(4)]
        return _core.UnfinishedBake(
            header["numbers"], arrays["done"], lines, arrays["paths_of_group"]
        )
    except _NOT_WHOLE:
        return _core.UnfinishedBake()


def keep_unfinished(directory: Path, key: str, bake: _core.UnfinishedBake) -> bool:
    """Keeps what is finished of a bake; whether that could be."""
    arrays: dict[str, Any] = {f"lines{k}": lines for k, lines in enumerate(bake.lines)}
    arrays |= {"done": bake.done, "paths_of_group": bake.paths_of_group}
    name = key + _UNFINISHED
    if _write(directory / name, key, {"numbers": bake.numbers}, arrays) is not None:
        return False
    _remove_oldest(directory, name)
    return True


# What reading a file ends in that is not there, was cut short or changed.
_NOT_WHOLE = (Error, OSError, ValueError, KeyError, TypeError)


def _read(path: Path, key: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Header and arrays of a file; one of `_NOT_WHOLE` where it is not there or not whole."""
    if not path.exists():
        raise FileNotFoundError(path)
    data = _core.read_file(path)
    start = len(_MAGIC) + 2 * _NUMBER
    checksum, length = np.frombuffer(data, "<u8", 2, len(_MAGIC)).tolist()
    body = memoryview(data)[start - _NUMBER :]
    if not data.startswith(_MAGIC) or zlib.crc32(body) != checksum:
        raise ValueError("not whole")
    header = json.loads(data[start : start + length])
    if header["format"] != _FORMAT or header["key"] != key:
        raise ValueError("of another format or world")
    offset = start + length
    arrays = {}
    for name, dtype, shape in header["arrays"]:
        count = int(np.prod(shape, dtype=np.int64))
        array = np.frombuffer(data, dtype, count, offset).reshape(shape)
        arrays[name] = array
        offset += array.nbytes
    return header, arrays


def _write(
    path: Path, key: str, header: dict[str, Any], arrays: dict[str, Any]
) -> Exception | None:
    """Writes a file as a whole; what hindered it, if anything did."""
    header = {
        "format": _FORMAT,
        "key": key,
        **header,
        "arrays": [[name, array.dtype.str, array.shape] for name, array in arrays.items()],
    }
    text = json.dumps(header).encode()
    parts: list[Any] = [np.array(len(text), "<u8").tobytes(), text]
    parts += [memoryview(array.reshape(-1)) for array in arrays.values() if array.size]
    checksum = 0
    for part in parts:
        checksum = zlib.crc32(part, checksum)
    try:
        make_directory(path.parent)
        with WholeFiles() as files:
            file = files.open(str(path))
            file.write(_MAGIC + np.array(checksum, "<u8").tobytes())
            for part in parts:
                file.write(part)
    except (Error, OSError) as error:
        return error
    return None


def _remove_oldest(directory: Path, kept: str) -> None:
    """Files used least recently, until the others take no more than 2 GiB, and what runs that were
    killed left behind."""
    found = []
    with contextlib.suppress(OSError):
        for entry in os.scandir(directory):
            with contextlib.suppress(OSError):  # another process has removed it
                about = entry.stat()
                if entry.name.endswith((_ENDING, _UNFINISHED)) and entry.name != kept:
                    found.append((about.st_mtime, about.st_size, entry.path))
                elif entry.name.endswith(".partial") and about.st_mtime < time.time() - _DAY_S:
                    os.remove(entry.path)
    bytes_left = _MOST_BYTES
    with contextlib.suppress(OSError):
        bytes_left -= os.path.getsize(directory / kept)
    for _, size, path in sorted(found, reverse=True):
        bytes_left -= size
        if bytes_left < 0:
            with contextlib.suppress(OSError):
                os.remove(path)
