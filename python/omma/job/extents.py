"""How large what is in a file is, in words, and what is odd about it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Scene, SplatCloud
from omma.base.arrays import Floats
from omma.scene.mesh_files import MESH_FILES

# What is so many metres long at most.
_LONG = (
    (0.05, "an insect or a leaf"), (0.5, "a thing on a table"), (3, "a shrub or a piece of ground"),
    (30, "a tree, a room or a plot"), (300, "a garden, a house or a field"),
    (10_000, "a landscape"), (np.inf, "a region"),
)  # fmt: skip
# Longer than this, m, a thing may well be in millimetres: of meshes and of points that do not say
# their unit; of glTF, which is in metres, if not always; and of all that say it.
_LONG_MESH_M, LONG_POINTS_M, _LONG_GLTF_M, ODD_M = 30.0, 300.0, 1_000.0, 10_000.0
# A place is so much wider than high, where up is up. Thinner than this share of what it is high and
# wide a thing is a picture or a card, and cameras whose up has this share of +Y are upright.
_FLAT, _CARD, _UPRIGHT = 3.0, 0.01, 0.7
# Less than this share of the largest length is rounding.
_ROUNDING = 1e-9
# Two standard deviations on both sides.
_SEEN_SIGMAS = 4


def describe_extent(
    size_m: NDArray[np.floating],
    *,
    may_be_mm_above: float = ODD_M,
    up: str | None = "y",
    thing_m: float = 0.0,
) -> str:
    """Of a box (3,), m, along x, y and z: its size, what is so large, and whether it looks as if it
    were in millimetres, longer than so much, or had another axis up than ``up``, by which it was
    read; None: nothing is said of that. It says size alone where the box, of middles of things, is
    no longer than such a thing."""
    x, y, z = (float(one) for one in size_m)
    longest = max(x, y, z)
    if longest <= thing_m:
        return size_words(size_m)
    text = f"{size_words(size_m)}, as of {_word(longest)}"
    if longest > may_be_mm_above:
        small = longest / 1000
        text += f"; if it is in millimetres, {small:.4g} m, as of {_word(small)} "
        text += "(--unit mm; --scene-unit mm of a render)"
    if up is not None and z * _FLAT < min(x, y):
        other = "y" if up == "z" else "z"
        text += f"; it is flat along z, as if +{other.upper()} were up in the file "
        text += f"(--up {other}; --scene-up {other} of a render)"
    return text


def describe_scene_extent(
    scene: Scene, size_m: NDArray[np.floating], unit_is_told: bool, up: str | None
) -> str:
    """The same of a scene by the kind of its file: meshes of others than glTF do not say their
    unit, and in glTF +Y is up, the more so where a camera stands upright by it."""
    ending = Path(scene.path).suffix.lower()
    is_gltf = ending in (".gltf", ".glb")
    above = _LONG_GLTF_M if is_gltf else _LONG_MESH_M if ending in MESH_FILES else ODD_M
    ups = [one.world_from_camera[1, 1] for one in scene.cameras]
    thin = float(size_m[2]) < _CARD * float(min(size_m[:2]))
    return describe_extent(
        size_m,
        may_be_mm_above=ODD_M if unit_is_told else above,
        up=None if is_gltf and (thin or max(ups, default=0) > _UPRIGHT) else up or "y",
        thing_m=max(map(_splat_m, scene.splats), default=0.0),
    )


def _splat_m(cloud: SplatCloud) -> float:
    """How long half of a cloud's splats are at least, from end to end."""
    if len(cloud.scales_m) == 0:
        return 0.0
    metres = float(np.cbrt(abs(np.linalg.det(cloud.world_from_splats[:3, :3]))))
    return _SEEN_SIGMAS * metres * float(np.median(cloud.scales_m.max(axis=1)))


def size_words(size_m: NDArray[np.floating]) -> str:
    """Lengths, m, along the axes; what is rounding of the largest is 0."""
    size = without_rounding(size_m, float(np.max(size_m)))
    return " x ".join(f"{float(one):.4g}" for one in size) + " m"


def without_rounding(values_m: ArrayLike, largest_m: float) -> Floats:
    """Lengths or coordinates, m, of which those are 0 that are rounding of the largest length."""
    values = np.asarray(values_m, np.float64)
    return np.where(np.abs(values) < _ROUNDING * largest_m, 0.0, values)


def _word(length_m: float) -> str:
    return next(word for most, word in _LONG if length_m <= most)
