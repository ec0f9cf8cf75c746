"""Files of Gaussian splats as Niantic packs them, .spz: one attribute of all splats after the
other, in bytes, in a frame that looks along -Z with +Y up, as Omma's.

The layout is that of nianticlabs/spz (MIT), README.md and src/cc/load-spz.cc. Versions 2 and 3 are
gzip streams; version 4 has a head that is not packed and a Zstandard stream for each attribute.
That splats were trained with antialiasing, a bit of the head, changes nothing: it is about the
filter of a picture's pixels, which rays do not have.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, SplatCloud
from omma.base.arrays import Floats
from omma.base.beginnings import beginning_of
from omma.base.files import WholeFile
from omma.base.optional import needs
from omma.base.progress import Progress
from omma.scene.splat_columns import PIECE, REST_COUNTS, SplatColumns, sample_of

_MAGIC = 0x5053474E
_HEAD = struct.Struct("<IIIBBBB")
# Of version 4: more of the head, and an entry for each stream.
_MORE = struct.Struct("<I12x")
_ENTRY = struct.Struct("<QQ")
_RECORD = struct.Struct("<II")
_HAS_EXTENSIONS = 2
# Limits of how a viewer's camera goes round; other extensions may say that the numbers mean
# something else (SPZ_ADOBE_coordinate_system: another frame).
_HARMLESS = {0xADBE0002}

# No byte of deflate stands for more than 1,032; of Zstandard there is no bound, and the format's
# own program takes this one.
_MOST_DEFLATED, _MOST_ZSTD = 1032, 1024
# Of bytes that are unpacked at once, and of memory that unpacking may ask for.
_AT_ONCE = 1 << 20
_WINDOW = 1 << 27

_FRACTION_BITS = 24
_COLOUR_SCALE = 0.15
_LOG_SCALE_STEPS, _LOG_SCALE_OFFSET = 16.0, 10.0
_ROTATION_STEPS = 511  # of the smallest three of a quaternion, up to the square root of 1/2

Read = Callable[[int], bytes]


@dataclass
class _Head:
    version: int
    count: int
    terms: int
    fraction_bits: int
    has_extensions: bool

    @property
    def widths(self) -> dict[str, int]:
        """Bytes of each splat by attribute, in the file's order."""
        return {
            "positions": 9,
            "opacities": 1,
            "colours": 3,
            "scales": 3,
            "rotations": 3 if self.version == 2 else 4,
            "harmonics": 3 * (self.terms - 1),
        }


def read_spz_splats(path: str, progress: Progress | None) -> SplatColumns:
    """All splats of an .spz file."""
    with open(path, "rb") as file:
        return unpack_spz(path, file, progress)


def unpack_spz(where: str, file: BinaryIO, progress: Progress | None = None) -> SplatColumns:
    """All splats of an .spz file that is open; ``where`` names it in errors."""
    size = file.seek(0, 2)
    file.seek(0)
    begins = file.read(4)
    file.seek(0)
    if begins[:2] == b"\x1f\x8b":
        head, attributes, rest = _open_gzip(where, file, size)
    elif begins == _MAGIC.to_bytes(4, "little"):
        head, attributes, rest = _open_zstd(where, file, size)
    else:
        raise Error(
            f"{where}: expected a file of .spz, of gzip or NGSP, found {beginning_of(begins)}"
        )
    columns = _read_columns(where, head, attributes, progress)
    _check_rest(where, head, rest)
    return columns


def _head_of(path: str, data: bytes) -> _Head:
    if len(data) < _HEAD.size:
        raise Error(f"{path}: expected a head of .spz of {_HEAD.size} bytes, found {len(data)}")
    magic, version, count, degree, bits, flags, _ = _HEAD.unpack(data[: _HEAD.size])
    if magic != _MAGIC:
        raise Error(f"{path}: expected the letters NGSP, found {beginning_of(data[:4])}")
    if version not in (2, 3, 4):
        raise Error(f"{path}: expected .spz of version 2, 3 or 4, found version {version}")
    if degree >= len(REST_COUNTS):
        raise Error(f"{path}: expected harmonics of degree 0 to 3, found degree {degree}")
    if bits > _FRACTION_BITS:
        raise Error(f"{path}: expected 0 to {_FRACTION_BITS} fraction bits, found {bits}")
    terms = (degree + 1) ** 2
    return _Head(version, count, terms, bits, bool(flags & _HAS_EXTENSIONS))


