"""Simple solids, each a scene of one thing: boxes, spheres, cylinders, planes and discs.

`merge_scenes` puts several together; the thing moves under its name in a world.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Material, Scene
from omma.base.arguments import array_of, checked, positive, whole
from omma.scene.paint import Paint, Surface, color_or_image, painted_scene, point

_MOST_SEGMENTS = 10_000


@checked
def box(
    size_m: ArrayLike = (1.0, 1.0, 1.0),
    paint: Paint = (1.0, 1.0, 1.0),
    *,
    center_m: ArrayLike = (0.0, 0.0, 0.0),
    name: str = "box",
) -> Scene:
    """A box along the axes of the world, seen from outside.

    Args:
        size_m: (3,), along x, y and z.
        paint: a linear colour (r, g, b) or (r, g, b, a); a `Material` without textures; or a
            picture: an `Image`, the path of one, or an array (height, width, 3 or 4), uint8 sRGB
            or float linear. Each side shows the picture once, upright: +Y is up, on top and below
            -Z.
        center_m: (3,), where its middle is.
        name: of the instance.

    Example:
        >>> crate = omma.scene.box((2, 1, 1), (0.5, 0.3, 0.1), center_m=(0, 0.5, -3))
        >>> crate.bounds.tolist()
        [[-1.0, 0.0, -3.5], [1.0, 1.0, -2.5]]

    Raises:
        omma.Error: a size that is not above 0, or what is no colour and no picture.
    """
    half = _sizes(size_m, "size_m", 3) / 2
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            facing = np.zeros(3)
            facing[axis] = sign
            right, up = upright(facing)
            sides.append(
                _rectangle(facing * half, right * np.abs(right @ half), up * np.abs(up @ half))
            )
    return painted_scene([("paint", _joined(sides), paint)], name, center_m)


@checked
def sphere(
    radius_m: float = 0.5,
    paint: Paint = (1.0, 1.0, 1.0),
    *,
    center_m: ArrayLike = (0.0, 0.0, 0.0),
    segments: int = 128,
    name: str = "sphere",
) -> Scene:
    """A sphere, seen from outside. Its normals are a sphere's, for light that it scatters or bends.

    Args:
        radius_m: of its vertices; its faces lie within by at most 1 - cos(pi / segments) of it.
        paint: as of `box`; a picture is equirectangular, its middle towards +Z, and not mirrored as
            seen from outside.
        center_m: (3,), where its middle is.
        segments: sides of its equator; half as many from pole to pole.
        name: of the instance.

    Raises:
        omma.Error: a radius that is not above 0, less than 8 segments, or what is no colour and no
            picture.
    """
    radius = positive(radius_m, "radius_m")
    around = whole(segments, "segments", 8, _MOST_SEGMENTS)
    rings = around // 2
    u, v = np.meshgrid(np.linspace(0, 1, around + 1), np.linspace(0, 1, rings + 1))
    polar = np.pi * v
    direction = _around(u) * np.where(v == 1, 0, np.sin(polar))[..., None]
    direction[..., 1] = np.cos(polar)
    # Both poles are one point, of which one triangle of each square has two corners.
    triangles = _grid(rings, around)
    first_row = np.arange(len(triangles)) < 2 * around
    last_row = np.arange(len(triangles)) >= 2 * around * (rings - 1)
    second = np.arange(len(triangles)) % 2 == 1
    kept = ~(first_row & second) & ~(last_row & ~second)
    surface = (
        radius * direction.reshape(-1, 3), triangles[kept], np.stack([u, v], -1).reshape(-1, 2)
    )  # fmt: skip
    faceted = painted_scene([("paint", surface, paint)], name, center_m, wrap_u="repeat")
    return faceted.replace(meshes=[faceted.meshes[0].replace(normals=direction.reshape(-1, 3))])


@checked
def cylinder(
    radius_m: float = 0.5,
    height_m: float = 1.0,
    paint: Paint = (1.0, 1.0, 1.0),
    *,
    caps: Paint | None = None,
    center_m: ArrayLike = (0.0, 0.0, 0.0),
    segments: int = 128,
    name: str = "cylinder",
) -> Scene:
    """An upright cylinder, closed, seen from outside.

    Args:
        radius_m: of the corners of its caps, which are polygons.
        height_m: along y.
        paint: of the side, as of `box`; a picture goes once around, its middle towards +Z, and is
            not mirrored as seen from outside.
        caps: paint of top and bottom. None: the colour of the side, white under a picture.
        center_m: (3,), where its middle is.
        segments: sides of its caps.
        name: of the instance.

    Raises:
        omma.Error: a size that is not above 0, less than 3 segments, or what is no colour and no
            picture.
    """
    radius, height = positive(radius_m, "radius_m"), positive(height_m, "height_m")
    around = whole(segments, "segments", 3, _MOST_SEGMENTS)
    ends = []
    for sign in (1.0, -1.0):
        positions, triangles, coordinates = _polygon(radius, around, np.array([0.0, sign, 0.0]))
        ends.append((positions + (0, sign * height / 2, 0), triangles, coordinates))
    if caps is None:
        caps = paint if isinstance(paint, Material) else color_or_image(paint, "paint")[0]
    surfaces = [
        ("paint", tube(radius, height, around, inward=False), paint),
        ("caps", _joined(ends), caps),
    ]
    return painted_scene(surfaces, name, center_m, wrap_u="repeat")


@checked
def plane(
    size_m: ArrayLike = (10.0, 10.0),
    paint: Paint = (1.0, 1.0, 1.0),
    *,
    center_m: ArrayLike = (0.0, 0.0, 0.0),
    facing: ArrayLike = (0.0, 1.0, 0.0),
    name: str = "plane",
) -> Scene:
    """A rectangle, seen from both sides; ground, unless it faces elsewhere.

    Painted with a `Material` of your own it is seen from behind, and casts a shadow there, with
    ``double_sided=True`` only.

    Args:
        size_m: (2,), to the right and upwards as seen from in front. Up is +Y, or -Z where it faces
            straight up or down.
        paint: as of `box`; a picture is upright as seen from in front.
        center_m: (3,), where its middle is.
        facing: (3,), where its front looks.
        name: of the instance.

    Raises:
        omma.Error: a size that is not above 0, no direction, or what is no colour and no picture.
    """
    half = _sizes(size_m, "size_m", 2) / 2
    right, up = upright(_direction(facing))
    surface = _rectangle(np.zeros(3), half[0] * right, half[1] * up)
    return painted_scene([("paint", surface, paint)], name, center_m, double_sided=True)


@checked
def disc(
    radius_m: float = 0.5,
    paint: Paint = (1.0, 1.0, 1.0),
    *,
    center_m: ArrayLike = (0.0, 0.0, 0.0),
    facing: ArrayLike = (0.0, 0.0, 1.0),
    segments: int = 128,
    name: str = "disc",
) -> Scene:
    """A flat disc, seen from both sides: a target. It faces +Z, from where heads look along -Z.

    Painted with a `Material` of your own it is as a `plane` is.

    Args:
        radius_m: of its corners: it is a polygon.
        paint: as of `box`; the disc is cut out of the middle of a picture that is as wide and as
            high as the disc, upright as seen from in front.
        center_m: (3,), where its middle is.
        facing: (3,), where its front looks.
        segments: its corners.
        name: of the instance.

    Raises:
        omma.Error: a radius that is not above 0, no direction, less than 3 segments, or what is no
            colour and no picture.
    """
    radius = positive(radius_m, "radius_m")
    around = whole(segments, "segments", 3, _MOST_SEGMENTS)
    surface = _polygon(radius, around, _direction(facing))
    return painted_scene([("paint", surface, paint)], name, center_m, double_sided=True)


def upright(facing: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Right and up of a picture that faces somewhere, as who looks at it sees them: directions.

    Up is +Y, or -Z for what faces straight up or down.
    """
    above = np.array([0.0, 1.0, 0.0])
    if np.linalg.norm(np.cross(above, facing)) < 1e-9:
        above = np.array([0.0, 0.0, -1.0])
    right = np.cross(above, facing)
    right /= np.linalg.norm(right)
    return right, np.cross(facing, right)


