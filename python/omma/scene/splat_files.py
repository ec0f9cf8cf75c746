"""Gaussian splats from files, and in files: .ply as 3DGS has them, .spz."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error, Scene, SplatCloud
from omma.base.addresses import expect_local
from omma.base.arguments import checked
from omma.base.files import PathLike, WholeFiles, check_ending, reading_told
from omma.base.mesh_parts import world_from_file
from omma.base.progress import Progress
from omma.base.warn import warn_caller
from omma.scene.point_files import holds_splats, ply_head
from omma.scene.splat_columns import (
    PIECE,
    SplatColumns,
    chosen,
    expect_file,
    offset_of_splats,
    sample_of,
)
from omma.scene.splat_harmonics import moved_splats
from omma.scene.splat_ply import ply_header_of, read_ply_splats, write_ply_rows
from omma.scene.splat_spz import ATTRIBUTES, SpzWriter, read_spz_splats

SPLAT_FILES = (".ply", ".spz")
# Of viewers in browsers.
_OTHER_SPLATS = (".splat", ".ksplat", ".sog")
# Which axis points up where nobody says it: x right, y down, z ahead as in COLMAP's cameras, from
# which 3DGS trains; .spz files are x right, y up, z back by their specification.
_UP = {".ply": "-y", ".spz": "y"}


def is_splat_file(path: PathLike) -> bool:
    """Whether a file holds Gaussian splats: by its ending, a PLY file by what its vertices have."""
    name = os.fsdecode(path)
    ending = Path(name).suffix.lower()
    if ending == ".ply" and os.path.isfile(name):
        return holds_splats(ply_head(name)[1])
    return ending == ".spz"


def refuse_other_splats(path: PathLike) -> None:
    """omma.Error where a file is one of splats in a form that is not read, by its ending."""
    name = os.fsdecode(path)
    ending = Path(name).suffix.lower()
    if ending in _OTHER_SPLATS:
        raise Error(
            f"{name}: expected Gaussian splats as .ply or .spz, found {ending}, another form of "
            "them, which is not read; convert it, as with SuperSplat or splat-transform"
        )


def read_splats(
    path: PathLike,
    progress: Progress | None = None,
    *,
    unit: str | float = "m",
    up: str | None = None,
) -> tuple[SplatCloud, list[str]]:
    """As `load_splats`, with what there is to warn of, for those who say so themselves."""
    name = os.fsdecode(path)
    refuse_other_splats(name)
    check_ending(name, *SPLAT_FILES)
    expect_file(name)
    ending = Path(name).suffix.lower()
    placed = world_from_file(unit, _UP[ending] if up is None else up)
    with reading_told(name, "Gaussian splats", progress) as told:
        read = read_spz_splats if ending == ".spz" else read_ply_splats
        columns: SplatColumns = read(name, told)
        return columns.splats(placed, Path(name).stem), columns.told()


@checked
def load_splats(
    path: PathLike,
    *,
    unit: str | float = "m",
    up: str | None = None,
    progress: Progress | None = None,
) -> SplatCloud:
    """Read the Gaussian splats of a `.ply` file as 3DGS, PlayCanvas or Mip-Splatting write it, or
    of an `.spz` file of version 2, 3 or 4 (4 needs zstandard: `pip install 'omma[splats]'`).

    `omma.load_scene` makes a scene of them at once. Numbers stay in the file's own frame and unit,
    in which harmonics are meant; ``world_from_splats`` brings them into the world. What positions
    far from zero have in common, as in UTM or coordinates of the whole earth, is taken off on
    loading and put there too, so that poses are in the file's own coordinates and all digits of
    text and double precision are kept. Colours are sRGB, harmonics along the direction to the
    middle of a splat, as 3DGS trains them. An opacity whose logit is infinite is 0 or 1. Splats
    that are none, or out of reach, are left out: numbers that are not finite, positions beyond 1e6
    from what was taken off, scales below 1e-12 or above 1e6, harmonics beyond 1e4, quaternions of
    length 0.

    Args:
        path: the file.
        unit: of its lengths: "m", "mm", "um" or a number of metres. What a camera's pictures tell
            has no scale of its own.
        up: the axis that points up in it: "y", "z" or "-y". None: -y in `.ply` files (y down, z
            ahead, as COLMAP and 3DGS have it), y in `.spz` files.
        progress: called with the finished share (0 to 1) after each piece. What it raises ends the
            reading and is raised here.

    Example:
        >>> cloud = omma.scene.SplatCloud(
        ...     [(0, 0, -1)], [(0.1, 0.1, 0.1)], [(0, 0, 0, 1)], [1.0], np.zeros((1, 1, 3))
        ... )
        >>> omma.scene.save_splats("one.ply", cloud)
        >>> omma.scene.load_splats("one.ply")
        <omma.scene.SplatCloud 'one' of 1 splats>

    Raises:
        omma.Error: the file is missing, cut off or broken, lacks something, holds no splats that
            can be used or more than fit into memory; it names the file and what is wrong.

    Warns:
        UserWarning: splats that were left out, by number and reason; positions that single
            precision has rounded in the file, by how much.
    """
    cloud, told = read_splats(path, progress, unit=unit, up=up)
    for sentence in told:
        warn_caller(f"{os.fsdecode(path)}: {sentence}", UserWarning)
    return cloud


def load_splat_scene(
    path: str, unit: str | float, up: str | None, progress: Progress | None
) -> Scene:
    """The scene of a file of splats; what there is to warn of is in its warnings."""
    cloud, told = read_splats(path, progress, unit=unit, up=up)
    scene = Scene(splats=[cloud])
    del cloud  # before the scene is copied: memory is looked for that holds a cloud twice
    return _core.with_path(scene, path, told)


@checked
def save_splats(path: PathLike, splats: SplatCloud) -> None:
    """Write Gaussian splats as a `.ply` file, little-endian as 3DGS has it, or an `.spz` file of
    version 3. The file is there whole or not at all.

    They are written in metres in the frame that these files have by custom (`load_splats`).
    `.ply` keeps single precision, and positions in double precision where single would round splats
    far from the origin. `.spz` rounds: positions to the finest step that 24 bits leave, scales to
    3 % of 45 um to 380 m, opacities to 1/255, harmonics to 1/128 between -1 and 1, what is beyond
    being cut; so is the constant term beyond 3.3.

    Args:
        path: the file, whose name ends in .ply or .spz.
        splats: what to write.

    Raises:
        omma.Error: another ending; no splats; linear colours, harmonics along rays or a white other
            than 1, which these files cannot say (`omma.scene.save_scene` can); splats placed by a
            matrix that mirrors, or stretches more one way than another; splats out of reach in
            metres (`load_splats`), or in `.spz` so far from the origin that its steps would be
            seen; the system refuses.
    """
    name = expect_local(path, "a file of splats")
    check_ending(name, *SPLAT_FILES)
    ending = Path(name).suffix.lower()
    if splats.color_space != "srgb" or splats.direction != "center":
        raise Error(
            f'{name}: expected splats of color_space "srgb" and direction "center", as {ending} '
            f"files have no others, found {splats.color_space} and {splats.direction}"
        )
    if splats.white != (1, 1, 1):
        raise Error(
            f"{name}: expected splats of white 1, as {ending} files have no other, found "
            f"{splats.white}: give splats.replace(white=(1, 1, 1))"
        )
    if not len(splats.positions_m):
        raise Error(f"{name}: expected Gaussian splats, found none")
    terms = splats.harmonics.shape[1]
    frame = np.linalg.inv(world_from_file("m", _UP[ending])) @ splats.world_from_splats
    # Pieces are near zero, and what is added to their positions is of double precision.
    some = sample_of(splats.positions_m, len(splats.positions_m))
    offset = offset_of_splats(some @ frame[:3, :3].T + frame[:3, 3])
    near = frame.copy()
    near[:3, 3] -= offset
    with WholeFiles() as files, _naming(name):
        file = files.open(name)
        if ending == ".ply":
            file.write(ply_header_of(len(splats.positions_m), terms, is_far=bool(offset.any())))
            for piece in _pieces(splats, near):
                write_ply_rows(file, piece, offset)
            return
        if offset.any():
            step = np.abs(offset).max() * 2.0**-23
            raise Error(
                f"expected splats about the origin, as .spz has 24 bits for a position, found them "
                f"{np.abs(offset).max():.3g} m away, where its steps are {step:.2g} m; write .ply, "
                "or place them nearer by splats.replace(world_from_splats=...)"
            )
        # All but harmonics, which are most of the work, of splats without them.
        plain = splats.replace(harmonics=splats.harmonics[:, :1])
        farthest = max(float(np.abs(one.positions_m).max()) for one in _pieces(plain, frame))
        writer = SpzWriter(file, len(splats.positions_m), terms, farthest)
        for attribute in ATTRIBUTES:
            for piece in _pieces(splats if attribute == "harmonics" else plain, frame):
                writer.write(attribute, piece)
        writer.close()


@contextmanager
def _naming(name: str) -> Iterator[None]:
    """Errors inside name the file."""
    try:
        yield
    except Error as error:
        raise error if str(error).startswith(name) else Error(f"{name}: {error}") from None


def _pieces(splats: SplatCloud, frame: NDArray[np.float64]) -> Iterator[SplatCloud]:
    """Some splats at a time, in the file's frame."""
    for start in range(0, len(splats.positions_m), PIECE):
        try:
            piece = moved_splats(chosen(splats, slice(start, start + PIECE)), frame)
        except Error as error:
            raise Error(_counted_from(start, str(error))) from None
        yield piece


def _counted_from(start: int, message: str) -> str:
    """A message about splats of a piece, about those of the cloud, of which it begins there."""
    return re.sub(r"(?<=: splat )\d+", lambda one: f"{start + int(one[0])}", message)
