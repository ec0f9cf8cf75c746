"""Surfels: points as overlapping discs, of which a surface is seen (Pfister, Zwicker, van Baar &
Gross 2000, Surfels: surface elements as rendering primitives). The engine sees each disc as a
square around it.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Instance, Material, Mesh, Scene
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Floats32
from omma.base.progress import Progress, share_of
from omma.base.warn import warn_caller
from omma.scene.materials import natural_material
from omma.scene.memory import free_bytes, words_for_bytes
from omma.scene.point_files import open_points
from omma.scene.points import PointCloud, Sieve, read_points
from omma.scene.surfel_cells import fitting_voxel_m, in_cells
from omma.scene.surfel_frames import NEIGHBOURS, Frames, distinct, frames_of, tangents

# How much larger a disc is than what would just cover a flat surface. Normals found from
# neighbours are off by some degrees where a surface bends or measurements scatter.
OVERLAP = 1.1
# Memory at most while a scene is made and a world of it, measured (docs/scenes.md).
BYTES_PER_SURFEL = 400
# Of a mesh: what is copied into the engine at once.
_PIECE = 1 << 20
# Of the time from a file to a scene: the share of reading.
_READING = 0.05
# Without colours and intensities.
_GREY = 0.5
# Intensities have no unit: this share of them is below a reflectance of 1.
_BRIGHT = 0.99
# Corners of a square around a disc of radius 1.
_CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float32)
_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


@checked
def surfels(
    cloud: PointCloud,
    *,
    radius_m: float | ArrayLike | None = None,
    overlap: float = OVERLAP,
    normals: ArrayLike | None = None,
    materials: Mapping[int, str | Material] | None = None,
    name: str = "points",
    progress: Progress | None = None,
) -> Scene:
    """A scene in which each point of a cloud is a disc, seen from both sides.

    Discs lie across the normals that the points have, or else across the direction in which their
    12 nearest neighbours spread least, and are as large as covers the surface between neighbours
    without holes. Where points lack a colour their intensity is seen, from 0, or from the least
    where some are below 0, to its 99th percentile, and without that a grey of 0.5. Points of one
    position are one disc.

    Args:
        cloud: the points, of `load_points` or made.
        radius_m: of all discs, or (N,) of each, in place of what the neighbours say.
        overlap: times the radius that neighbours say: 1 just covers a flat surface.
        normals: (N, 3), of any length above 0, in place of the cloud's.
        materials: by label, the name of a natural material (`natural_materials`) or a material of
            your own, which is seen in place of the points' colours: ``{2: "dark soil"}``.
        name: of the instances, by which they move in a world.
        progress: called with the finished share (0 to 1) a few times a second. What it raises ends
            the work and is raised here.

    Example:
        >>> rng = np.random.default_rng(1)
        >>> flat, white = rng.random((1000, 3)) * (1, 0, 1), np.ones((1000, 3))
        >>> ground = omma.scene.PointCloud(flat, colors=white)
        >>> omma.scene.surfels(ground).triangle_count
        2000

    Raises:
        omma.Error: 12 points or fewer without normals and radii; more than fit into memory, with
            how many would; a material that is not known.

    Warns:
        UserWarning: labels without a material, by number, which keep their colours; what there are
            no colours of; normals of no length; points in lines, of which no normal can be told.
    """
    scene, told = make_surfels(cloud, radius_m, overlap, normals, materials, name, progress)
    for sentence in told:
        warn_caller(f"{cloud.path or 'surfels'}: {sentence}", UserWarning)
    return scene


def make_surfels(
    cloud: PointCloud,
    radius_m: float | ArrayLike | None = None,
    overlap: float = OVERLAP,
    normals: ArrayLike | None = None,
    materials: Mapping[int, str | Material] | None = None,
    name: str = "points",
    progress: Progress | None = None,
) -> tuple[Scene, list[str]]:
    """As `surfels`, with what there is to warn of."""
    positive(overlap, "overlap")
    if not len(cloud):
        raise Error("cloud: expected points, found none")
    _check_memory(cloud)
    told: list[str] = []
    order = in_cells(cloud.positions_m)
    if (kept := distinct(cloud.positions_m[order])) is not None:
        told.append(f"{len(order) - len(kept):,} points are left out, as they lie on others")
        order = order[kept]
    frames = _frames(cloud, order, (normals, radius_m), told, progress)
    if radius_m is None:
        frames.radius_m *= np.float32(overlap)
    looks = _looks(cloud, materials, told)
    meshes: list[Mesh] = []
    for index, look in enumerate(looks):
        rows = np.arange(len(order))
        if look.labels is not None and cloud.labels is not None:
            rows = np.flatnonzero(np.isin(cloud.labels[order], look.labels))
        for start in range(0, len(rows), _PIECE):
            some = rows[start : start + _PIECE]
            colors = look.colors_of(cloud, order[some])
            corners = _corners(cloud.positions_m[order[some]], frames, some)
            triangles = (
                _TRIANGLES + len(_CORNERS) * np.arange(len(some), dtype=np.uint32)[:, None, None]
            )
            meshes.append(
                Mesh(corners, triangles.reshape(-1, 3), name=name, colors=colors, material=index)
            )
    placed = np.eye(4)
    placed[:3, 3] = cloud.offset_m
    instances = [Instance(i, placed, name=name) for i in range(len(meshes))]
    materials_of = [look.material for look in looks]
    return Scene(meshes=meshes, instances=instances, materials=materials_of), told


def load_surfels(
    path: str,
    unit: str | float,
    up: str | None,
    voxel_m: float | None = None,
    progress: Progress | None = None,
) -> Scene:
    """The scene of a file of points; what of it was passed over is in its warnings."""
    try:
        sieve = Sieve(open_points(path), unit, up, voxel_m=voxel_m)
        cloud, told = read_points(sieve, share_of(progress, 0, _READING))
        if voxel_m is not None and len(cloud) <= NEIGHBOURS < sieve.kept:
            raise Error(
                f"voxel_m: expected cells small enough to leave more than {NEIGHBOURS} of "
                f"{sieve.kept:,} points, found {voxel_m:g}, which leaves {len(cloud)}"
            )
        rest = share_of(progress, _READING, 1)
        scene, more = make_surfels(cloud, name=os.path.basename(path), progress=rest)
    except MemoryError:
        raise Error(f"{path}: it takes more memory than there is") from None
    except Error as error:
        raise error if str(error).startswith(path) else Error(f"{path}: {error}") from None
    return _core.with_path(scene, path, [*told, *more])


def _frames(
    cloud: PointCloud,
    order: NDArray[np.intp],
    wanted: tuple[ArrayLike | None, float | ArrayLike | None],
    told: list[str],
    progress: Progress | None,
) -> Frames:
    """Normals and radii of the points in that order, those ``wanted`` or from neighbours."""
    count = len(cloud)
    normals, radius_m = wanted
    given = cloud.normals
    if normals is not None:
        given = array_of(normals, "normals", (count, 3), np.float32, finite=True)
    radius: Floats32 | None = None
    if radius_m is not None:
        one_each = np.full(count, radius_m) if np.ndim(radius_m) == 0 else radius_m
        radius = array_of(one_each, "radius_m", (count,), np.float32)[order]
        if not (np.isfinite(radius) & (radius > 0)).all():
            raise Error("radius_m: expected numbers above 0")
    given = None if given is None else given[order]
    if given is not None and radius is not None and given.any(axis=1).all():
        length = np.linalg.norm(given.astype(np.float64), axis=1, keepdims=True)
        return Frames((given / length).astype(np.float32), radius, 0, 0)
    frames = frames_of(cloud.positions_m[order], given, cloud.scanners_m, progress)
    if radius is not None:
        frames.radius_m = radius.copy()
    if frames.without_length:
        told.append(
            f"{frames.without_length:,} normals have no length; they are found from neighbours"
        )
    if frames.in_a_line:
        told.append(
            f"the neighbours of {frames.in_a_line:,} points lie in a line, which says no normal; "
            "where lines are denser along than across, thin the points by voxel_m"
        )
    return frames


@dataclass
class _Look:
    """What points of some labels look like; labels None: all. With ``shown`` None they have the
    material's own colour."""

    material: Material
    labels: list[int] | None
    shown: str | None = None
    black: float = 0.0  # of intensities
    white: float = 1.0

    def colors_of(self, cloud: PointCloud, rows: NDArray[np.intp]) -> Floats32 | None:
        """Of the corners of these points' discs: (4 n, 3)."""
        if self.shown is None:
            return None
        values: Floats32 = getattr(cloud, self.shown)[rows]
        if values.ndim == 1:
            shares = (values - np.float32(self.black)) / np.float32(self.white - self.black)
            values = np.repeat(np.clip(shares, 0, 1)[:, None], 3, axis=1)
        return np.repeat(values, len(_CORNERS), axis=0)


