"""glTF files whose Gaussian splats are packed as SPZ: a primitive names a buffer view that holds an
.spz file (KhronosGroup/glTF, pull request 2531, KHR_gaussian_splatting_compression_spz_2, a draft;
and its earlier names, of which files exist).

The engine's reader sees a file in which each such primitive has one splat that marks it, with
everything else as it is: nodes, transforms, instances, scenes, animations. Then what was unpacked
takes the place of the marks.

The draft asks for a turn of half a circle about y when packing and unpacking ("LUF"); the programs
that read such files take the numbers as they stand, which is done here: cesium-native
(CesiumGltfReader, its decoder of SPZ) and spz-loader, UNSPECIFIED.
"""

from __future__ import annotations

import base64
import binascii
import io
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, TypeVar
from urllib.parse import unquote, unquote_to_bytes

import numpy as np

from omma import _core
from omma._core import Error, Scene, SplatCloud
from omma.base.files import reading_told
from omma.base.progress import Progress, share_of
from omma.scene.gltf_text import gltf_names, gltf_places
from omma.scene.joining import warnings_of_file
from omma.scene.splat_columns import SplatColumns
from omma.scene.splat_spz import unpack_spz

T = TypeVar("T")
Json = dict[str, Any]

_SPLATS = "KHR_gaussian_splatting"
# Inside of that extension; and the first draft, beside it.
_NESTED = ("KHR_gaussian_splatting_compression_spz_2", "KHR_gaussian_splatting_compression_spz")
_ALONE = "KHR_spz_gaussian_splats_compression"
_NAMES = (*_NESTED, _ALONE)
_SRGB = "srgb_rec709_display"
# Of a splat that stands for what was packed: y, z and the opacity, which no splat of anybody's has.
_MARK = (0.7182818, 0.1415926, 0.7654321)
# Of the progress: unpacking. The rest is the engine's.
_UNPACKED = 0.8


@dataclass
class _Packed:
    """The splats of one primitive."""

    place: str
    columns: SplatColumns
    told: list[str] = field(default_factory=list)

    def sentences(self) -> list[str]:
        """What there is to warn of."""
        return [f"{self.place}: {sentence}" for sentence in (*self.told, *self.columns.told())]


def load_spz_gltf(
    path: str, scene_index: int, color_rule: str, progress: Progress | None
) -> Scene | None:
    """The scene of a glTF file with splats packed as SPZ, as `_core.load_scene` reads others; None
    where there are none.

    Raises:
        omma.Error: it cannot be read.
    """
    if not gltf_names(path, _NAMES):
        return None
    places = gltf_places(path)
    try:
        with open(path, "rb") as source:
            source.seek(places.text)
            document = json.loads(source.read(places.text_size))
    except (OSError, ValueError, RecursionError):
        return None  # the engine says where it is malformed, or gone
    file = _GltfFile(path, document, places.binary, places.binary_size)
    with reading_told(path, "Gaussian splats", share_of(progress, 0, _UNPACKED)) as tell:
        packed = _marked(file, tell)
    try:
        with tempfile.TemporaryDirectory(prefix="omma-spz-") as folder:
            name = os.path.join(folder, "scene.glb")
            file.write_beside(name)
            rest = share_of(progress, _UNPACKED, 1)
            try:
                scene = _core.load_scene(name, scene_index, color_rule, rest)
            except Error as error:
                raise Error(str(error).replace(name, path)) from None
    except OSError as error:
        raise Error(f"{path}: cannot be unpacked: {error.strerror}: {error.filename}") from None
    return _with_splats(scene, name, path, packed)


def _with_splats(scene: Scene, name: str, path: str, packed: list[_Packed]) -> Scene:
    """The scene that was read under another name, with splats in place of marks."""
    told = [one.replace(name, path) for one in warnings_of_file(scene)]
    clouds = [_unmarked(cloud, packed) for cloud in scene.splats]
    told += [sentence for one in packed for sentence in one.sentences()]
    packed.clear()  # what is in clouds now; a scene is copied, and memory meant for two of them
    scene = scene.replace(splats=clouds)
    del clouds
    return _core.with_path(scene, path, told)


def _unmarked(cloud: SplatCloud, packed: list[_Packed]) -> SplatCloud:
    """A cloud of the file, or what a mark stands for, placed as it."""
    if len(cloud.positions_m) != 1:
        return cloud
    number, *mark = np.append(cloud.positions_m[0], cloud.opacities)
    if not np.array_equal(mark, np.array(_MARK, np.float32)):
        return cloud
    return packed[int(number)].columns.splats(
        cloud.world_from_splats,
        cloud.name,
        color_space=cloud.color_space,
        direction=cloud.direction,
        white=cloud.white,
    )


