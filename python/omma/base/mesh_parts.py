"""What readers of mesh files hand on, and the scene that is made of it: materials and pictures, and
meshes of double precision, placed so that none of it is lost.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Image, Instance, Material, Mesh, Scene, Texture
from omma.base.arguments import one_of
from omma.base.arrays import Floats, Ints
from omma.base.files import metres_per_unit
from omma.base.srgb import linear_of_srgb

# What turns the axis that points up into +Y: z, and where y points down and z ahead (COLMAP's
# cameras, from which splats are trained) -y, by half a turn about x.
_TURNS = {
    "y": np.eye(4),
    "z": np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]),
    "-y": np.diag([1.0, -1.0, -1.0, 1.0]),
}

# A scene farther from zero than this many half sizes is moved near it, as the engine does
# (model/scene_place.h).
_NEAR = 4


@dataclass
class Piece:
    """A mesh as a file has it."""

    name: str
    positions: Floats  # (V, 3), in the file's unit
    triangles: Ints  # (T, 3)
    texture_coordinates: Floats | None = None  # (V, 2), of glTF: v grows downwards
    colors: Floats | None = None  # (V, 4), linear
    material: int = -1


@dataclass
class MeshParts:
    """All of a file; ``warnings`` say what of it was passed over."""

    pieces: list[Piece] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    images: list[Image] = field(default_factory=list)
    textures: list[Texture] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def world_from_file(unit: str | float, up: str) -> Floats:
    """(4, 4), from a file's unit and its axis that points up ("y", "z" or "-y") to metres with +Y
    up."""
    return _TURNS[one_of(up, _TURNS, "up")] @ np.diag([metres_per_unit(unit)] * 3 + [1.0])


def make_scene(parts: MeshParts, world_from_file: Floats) -> Scene:
    """The scene of these parts, each piece placed once."""
    offset = offset_of([one.positions for one in parts.pieces])
    placed = world_from_file.copy()
    placed[:3, 3] += placed[:3, :3] @ offset
    return Scene(
        meshes=[
            Mesh(
                one.positions - offset,
                one.triangles,
                name=one.name,
                texture_coordinates=one.texture_coordinates,
                colors=one.colors,
                material=one.material,
            )
            for one in parts.pieces
        ],
        instances=[Instance(i, placed, name=one.name) for i, one in enumerate(parts.pieces)],
        materials=parts.materials,
        images=parts.images,
        textures=parts.textures,
    )


def offset_of(positions: list[Floats]) -> Floats:
    """What is best subtracted from coordinates that single precision would round: (3,), 0 where
    they lie about zero, or have been rounded already.

    A survey in UTM is millions of metres from its origin, where single precision has steps of half
    a metre. The difference goes into the instances' matrices, which are of double precision.
    """
    all_of = [one for one in positions if len(one)]
    if not all_of:
        return np.zeros(3)
    low = np.min([one.min(axis=0) for one in all_of], axis=0)
    high = np.max([one.max(axis=0) for one in all_of], axis=0)
    return np.zeros(3) if all(map(is_single, all_of)) else far_middle(low, high)


def far_middle(low: Floats, high: Floats) -> Floats:
    """The middle (3,) of a box far from zero, 0 of any other."""
    with np.errstate(over="ignore", invalid="ignore"):
        half, middle = (high - low) / 2, low / 2 + high / 2
        is_far = np.abs(middle).max() > _NEAR * half.max() and np.isfinite(middle).all()
    return middle if is_far else np.zeros(3)


def is_single(values: NDArray[np.floating[Any]]) -> bool:
    """Whether single precision has all these numbers as they are."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool((values.astype(np.float32) == values).all())


def linear(encoded: Floats) -> Floats:
    """Linear RGBA of sRGB in 0 to 1, whose alpha is linear already."""
    return np.concatenate([linear_of_srgb(encoded[:, :3]), encoded[:, 3:]], axis=1)


def colors_and_mode(colors: Floats | None, told: list[str]) -> tuple[Floats | None, str]:
    """Vertex colours, linear RGBA, and the alpha mode of a material that has none of its own: light
    comes through where any alpha is below 1. Colours that are all invisible are taken as opaque, as
    programs that do not know of alpha write them, which is told."""
    if colors is None or (colors[:, 3] == 1).all():
        return colors, "opaque"
    if (colors[:, 3] > 0).any():
        return colors, "blend"
    told.append("alpha of all its vertex colours is 0; they are taken as opaque")
    return np.insert(colors[:, :3], 3, 1.0, axis=1), "opaque"