def _looks(
    cloud: PointCloud, materials: Mapping[int, str | Material] | None, told: list[str]
) -> list[_Look]:
    if materials is not None and cloud.labels is None:
        raise Error("materials: expected a cloud with labels, found none")
    chosen = {
        int(label): natural_material(one) if isinstance(one, str) else one
        for label, one in (materials or {}).items()
    }
    looks: list[_Look] = []
    left: list[int] | None = None
    if chosen and cloud.labels is not None:
        there, counts = (one.tolist() for one in np.unique(cloud.labels, return_counts=True))
        looks = [
            _Look(one.replace(double_sided=True), [label])
            for label, one in chosen.items()
            if label in there
        ]
        number = dict(zip(there, counts))
        left = [label for label in there if label not in chosen]
        if left:
            listed = ", ".join(f"{label} ({number[label]:,})" for label in left)
            told.append(f"points of labels without a material keep their colours: {listed}")
        if missing := [str(label) for label in chosen if label not in there]:
            told.append(f"there are no points of the labels {', '.join(missing)}")
    if left is None or left:
        looks.append(_own_colors(cloud, left, told))
    return looks


def _own_colors(cloud: PointCloud, labels: list[int] | None, told: list[str]) -> _Look:
    """Colours of the points, else their intensities, else grey."""
    plain = Material("points", double_sided=True)
    if cloud.colors is not None:
        return _Look(plain, labels, "colors")
    if cloud.intensity is None:
        told.append(f"it has no colours and no intensities: its points are grey, {_GREY}")
        return _Look(plain.replace(base_color=(_GREY, _GREY, _GREY)), labels)
    black, white = _ends_of(cloud.intensity)
    if black < white:
        least = f"{black:g} as black, " if black else ""
        told.append(f"it has no colours: intensities are seen, {least}{white:g} and above as white")
        return _Look(plain, labels, "intensity", black, white)
    told.append(
        f"it has no colours, and all its intensities are {white:g}: its points are grey, {_GREY}"
    )
    return _Look(plain.replace(base_color=(_GREY, _GREY, _GREY)), labels)


