"""Baked light: how it is asked for, what came of it, and where it comes from, bake or cache."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from omma import _core
from omma._core import Error, Scene
from omma.base.arguments import positive, whole
from omma.base.progress import Progress, without_share
from omma.base.values import value_class
from omma.base.warn import warn_caller
from omma.scene.baked_files import (
    cache_directory,
    keep_unfinished,
    read_baked_light,
    read_unfinished,
    scene_digest,
    world_key,
    write_baked_light,
)

_PATHS_AT_ONCE, _MOST_PATHS = 16, 65536
# Both sides of a cell, 16 bits a band.
_BYTES_OF_BAND = 4


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Bake:
    """How light is baked (docs/light.md).

    Args:
        cell_m: longest edge of the cells into which large triangles are divided, m; each edge into
            1,024 parts at most. None: chosen by the scene, for at most some 32,000 cells more than
            five times its triangles, and the larger the larger their triangles are.
        paths: of light for each side of a cell: a multiple of 16 up to 65,536. Noise of what is
            baked halves with four times as many, which take four times as long. None: more where
            there is more noise, 12 in the mean of large scenes.
        most_bytes: that cells take, 4 for each band of a cell. Triangles without room are lit by a
            coarse grid of probes.
        seed: of its random numbers, 0 to 2^32 - 1.
        cache: keep what is baked in the user's cache folder, and look for it there; a folder to
            use that one; False to do neither.

    Raises:
        omma.Error: a number is out of its range.
        TypeError: an argument is of another type.
    """

    cell_m: float | None = None
    paths: int | None = None
    most_bytes: int = 1 << 30
    seed: int = 0
    cache: bool | str | os.PathLike[str] = True

    def __post_init__(self) -> None:
        if self.cell_m is not None:
            object.__setattr__(self, "cell_m", positive(self.cell_m, "cell_m"))
        if self.paths is not None:
            paths = whole(self.paths, "paths", _PATHS_AT_ONCE, _MOST_PATHS)
            if paths % _PATHS_AT_ONCE != 0:
                raise Error(f"paths: expected a multiple of {_PATHS_AT_ONCE}, found {paths}")
            object.__setattr__(self, "paths", paths)
        object.__setattr__(self, "seed", whole(self.seed, "seed", 0, (1 << 32) - 1))
        object.__setattr__(self, "most_bytes", whole(self.most_bytes, "most_bytes", 0, 1 << 50))
        if not isinstance(self.cache, (bool, str, os.PathLike)):
            raise TypeError(
                f"cache: expected True, False or a folder, found {type(self.cache).__name__}"
            )


def _percent(fraction: float) -> str:
    return f"{float(f'{100 * fraction:.2g}'):g} %"


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class BakedInfo:
    """What was baked for a world.

    cells: that light is kept for, both sides of each.
    cell_m: the longest edge of a cell, m.
    paths: of light for each side of a cell, in the mean.
    error_median, error_95: standard errors of the light at points of cells, as fractions of it:
        half of them have less, and 95 in 100. Of noise, and of what light varies by within a cell,
        which is kept as one value.
    bytes: of memory.
    triangles_by_probes: that have no room for cells; things that have moved are not counted.
    seconds: that the bake took, also where it was read from the cache.
    from_cache: whether it was read from there.
    """

    cells: int
    cell_m: float
    paths: float
    error_median: float
    error_95: float
    bytes: int
    triangles_by_probes: int
    seconds: float
    from_cache: bool

    def __str__(self) -> str:
        source = "from the cache, was baked" if self.from_cache else "baked"
        probes = (
            f", {self.triangles_by_probes:,} triangles lit by probes"
            if self.triangles_by_probes
            else ""
        )
        return (
            f"{self.cells:,} cells of at most {self.cell_m:.3g} m, {self.paths:.3g} paths a side, "
            f"errors of cells {_percent(self.error_median)} (95 % below "
            f"{_percent(self.error_95)}), {self.bytes / 1e6:,.1f} MB, "
            f"{source} in {self.seconds:.1f} s{probes}"
        )


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class BakeCost:
    """What a bake takes, about (`omma.World.bake_cost`).

    cells: that light would be kept for, both sides of each.
    bytes: of memory; five times as much while it is baked.
    seconds: on this world's threads, at most: where light has little noise it ends sooner.
    triangles_by_probes: that would have no room for cells.
    """

    cells: int
    bytes: int
    seconds: float
    triangles_by_probes: int

    def __str__(self) -> str:
        return (
            f"{self.cells:,} cells, {self.bytes / 1e6:,.0f} MB (five times as much on the way), "
            f"up to {self.seconds:,.0f} s"
        )


def find_baked_light(
    engine: _core.World,
    scene: Scene,
    light: dict[str, Any],
    bake: Bake,
    progress: Progress | None,
) -> tuple[_core.BakedLight, BakedInfo]:
    """The baked light of a world that is lit by paths: of the cache, or baked and put there.

    Args:
        light: the arguments of the engine's light.
        progress: called with the finished share (0 to 1); where it has a method ``begins``, that is
            called with the cost before anything is baked.

    Warns:
        UserWarning: triangles had no room, or the cache cannot be written to.
    """
    directory = cache_directory(bake.cache)
    key, baked = "", None
    if directory is not None:
        settings = (bake.cell_m, bake.paths, bake.most_bytes, bake.seed)
        key = world_key(engine, scene_digest(scene), light, settings)
        baked = read_baked_light(directory, key)
    from_cache = baked is not None
    if baked is None:
        unfinished = None if directory is None else read_unfinished(directory, key)
        begins = getattr(progress, "begins", None)
        if begins is not None:
            begins(bake_cost(engine, bake, progress))
        try:
            baked = _core.bake_light(
                engine,
                bake.cell_m or 0.0,
                bake.paths or 0,
                bake.most_bytes,
                bake.seed,
                progress,
                unfinished,
            )
        except Error:
            raise
        except BaseException as error:
            # As add_note, which Python has from 3.11 on.
            error.__notes__ = [_what_is_kept(directory, key, unfinished)]  # type: ignore[attr-defined]
            raise
        if directory is not None:
            write_baked_light(directory, key, baked)
    elif progress is not None:
        progress(1.0)
    if baked.by_probes > 0:
        warn_caller(_without_room(baked, scene, bake, engine.bands), UserWarning)
    return baked, BakedInfo(
        baked.cells,
        baked.cell_m,
        baked.paths,
        baked.error_median,
        baked.error_95,
        baked.bytes,
        baked.by_probes,
        baked.seconds,
        from_cache,
    )


def bake_cost(engine: _core.World, bake: Bake, progress: Progress | None = None) -> BakeCost:
    """What baking a world that is lit by paths would take; `omma.World.bake_cost`. ``progress`` is
    told of nothing finished meanwhile."""
    told = without_share(progress)
    cells, by_probes, size, seconds = _core.bake_cost(
        engine, bake.cell_m or 0.0, bake.paths or 0, bake.most_bytes, told
    )
    return BakeCost(cells, size, seconds, by_probes)


def _what_is_kept(directory: Path | None, key: str, unfinished: _core.UnfinishedBake | None) -> str:
    if directory is None or unfinished is None:
        return "of the light that was being baked nothing is kept, as there is no cache"
    share = unfinished.share
    if not share > 0 or not keep_unfinished(directory, key, unfinished):
        return "of the light that was being baked nothing is kept"
    return (
        f"some {100 * share:.0f} % of the light that was being baked are kept in {directory}, and "
        "baking the same goes on from there"
    )


def _without_room(baked: _core.BakedLight, scene: Scene, bake: Bake, bands: int) -> str:
    of_mesh = np.array([len(mesh.triangles) for mesh in scene.meshes])
    triangles = int(sum(of_mesh[instance.mesh] for instance in scene.instances))
    return (
        f"baked light: {baked.by_probes:,} of {triangles:,} triangles have no room in "
        f"{bake.most_bytes:,} bytes and are lit by a coarse grid of probes; for a cell on each it "
        f"takes omma.scene.Bake(most_bytes={_BYTES_OF_BAND * bands * triangles})"
    )