def _check_promise(path: str, head: _Head, size: int, ratio: int) -> None:
    """omma.Error where so few bytes cannot hold what the head promises."""
    promised = head.count * sum(head.widths.values())
    if promised > size * ratio:
        raise Error(
            f"{path}: expected {head.count:,} splats as its head says, found {size:,} bytes, which "
            "hold fewer"
        )


class _Gzip:
    """Bytes of a gzip file, in bounded pieces."""

    def __init__(self, path: str, file: BinaryIO) -> None:
        self._path, self._file = path, file
        self._unpacker = zlib.decompressobj(16 + zlib.MAX_WBITS)

    def some(self, most: int) -> bytes:
        """At most so many bytes; none at the end."""
        while not self._unpacker.eof:
            packed = self._unpacker.unconsumed_tail or self._file.read(_AT_ONCE)
            try:
                found = self._unpacker.decompress(packed, most)
            except zlib.error as error:
                raise Error(f"{self._path}: is not a whole gzip file: {error}") from None
            if found:
                return found
            if not packed:
                raise Error(f"{self._path}: expected a whole gzip file, found its end")
        return b""

    def read(self, count: int) -> bytes:
        return _exactly(self._path, self.some, count)


def _exactly(path: str, some: Callable[[int], bytes], count: int) -> bytes:
    pieces: list[bytes] = []
    missing = count
    while missing:
        pieces.append(some(missing))
        if not pieces[-1]:
            raise Error(f"{path}: expected {missing:,} bytes more of its splats, found the end")
        missing -= len(pieces[-1])
    return b"".join(pieces)


def _open_gzip(path: str, file: BinaryIO, size: int) -> tuple[_Head, dict[str, Read], Read]:
    """The head, what reads each attribute, and what reads what comes after all."""
    stream = _Gzip(path, file)
    head = _head_of(path, stream.read(_HEAD.size))
    if head.version == 4:
        raise Error(f"{path}: expected .spz of version 4 without gzip around it")
    _check_promise(path, head, size, _MOST_DEFLATED)
    return head, dict.fromkeys(head.widths, stream.read), stream.some


def _open_zstd(path: str, file: BinaryIO, size: int) -> tuple[_Head, dict[str, Read], Read]:
    data = file.read(_HEAD.size + _MORE.size)
    head = _head_of(path, data)
    if head.version != 4:
        raise Error(
            f"{path}: expected .spz of version {head.version} as gzip, found none around it"
        )
    if len(data) < _HEAD.size + _MORE.size:
        raise Error(f"{path}: expected a head of {_HEAD.size + _MORE.size} bytes, found {size}")
    _check_promise(path, head, size, _MOST_ZSTD)
    widths = {one: width for one, width in head.widths.items() if width}
    (at,) = _MORE.unpack(data[_HEAD.size :])
    streams = data[_HEAD.size - 1]
    begin = at + len(widths) * _ENTRY.size
    if streams != len(widths) or at < len(data) or begin > size:
        raise Error(f"{path}: expected a table of {len(widths)} streams, found another or none")
    extensions = file.read(at - len(data))
    table = file.read(len(widths) * _ENTRY.size)
    attributes: dict[str, Read] = {}
    for (one, width), (packed, unpacked) in zip(widths.items(), _ENTRY.iter_unpack(table)):
        if unpacked != width * head.count or packed > size - begin:
            raise Error(
                f"{path}: expected {width * head.count:,} bytes of {one}, found {unpacked:,} of "
                f"them in {packed:,} bytes as its table says"
            )
        attributes[one] = _Zstd(path, file, begin, packed).read
        begin += packed
    if begin != size:
        raise Error(f"{path}: expected {begin:,} bytes as its table says, found {size:,}")
    left = iter([extensions if head.has_extensions else b""])
    return head, attributes, lambda most: next(left, b"")