def _marked(file: _GltfFile, progress: Progress | None) -> list[_Packed]:
    """What was packed, in whose place the document has marks then."""
    primitives = list(_spz_primitives(file))
    found: list[_Packed] = []
    by_view: dict[int, SplatColumns] = {}
    for number, (place, primitive, view) in enumerate(primitives):
        if view not in by_view:
            share = share_of(progress, number / len(primitives), (number + 1) / len(primitives))
            by_view[view] = unpack_spz(f"{place}: SPZ", io.BytesIO(file.view(view, place)), share)
        packed = _Packed(place, by_view[view])
        _check_count(file, primitive, packed)
        _mark(file, primitive, number, packed)
        found.append(packed)
    for key in ("extensionsUsed", "extensionsRequired"):
        listed = _of(file.document, key, list, [], file.path)
        file.document[key] = [one for one in listed if one not in _NAMES]
        if not file.document[key]:
            del file.document[key]
    file.packed_views = set(by_view)
    return found


def _spz_primitives(file: _GltfFile) -> Iterator[tuple[str, Json, int]]:
    """Primitives that have SPZ, where they are, and the index of the buffer view."""
    path = file.path
    for m, mesh in enumerate(_of(file.document, "meshes", list, [], path)):
        of_mesh = f"{path}: mesh {m}"
        if isinstance(mesh, dict) and isinstance(mesh.get("name"), str):
            of_mesh += f' "{mesh["name"]}"'
        for p, primitive in enumerate(_of(mesh, "primitives", list, [], of_mesh)):
            place = f"{of_mesh}, primitive {p}"
            extensions = _of(primitive, "extensions", dict, {}, place)
            base = _of(extensions, _SPLATS, dict, {}, place)
            nested = _of(base, "extensions", dict, {}, place)
            for names, at in ((_NESTED, nested), ((_ALONE,), extensions)):
                name = next((one for one in names if one in at), None)
                if name is not None:
                    view = _of(_of(at, name, dict, {}, place), "bufferView", int, None, place)
                    yield place, primitive, view
                    break


def _mark(file: _GltfFile, primitive: Json, number: int, packed: _Packed) -> None:
    """Leave a primitive with one splat, which says by its place what it stands for."""
    extensions = primitive["extensions"]
    base = extensions.setdefault(_SPLATS, {})
    for name in _NAMES:
        base.get("extensions", {}).pop(name, None)
        extensions.pop(name, None)
    base.setdefault("kernel", "ellipse")
    if "colorSpace" not in base:
        base["colorSpace"] = _SRGB
        packed.told.append("names no colour space of its splats; sRGB is taken, as 3DGS trains")
    primitive["attributes"] = {
        "POSITION": file.accessor("VEC3", (number, *_MARK[:2])),
        f"{_SPLATS}:SCALE": file.accessor("VEC3", (1, 1, 1)),
        f"{_SPLATS}:ROTATION": file.accessor("VEC4", (0, 0, 0, 1)),
        f"{_SPLATS}:OPACITY": file.accessor("SCALAR", _MARK[2:]),
        f"{_SPLATS}:SH_DEGREE_0_COEF_0": file.accessor("VEC3", (0, 0, 0)),
    }


def _check_count(file: _GltfFile, primitive: Json, packed: _Packed) -> None:
    """A warning where a primitive says another number of splats than its SPZ."""
    attributes = _of(primitive, "attributes", dict, {}, packed.place)
    index = _of(attributes, "POSITION", int, -1, packed.place)
    accessors = _of(file.document, "accessors", list, [], file.path)
    if 0 <= index < len(accessors):
        said = _of(accessors[index], "count", int, None, f"{file.path}: accessor {index}")
        found = len(packed.columns.positions)
        if said != found:
            packed.told.append(f"says {said:,} splats, its SPZ has {found:,}")