def _ends_of(intensity: Floats32) -> tuple[float, float]:
    """What is black and what is white: 0, or the least where some are below, and what few exceed;
    twice the same where there is no difference to be seen."""
    least, greatest = float(intensity.min()), float(intensity.max())
    if least >= 0:
        some = intensity[intensity > 0]
        return 0.0, float(np.quantile(some, _BRIGHT)) if len(some) else 0.0
    white = float(np.quantile(intensity, _BRIGHT))
    return least, white if white > least else greatest


def _corners(positions: Floats32, frames: Frames, rows: NDArray[np.intp]) -> Floats32:
    """Of the squares around discs: (4 n, 3)."""
    u, v = tangents(frames.normals[rows])
    radius = frames.radius_m[rows, None, None]
    across = _CORNERS[:, :1] * u[:, None] + _CORNERS[:, 1:] * v[:, None]
    return (positions[:, None] + radius * across).reshape(-1, 3)


def _check_memory(cloud: PointCloud) -> None:
    """omma.Error where the surfels would not fit, with how many would and how to thin them."""
    free = free_bytes()
    needed = len(cloud) * BYTES_PER_SURFEL
    if needed <= free:
        return
    fit = int(free / BYTES_PER_SURFEL)
    hint = f"voxel_m={fitting_voxel_m(cloud.positions_m, fit):.2g}" if fit else "voxel_m"
    raise Error(
        f"{cloud.path or 'cloud'}: {len(cloud):,} points take some {words_for_bytes(needed)} as "
        f"surfels and a world of them, of which {words_for_bytes(free)} are free: {fit:,} would "
        f"fit; thin them by {hint}"
    )
