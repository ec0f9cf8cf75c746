"""What a panorama's file says of itself, in Google's Photo Sphere metadata: GPano, in XMP. Phones,
360° cameras and stitching programs write how much of the sphere a picture is, and how the camera
was held (https://developers.google.com/streetview/spherical-metadata).
"""

from __future__ import annotations

import os
import re
import zlib
from typing import NamedTuple

from omma._core import Error, Image
from omma.base.files import PathLike
from omma.base.picture_blocks import BlockNames, picture_blocks
from omma.base.warn import warn_caller

_XMP = BlockNames(b"http://ns.adobe.com/xap/1.0/\0", b"iTXt", b"XMP ")
# How a block of PNG begins that is XMP; whether it is packed, and two more texts, come next.
_PNG_KEYWORD = b"XML:com.adobe.xmp\0"
_MOST_BYTES = 1 << 24
# Numbers are pixels and degrees.
_MOST = 1e9
_NAMESPACE = re.compile(
    r"xmlns:([\w.-]+)\s*=\s*[\"']http://ns\.google\.com/photos/1\.0/panorama/?[\"']"
)


class Gpano(NamedTuple):
    """What a file says; None and 0 of what it does not say."""

    projection: str | None
    size: tuple[int, int] | None  # of what is shown: width, height
    full: tuple[int, int] | None  # of the whole sphere, in the same pixels
    corner: tuple[int, int]  # of what is shown: column, row
    pose_deg: tuple[float, float, float]  # of its middle: heading, pitch, roll

    def part(self, width: int, height: int) -> str | None:
        """How much of the sphere a picture of that size is, in words; None: all. One that is as
        large as the whole has been padded."""
        if self.size is None or self.full is None or {width, height} == {*self.full}:
            return None
        if all(abs(a - b) <= 1 for a, b in zip(self.size, self.full)):
            return None
        shown, full = (f"{one[0]:,} x {one[1]:,}" for one in (self.size, self.full))
        column, row = self.corner
        return f"{shown} of {full} pixels, from column {column:,} and row {row:,}"

    @property
    def is_equirectangular(self) -> bool:
        """Whether it is, as far as is said."""
        return self.projection is None or self.projection.lower() == "equirectangular"

    @property
    def pose(self) -> str | None:
        """How the camera was held, in words; None: level and heading north, or not said."""
        if not any(self.pose_deg):
            return None
        return ", ".join(
            f"{name} {angle:g}°" for name, angle in zip(("heading", "pitch", "roll"), self.pose_deg)
        )


def gpano_of(path: PathLike) -> Gpano | None:
    """What a JPEG, PNG or WebP file says of itself as a panorama; None where it says nothing, or
    cannot be read, which is told where its pixels are."""
    try:
        with open(path, "rb") as file:
            packets = [_text_of(block) for block in picture_blocks(file, _XMP)]
    except OSError:
        return None
    for packet in packets:
        prefix = _NAMESPACE.search(packet)
        if prefix is not None:
            return _said(packet, prefix[1])
    return None


def expect_whole_sphere(path: PathLike, image: Image) -> None:
    """omma.Error where a file says that its picture is not all of the sphere, or no equirectangular
    one; the caller of the package is told of a camera that was turned or tilted."""
    said = gpano_of(path)
    if said is None:
        return
    name = os.fsdecode(path)
    if not said.is_equirectangular:
        raise Error(
            f"{name}: expected an equirectangular picture, found one that its GPano (XMP) calls "
            f"{said.projection!r:.40}: make it equirectangular, as Hugin does; six faces of a cube "
            "and a fisheye's are for omma.rendering.see_panorama(layout=...)"
        )
    height, width = image.pixels.shape[:2]
    part = said.part(width, height)
    if part is not None:
        raise Error(
            f"{name}: expected a picture of the whole sphere, found a part of it, as its GPano "
            f"(XMP) says: {part}; put its pixels there into an array of the whole, of NaN for "
            "omma.rendering.see_panorama, in which that is not known, or of a colour"
        )
    if said.pose is not None:
        angles = ", ".join(f"{angle:g}" for angle in said.pose_deg)
        warn_caller(
            f"{name}: its GPano (XMP) says how its middle was turned, {said.pose}, which is not "
            "applied: its middle is straight ahead (-Z); heads are turned into it by "
            f"np.linalg.inv(omma.poses_from_angles((0, 0, 0), ({angles}))[0]) @ world_from_head",
            UserWarning,
        )


def _text_of(block: bytes) -> str:
    """The packet of XMP in a block; empty where it is another text of PNG."""
    if block.startswith(_PNG_KEYWORD):
        rest = block[len(_PNG_KEYWORD) :]
        is_packed, *texts = rest[:1] == b"\1", *rest[2:].split(b"\0", 2)
        block = texts[-1]
        if is_packed:
            try:
                block = zlib.decompressobj().decompress(block, _MOST_BYTES)
            except zlib.error:
                return ""
    return block.decode("utf-8", "replace")


def _said(packet: str, prefix: str) -> Gpano:
    def text(name: str) -> str | None:
        """Of an attribute, or of an element."""
        found = re.search(
            rf"\b{re.escape(prefix)}:{name}(?:\s*=\s*[\"']|[^<>\"']*>)\s*([^<>\"']*)", packet
        )
        return found[1].strip() or None if found is not None else None

    def number(name: str) -> float:
        try:
            value = float(text(name) or 0)
        except ValueError:
            return 0.0
        return value if abs(value) < _MOST else 0.0  # nor is NaN

    def two(first: str, second: str) -> tuple[int, int]:
        return round(number(first)), round(number(second))

    def size(first: str, second: str) -> tuple[int, int] | None:
        found = two(first, second)
        return found if min(found) > 0 else None

    heading, pitch, roll = (number(f"Pose{one}Degrees") for one in ("Heading", "Pitch", "Roll"))
    return Gpano(
        text("ProjectionType"),
        size("CroppedAreaImageWidthPixels", "CroppedAreaImageHeightPixels"),
        size("FullPanoWidthPixels", "FullPanoHeightPixels"),
        two("CroppedAreaLeftPixels", "CroppedAreaTopPixels"),
        (heading % 360, pitch, roll),
    )