def tube(radius_m: float, height_m: float, segments: int, *, inward: bool) -> Surface:
    """An open upright tube around the origin, seen from outside or from within.

    Texture coordinates go once around; the first and the last vertex of a ring are at one position.
    The middle of the picture is towards +Z as seen from outside, towards -Z as seen from within,
    and from there it is not mirrored.
    """
    u, v = np.meshgrid(np.linspace(0, 1, segments + 1), (0.0, 1.0))
    # Seen from within, right and ahead are the other way than seen from outside.
    positions = radius_m * _around(u) * ((1, 1, -1) if inward else (1, 1, 1))
    positions[..., 1] = height_m * (0.5 - v)
    coordinates = np.stack([u, v], -1).reshape(-1, 2)
    return positions.reshape(-1, 3), _grid(1, segments), coordinates


def _around(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """Directions across y, once around to the right as seen from outside; u = 1/2 is +Z. The
    first and the last are the same to the last bit, so that nothing shows between them."""
    angle = 2 * np.pi * (np.where(u == 1, 0, u) - 0.5)
    return np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], -1)


def _grid(rows: int, columns: int) -> NDArray[np.integer]:
    """Two triangles for each square between (rows + 1) x (columns + 1) vertices, which are listed
    row by row from the upper left as seen from in front: the first triangle has the square's lower
    edge, the second its upper one."""
    row, column = np.divmod(np.arange(rows * columns), columns)
    upper_left = row * (columns + 1) + column
    lower_left = upper_left + columns + 1
    lower = np.stack([upper_left, lower_left, lower_left + 1], -1)
    upper = np.stack([upper_left, lower_left + 1, upper_left + 1], -1)
    return np.stack([lower, upper], 1).reshape(-1, 3)