class _Zstd:
    """Bytes of a stream of version 4, in bounded pieces."""

    def __init__(self, path: str, file: BinaryIO, begin: int, packed: int) -> None:
        self._path, self._file, self._at, self._left = path, file, begin, packed
        self._library = needs("zstandard", "splats", ".spz files of version 4 need zstandard")
        self._unpacker: Any = None

    def read(self, count: int) -> bytes:
        if self._unpacker is None:
            unpacker = self._library.ZstdDecompressor(max_window_size=_WINDOW)
            self._unpacker = unpacker.stream_reader(_Packed(self), read_size=_AT_ONCE)
        try:
            return _exactly(self._path, self._unpacker.read, count)
        except self._library.ZstdError as error:
            raise Error(f"{self._path}: cannot be unpacked: {error}") from None

    def packed(self, most: int) -> bytes:
        """Of the file: at most so many bytes of this stream."""
        self._file.seek(self._at)
        found = self._file.read(min(most, self._left))
        self._at, self._left = self._at + len(found), self._left - len(found)
        return found


class _Packed:
    """What a stream of Zstandard reads from."""

    def __init__(self, stream: _Zstd) -> None:
        self.read = stream.packed


def _check_rest(path: str, head: _Head, rest: Read) -> None:
    """omma.Error where something comes after the splats that no extension explains."""
    data = b""
    while len(data) < _AT_ONCE and (found := rest(_AT_ONCE)):
        data += found
    if data and not head.has_extensions:
        raise Error(f"{path}: expected the end after {head.count:,} splats, found more bytes")
    while data:
        if len(data) < _RECORD.size:
            raise Error(f"{path}: expected extensions with their lengths, found other bytes")
        kind, length = _RECORD.unpack(data[: _RECORD.size])
        if kind not in _HARMLESS:
            raise Error(
                f"{path}: expected no extensions but camera limits, found the one of number "
                f"0x{kind:08X}, which may say that its splats mean something else"
            )
        if length > len(data) - _RECORD.size:
            raise Error(f"{path}: expected an extension of {length:,} bytes, found its end")
        data = data[_RECORD.size + length :]


def _read_columns(
    path: str, head: _Head, attributes: dict[str, Read], progress: Progress | None
) -> SplatColumns:
    columns = SplatColumns(path, head.count, head.terms)
    done, whole = 0, head.count * sum(head.widths.values())
    for one, width in head.widths.items():
        for start in range(0, head.count if width else 0, PIECE):
            rows = slice(start, min(start + PIECE, head.count))
            data = attributes[one](width * (rows.stop - start))
            _unpack(columns, rows, one, np.frombuffer(data, np.uint8).reshape(-1, width), head)
            done += len(data)
            if progress is not None:
                progress(done / whole)
        if one == "positions":
            _place(columns)
    columns.filled = head.count
    # What the bytes of all else stand for is within reach.
    columns.leave_out_far()
    return columns


def _place(columns: SplatColumns) -> None:
    """Take the offset off, where there is one; single precision has positions of 24 bits."""
    positions = columns.positions
    columns.find_offset(sample_of(positions, len(positions)))
    if columns.offset.any():
        for start in range(0, len(positions), PIECE):
            rows = slice(start, start + PIECE)
            positions[rows] = positions[rows] - columns.offset


def _unpack(
    columns: SplatColumns, rows: slice, attribute: str, data: NDArray[np.uint8], head: _Head
) -> None:
    if attribute == "positions":
        three = data.reshape(-1, 3, 3).astype(np.int32)
        whole = three[..., 0] | three[..., 1] << 8 | three[..., 2] << 16
        whole -= (whole & 0x800000) << 1
        columns.positions[rows] = whole * 2.0**-head.fraction_bits
    elif attribute == "opacities":
        columns.opacities[rows] = data[:, 0] / 255
    elif attribute == "colours":
        columns.harmonics[rows, 0] = (data / 255 - 0.5) / _COLOUR_SCALE
    elif attribute == "scales":
        columns.scales[rows] = np.exp(data / _LOG_SCALE_STEPS - _LOG_SCALE_OFFSET)
    elif attribute == "rotations":
        columns.rotations[rows] = _first_three(data) if head.version == 2 else _smallest_three(data)
    else:
        columns.harmonics[rows, 1:] = (data.reshape(len(data), -1, 3) - 128.0) / 128


def _first_three(data: NDArray[np.uint8]) -> Floats:
    """x, y, z as bytes, and w, which is not below 0, of what they leave."""
    xyz = data / 127.5 - 1
    w = np.sqrt(np.maximum(0, 1 - (xyz**2).sum(axis=1)))
    return _normalised(np.concatenate([xyz, w[:, None]], axis=1))