class _GltfFile:
    """A document that is changed, and the buffers of its file."""

    def __init__(self, path: str, document: Any, begin: int, length: int) -> None:
        if not isinstance(document, dict):
            raise Error(f"{path}: is not a glTF file: expected an object, found another value")
        self.path, self.document = path, document
        self._begin, self._length = begin, length
        self._marks = b""
        self._views_before = len(_of(document, "bufferViews", list, [], path))
        self._buffers_before = len(_of(document, "buffers", list, [], path))
        self.packed_views: set[int] = set()

    def view(self, index: int, place: str) -> bytes:
        """The bytes of a buffer view."""
        view = self._element("bufferViews", "buffer view", index, place)
        where = f"{self.path}: buffer view {index}"
        number = _of(view, "buffer", int, None, where)
        offset, size = (
            _of(view, "byteOffset", int, 0, where),
            _of(view, "byteLength", int, None, where),
        )
        buffer = self._element("buffers", "buffer", number, where)
        uri = _of(buffer, "uri", str, "", f"{self.path}: buffer {number}")
        if min(offset, size) < 0:
            raise Error(f"{where}: expected byteOffset and byteLength of 0 or more")
        if uri:
            data = self._of_uri(uri, f"{self.path}: buffer {number}")
            found = data[offset : offset + size]
        else:
            with open(self.path, "rb") as file:
                file.seek(self._begin + offset)
                there = self._length if number == 0 else 0
                found = file.read(max(0, min(size, there - offset)))
        if len(found) < size:
            raise Error(
                f"{where}: expected {size:,} bytes from byte {offset:,} on, found the end of "
                f"buffer {number}"
            )
        return found

    def accessor(self, kind: str, values: tuple[float, ...]) -> int:
        """The index of a new accessor of one element in single precision."""
        views = self.document.setdefault("bufferViews", [])
        accessors = self.document.setdefault("accessors", [])
        buffer, data = self._buffers_before, np.array(values, "<f4")
        views.append({"buffer": buffer, "byteOffset": len(self._marks), "byteLength": data.nbytes})
        self._marks += data.tobytes()
        made: Json = {
            "bufferView": len(views) - 1, "componentType": 5126, "count": 1, "type": kind,
        }  # fmt: skip
        if kind == "VEC3":
            made |= {"min": data.tolist(), "max": data.tolist()}
        accessors.append(made)
        return len(accessors) - 1

    def write_beside(self, name: str) -> None:
        """Write the changed file, with what else it needs, where nothing else is."""
        if self._marks:
            uri = b"data:;base64," + base64.b64encode(self._marks)
            one = {"uri": uri.decode(), "byteLength": len(self._marks)}
            self.document.setdefault("buffers", []).append(one)
        self._link_files(os.path.dirname(name))
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        views = self.document.get("bufferViews", [])[: self._views_before]
        is_needed = any(
            isinstance(view, dict) and view.get("buffer") == 0 and k not in self.packed_views
            for k, view in enumerate(views)
        )
        length = self._length if is_needed else 0
        size = 12 + 8 + len(text) + (8 + length if length else 0)
        with open(name, "wb") as file:
            file.write(b"glTF" + _u32(2) + _u32(size) + _u32(len(text)) + b"JSON" + text)
            if length:
                file.write(_u32(length) + b"BIN\0")
                with open(self.path, "rb") as source:
                    source.seek(self._begin)
                    _copy(source, file, length)

    def _link_files(self, folder: str) -> None:
        """Files that the document names are found beside another one too; what is not there, or
        elsewhere than below the scene's folder, the engine says."""
        named = [*self.document.get("buffers", []), *self.document.get("images", [])]
        home = os.path.dirname(os.path.realpath(self.path))
        for one in named:
            uri = one.get("uri", "") if isinstance(one, dict) else ""
            if not isinstance(uri, str) or not uri or uri.startswith("data:"):
                continue
            relative = os.path.normpath(unquote(uri))
            source = os.path.realpath(os.path.join(home, relative))
            if os.path.isabs(relative) or relative.startswith("..") or not os.path.isfile(source):
                continue
            target = Path(folder, relative)
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.exists():
                try:
                    os.link(source, target)
                except OSError:  # another file system, or one without links
                    shutil.copyfile(source, target)

    def _of_uri(self, uri: str, place: str) -> bytes:
        """What a URI leads to: data, or a file below the scene's folder."""
        if uri.startswith("data:"):
            head, comma, data = uri.partition(",")
            try:
                plain = unquote_to_bytes(data)
                if not comma:
                    raise ValueError
                return base64.b64decode(plain, validate=True) if ";base64" in head else plain
            except (ValueError, binascii.Error):
                raise Error(f"{place}: expected a data URI, found another text") from None
        folder = os.path.dirname(os.path.realpath(self.path))
        file = os.path.realpath(os.path.join(folder, unquote(uri)))
        if os.path.commonpath([folder, file]) != folder or not os.path.isfile(file):
            raise Error(f'{place}: expected a file in the folder of the scene, found "{uri:.200}"')
        return _core.read_file(file)

    def _element(self, key: str, what: str, index: int, place: str) -> Any:
        elements = _of(self.document, key, list, [], self.path)
        if not 0 <= index < len(elements):
            raise Error(f"{place}: refers to {what} {index}, there are {len(elements)}")
        return elements[index]


def _of(values: Any, key: str, kind: type[T], default: Any, place: str) -> T:
    """A member of an object, of its type; the default, unless that is None, where it is missing."""
    if not isinstance(values, dict):
        raise Error(f"{place}: expected an object, found another value")
    if key not in values and default is not None:
        found: T = default
        return found
    value = values.get(key)
    if not isinstance(value, kind) or isinstance(value, bool):
        raise Error(f"{place}: {key}: expected {_WORDS[kind]}, found {value!r:.40}")
    return value


_WORDS: dict[type, str] = {
    int: "a whole number", str: "a text", list: "an array", dict: "an object"
}  # fmt: skip


def _u32(value: int) -> bytes:
    if value >= 1 << 32:
        raise Error(f"a file of {value:,} bytes is too large for .glb")
    return value.to_bytes(4, "little")


def _copy(source: BinaryIO, target: BinaryIO, count: int) -> None:
    while count > 0 and (piece := source.read(min(count, 1 << 20))):
        target.write(piece)
        count -= len(piece)