def _rectangle(
    middle: NDArray[np.float64], right: NDArray[np.float64], up: NDArray[np.float64]
) -> Surface:
    """From its middle to the right and upwards; a picture fills it."""
    positions = [middle - right + up, middle - right - up, middle + right - up, middle + right + up]
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    return np.array(positions), triangles, np.array([[0.0, 0], [0, 1], [1, 1], [1, 0]])


def _polygon(radius_m: float, corners: int, facing: NDArray[np.float64]) -> Surface:
    """A regular one around the origin, with a vertex in the middle."""
    right, up = upright(facing)
    angle = 2 * np.pi * np.arange(corners) / corners
    local = np.concatenate([np.zeros((1, 2)), np.stack([np.cos(angle), np.sin(angle)], -1)])
    here = 1 + np.arange(corners)
    triangles = np.stack([np.zeros(corners, int), here, 1 + here % corners], -1)
    coordinates = 0.5 + 0.5 * local * (1, -1)
    return radius_m * local @ np.stack([right, up]), triangles, coordinates


def _joined(surfaces: list[Surface]) -> Surface:
    counts = np.cumsum([0] + [len(positions) for positions, _, _ in surfaces])
    return (
        np.concatenate([positions for positions, _, _ in surfaces]),
        np.concatenate([one[1] + first for one, first in zip(surfaces, counts)]),
        np.concatenate([coordinates for _, _, coordinates in surfaces]),
    )


def _sizes(value: ArrayLike, name: str, count: int) -> NDArray[np.float64]:
    sizes = array_of(value, name, (count,))
    if not ((sizes > 0) & np.isfinite(sizes)).all():
        raise Error(f"{name}: expected {count} numbers above 0, found {sizes.tolist()}")
    return sizes


def _direction(facing: ArrayLike) -> NDArray[np.float64]:
    found = point(facing, "facing")
    largest = np.abs(found).max()
    if largest == 0:
        raise Error("facing: expected a direction, found 0, 0, 0")
    scaled = found / largest  # whose square is neither too large nor too small
    return np.asarray(scaled / np.linalg.norm(scaled))
