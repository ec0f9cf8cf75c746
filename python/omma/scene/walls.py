"""Surrounds of experiments: a drum around an animal, a corridor that it goes through."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Scene
from omma.base.arguments import checked, positive, whole
from omma.scene.joining import merge_scenes
from omma.scene.paint import Paint, Surface, painted_scene
from omma.scene.solids import tube, upright

# A drum's sides, so many that its polygon is a circle to within 4e-5 of the radius.
_SIDES = 360


@checked
def drum(
    radius_m: float,
    height_m: float,
    wall: Paint,
    *,
    repeats: int = 1,
    sharp: bool = False,
    center_m: ArrayLike = (0.0, 0.0, 0.0),
    name: str = "drum",
) -> Scene:
    """An upright drum, open above and below, whose wall is seen from within.

    Seen from its middle the picture is not mirrored; its middle is ahead, towards -Z, its seam
    behind. It closes without a gap, and a picture whose sides fit together without an edge.

    Args:
        radius_m: of the wall, which has 360 flat sides.
        height_m: along y.
        wall: paint as of `box`: a linear colour, or a picture that fills the height.
        repeats: how often the picture comes around.
        sharp: whether the picture's pixels have hard edges, as stripes do: with
            ``[[[0., 0, 0], [1, 1, 1]]]`` and ``repeats=36`` a square wave of 10°.
        center_m: (3,), where its middle is.
        name: of the instance; turn the drum by it (`World.set_transforms`).

    Raises:
        omma.Error: a size that is not above 0, or what is no colour and no picture.
    """
    radius, height = positive(radius_m, "radius_m"), positive(height_m, "height_m")
    times = whole(repeats, "repeats", 1, 100_000)
    positions, triangles, coordinates = tube(radius, height, _SIDES, inward=True)
    surface = positions, triangles, coordinates * (times, 1)
    return painted_scene([("wall", surface, wall)], name, center_m, wrap_u="repeat", sharp=sharp)


@checked
def corridor(
    length_m: float,
    width_m: float,
    height_m: float,
    left: Paint,
    right: Paint,
    *,
    floor: Paint | None = None,
    ceiling: Paint | None = None,
    picture_length_m: float | None = None,
    sharp: bool = False,
    name: str = "corridor",
) -> Scene:
    """A straight corridor, seen from within, that runs from the origin ahead, towards -Z.

    The origin is the middle of the floor at its beginning; both ends are open. Pictures are upright
    and not mirrored as seen from within; those of floor and ceiling have their top ahead. Walls,
    floor and ceiling are instances of their own, "corridor left" and so on, so that each can move.

    Args:
        length_m: along -z.
        width_m: along x.
        height_m: along y.
        left, right: paint of the walls, as of `box`: a linear colour, or a picture that fills the
            height.
        floor, ceiling: paint; None leaves them out.
        picture_length_m: how much of a wall's length a picture covers before it comes again, from
            the left as one looks at the wall. None: all of it.
        sharp: whether pictures' pixels have hard edges, as gratings do.
        name: with which the names of the instances begin.

    Raises:
        omma.Error: a size that is not above 0, or what is no colour and no picture.
    """
    length, width = positive(length_m, "length_m"), positive(width_m, "width_m")
    height = positive(height_m, "height_m")
    times = 1.0
    if picture_length_m is not None:
        times = length / positive(picture_length_m, "picture_length_m")
    wrap_u = "clamp_to_edge" if picture_length_m is None else "repeat"

    def side(which: str, paint: Paint, middle: ArrayLike, facing: ArrayLike, wall: bool) -> Scene:
        size = (length, height) if wall else (width, length)
        surface = _facing(np.array(facing, float), *size, times if wall else 1.0)
        return painted_scene(
            [(which, surface, paint)],
            f"{name} {which}",
            middle,
            wrap_u=wrap_u if wall else "clamp_to_edge",
            sharp=sharp,
        )

    sides = [
        side("left", left, (-width / 2, height / 2, -length / 2), (1, 0, 0), True),
        side("right", right, (width / 2, height / 2, -length / 2), (-1, 0, 0), True),
    ]
    if floor is not None:
        sides.append(side("floor", floor, (0, 0, -length / 2), (0, 1, 0), False))
    if ceiling is not None:
        sides.append(side("ceiling", ceiling, (0, height, -length / 2), (0, -1, 0), False))
    return merge_scenes(sides)


def _facing(facing: ArrayLike, width_m: float, height_m: float, times: float) -> Surface:
    """A rectangle around the origin that faces somewhere, over which a picture comes so often."""
    right, up = upright(np.asarray(facing))
    local = np.array([[-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5], [0.5, 0.5]]) * (width_m, height_m)
    coordinates = np.array([[0.0, 0], [0, 1], [1, 1], [1, 0]]) * (times, 1)
    return local @ np.stack([right, up]), np.array([[0, 1, 2], [0, 2, 3]]), coordinates