def _smallest_three(data: NDArray[np.uint8]) -> Floats:
    """Of 32 bits two say which of x, y, z, w is the largest; the others have a sign and 9 bits
    each, the last in the lowest."""
    packed = np.ascontiguousarray(data).view("<u4")[:, 0]
    largest = (packed >> 30).astype(np.int64)
    found = np.empty((len(packed), 4))
    left = packed.copy()
    for k in (3, 2, 1, 0):
        is_stored = largest != k
        size = np.sqrt(0.5) * (left & 511) / _ROTATION_STEPS
        found[:, k] = np.where(is_stored, np.where(left >> 9 & 1, -size, size), 0)
        left = np.where(is_stored, left >> 10, left)
    rest = np.sqrt(np.maximum(0, 1 - (found**2).sum(axis=1)))
    np.put_along_axis(found, largest[:, None], rest[:, None], axis=1)
    return _normalised(found)


def _normalised(quaternions: Floats) -> Floats:
    length: Floats = np.linalg.norm(quaternions, axis=1, keepdims=True)
    return quaternions / length


def _as_bytes(values: NDArray[Any]) -> NDArray[np.uint8]:
    return np.clip(np.round(values), 0, 255).astype(np.uint8)


class SpzWriter:
    """A file of version 3, written in pieces of one attribute after the other."""

    def __init__(self, file: WholeFile, count: int, terms: int, farthest_m: float) -> None:
        """``farthest_m`` is the largest coordinate: as many bits as it leaves are its fraction."""
        if count >= 1 << 31:
            raise Error(f"expected fewer than {1 << 31:,} splats in .spz, found {count:,}")
        largest = float((1 << 23) - 1)
        bits = int(np.floor(np.log2(largest / farthest_m))) if farthest_m > 0 else _FRACTION_BITS
        self._file, self._bits = file, min(bits, _FRACTION_BITS - 1)
        self._packer = zlib.compressobj(6, zlib.DEFLATED, 16 + zlib.MAX_WBITS)
        degree = REST_COUNTS.index(3 * (terms - 1))
        self._write(_HEAD.pack(_MAGIC, 3, count, degree, self._bits, 0, 0))

    def write(self, attribute: str, splats: SplatCloud) -> None:
        """An attribute of some splats."""
        if attribute == "positions":
            whole = np.round(splats.positions_m * 2.0**self._bits).astype("<i4")
            self._write(whole.view(np.uint8).reshape(-1, 3, 4)[..., :3].tobytes())
        elif attribute == "opacities":
            self._write(_as_bytes(splats.opacities * 255.0).tobytes())
        elif attribute == "colours":
            wide = splats.harmonics[:, 0] * (_COLOUR_SCALE * 255) + 127.5
            self._write(_as_bytes(wide).tobytes())
        elif attribute == "scales":
            logs = np.log(splats.scales_m.astype(np.float64)) + _LOG_SCALE_OFFSET
            self._write(_as_bytes(logs * _LOG_SCALE_STEPS).tobytes())
        elif attribute == "rotations":
            self._write(_packed_quaternions(splats.rotations.astype(np.float64)).tobytes())
        else:
            self._write(_as_bytes(splats.harmonics[:, 1:] * 128.0 + 128).tobytes())

    def close(self) -> None:
        self._file.write(self._packer.flush())

    def _write(self, data: bytes) -> None:
        self._file.write(self._packer.compress(data))


ATTRIBUTES = tuple(_Head(3, 0, 1, 0, False).widths)


def _packed_quaternions(quaternions: Floats) -> NDArray[np.uint32]:
    largest = np.abs(quaternions).argmax(axis=1)
    signs = np.take_along_axis(quaternions, largest[:, None], axis=1)
    positive = quaternions * np.where(signs < 0, -1, 1)
    sizes = np.abs(positive) / np.sqrt(0.5) * _ROTATION_STEPS + 0.5
    stored = np.minimum(sizes, _ROTATION_STEPS).astype(np.uint32) | (positive < 0) << 9
    packed: NDArray[np.uint32] = largest.astype(np.uint32)
    for k in range(4):
        packed = np.where(largest == k, packed, packed << 10 | stored[:, k].astype(np.uint32))
    return packed.astype(np.dtype("<u4"))
