"""Gaussian splats from files, and in files: .ply as 3DGS has them, .spz."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import one_of
from omma.base.files import PathLike, WholeFiles, check_ending, reading
from omma.base.progress import Progress
from omma.scene.point_files import holds_splats, ply_head
from omma.scene.splat_arrays import SplatArrays
from omma.scene.splat_columns import PIECE, expect_file, world_from_cloud
from omma.scene.splat_harmonics import moved_splats
from omma.scene.splat_ply import ply_header_of, read_ply_splats, write_ply_rows
from omma.scene.splat_spz import ATTRIBUTES, SpzWriter, read_spz_splats

SPLAT_FILES = (".ply", ".spz")
# Which axis points up where nobody says it: x right, y down, z ahead as in COLMAP's cameras, from
# which 3DGS trains; .spz files are x right, y up, z back by their specification.
_UP = {".ply": "-y", ".spz": "y"}
_AXES = ("-y", "y", "z")


def is_splat_file(path: PathLike) -> bool:
    """Whether a file holds Gaussian splats: by its ending, a PLY file by what its vertices have."""
    name = os.fsdecode(path)
    ending = Path(name).suffix.lower()
    if ending == ".ply" and os.path.isfile(name):
        return holds_splats(ply_head(name)[1])
    return ending == ".spz"


def read_splats(
    path: PathLike,
    progress: Progress | None = None,
    *,
    unit: str | float = "m",
    up: str | None = None,
) -> SplatArrays:
    """Read the Gaussian splats of a `.ply` file as 3DGS, PlayCanvas or Mip-Splatting write it, or
    of an `.spz` file of version 2, 3 or 4 (4 needs zstandard: `pip install 'omma[splats]'`).

    Numbers stay in the file's own frame and unit, in which harmonics are meant;
    ``world_from_splats`` brings them into the world. Colours are sRGB, harmonics along the
    direction to a Gaussian's centre, as 3DGS trains them. Splats that are no Gaussians (numbers
    that are not finite, scales of 0, quaternions of length 0) are left out and counted in
    ``left_out``. An opacity whose logit is infinite is 0 or 1, which programs write.

    Args:
        path: the file.
        progress: called with the finished share (0 to 1) after each piece. What it raises ends the
            reading and is raised here.
        unit: of lengths: "m", "mm", "um" or a number of metres. What a camera's pictures tell has
            no scale of its own.
        up: the axis that points up in the file: "-y", "y" or "z". None: -y in `.ply` files (y
            down, z ahead, as COLMAP and 3DGS have it and viewers take it), y in `.spz` files.

    Raises:
        omma.Error: the file is missing, cut off or broken, lacks something, holds no splats that
            can be used or more than fit into memory; it names the file and what is wrong.
    """
    name = os.fsdecode(path)
    check_ending(name, *SPLAT_FILES)
    expect_file(name)
    ending = Path(name).suffix.lower()
    axis = _UP[ending] if up is None else one_of(up, _AXES, "up")
    placed = world_from_cloud(unit, axis)
    raised: list[BaseException] = []

    def tell(share: float) -> None:
        # What the caller raises is the caller's, not the file's fault.
        try:
            assert progress is not None
            progress(share)
        except BaseException as error:
            raised.append(error)
            raise

    told = None if progress is None else tell
    try:
        with reading(name, "Gaussian splats"):
            if ending == ".spz":
                return read_spz_splats(name, placed, Path(name).stem, told)
            return read_ply_splats(name, placed, told)
    except Error:
        if raised:
            raise raised[0] from None
        raise


def write_splats(path: PathLike, splats: SplatArrays) -> None:
    """Write Gaussian splats as a `.ply` file, little-endian as 3DGS has it, or an `.spz` file of
    version 3. The file is there whole or not at all.

    They are written in metres in the frame that these files have by custom (`read_splats`), in
    which `.ply` keeps single precision. `.spz` rounds: positions to the finest step that 24 bits
    leave, scales to 3 % of 45 um to 380 m, opacities to 1/255, harmonics to 1/128 between -1 and 1,
    what is beyond being cut; so is the constant term beyond 3.3.

    Raises:
        omma.Error: another ending; linear colours or harmonics along rays, which these files
            cannot say; splats placed by a matrix that mirrors, or stretches more one way than
            another; the system refuses.
    """
    name = os.fsdecode(path)
    check_ending(name, *SPLAT_FILES)
    ending = Path(name).suffix.lower()
    if splats.color_space != "srgb" or splats.direction != "center":
        raise Error(
            f'{name}: expected splats of color_space "srgb" and direction "center", as {ending} '
            f"files have no others, found {splats.color_space} and {splats.direction}"
        )
    terms = splats.harmonics.shape[1]
    frame = np.linalg.inv(world_from_cloud("m", _UP[ending])) @ splats.world_from_splats
    with WholeFiles() as files:
        file = files.open(name)
        if ending == ".ply":
            file.write(ply_header_of(len(splats), terms))
            for piece in _pieces(splats, frame):
                write_ply_rows(file, piece)
            return
        # All but harmonics, which are most of the work, of splats without them.
        plain = dataclasses.replace(splats, harmonics=splats.harmonics[:, :1])
        farthest = max(
            (float(np.abs(one.positions).max()) for one in _pieces(plain, frame)), default=0.0
        )
        try:
            writer = SpzWriter(file, len(splats), terms, farthest)
        except Error as error:
            raise Error(f"{name}: {error}") from None
        for attribute in ATTRIBUTES:
            for piece in _pieces(splats if attribute == "harmonics" else plain, frame):
                writer.write(attribute, piece)
        writer.close()


def _pieces(splats: SplatArrays, frame: NDArray[np.float64]) -> Iterator[SplatArrays]:
    """Some splats at a time, in the file's frame."""
    for start in range(0, len(splats), PIECE):
        yield moved_splats(splats.chosen(slice(start, start + PIECE)), frame)
