"""How a picture of all that is around lies on the sphere: which way each of its pixels looks, and
how much of the sphere it has.

Rows and columns count from the picture's upper left corner, and a pixel is 1 wide, so that its
middle is at a half. Each layout has ``at``: unit vectors [..., 3], +X right, +Y up and -Z ahead,
and the solid angle, sr, that a pixel has there; 0 where the picture shows nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from omma.base.arguments import one_of, whole, within
from omma.base.arrays import Floats
from omma.base.directions import angle_of_chord
from omma.base.values import value_class

Lens = Literal["equidistant", "equisolid", "stereographic", "orthographic"]

_MOST_PIXELS = 1 << 15  # of a side
FACES = ("ahead", "right", "back", "left", "up", "down")


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Equirectangular:
    """Longitude and latitude: ahead (-Z) in the middle, +X to the right of it, +Y at the top.

    Args:
        height: rows, from the zenith to the nadir.
        width: columns, all around.

    Raises:
        omma.Error: a size out of its range.
    """

    height: int
    width: int

    def __post_init__(self) -> None:
        _check_size(height=self.height, width=self.width)

    @property
    def shape(self) -> tuple[int, ...]:
        """(height, width)."""
        return self.height, self.width

    def at(self, face: Floats, row: Floats, column: Floats) -> tuple[Floats, Floats]:
        """Unit vectors [..., 3] and solid angles of a pixel, sr."""
        elevation = np.pi * (0.5 - row / self.height)
        azimuth = 2 * np.pi * (column / self.width - 0.5)
        across = np.cos(elevation)
        ways = [np.sin(azimuth) * across, np.sin(elevation), -np.cos(azimuth) * across]
        solid_angle = np.abs(across) * (2 * np.pi / self.width) * (np.pi / self.height)
        return np.stack(ways, axis=-1), solid_angle


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class CubeFaces:
    """Six square photographs from the middle of a cube: ahead (-Z), right, back, left, up, down.

    Those around have up at the top. The lower edge of the one upwards, and the upper edge of the
    one downwards, is ahead.

    Args:
        size: rows and columns of each.

    Raises:
        omma.Error: a size out of its range.
    """

    size: int

    def __post_init__(self) -> None:
        _check_size(size=self.size)

    @property
    def shape(self) -> tuple[int, ...]:
        """(6, size, size)."""
        return 6, self.size, self.size

    def at(self, face: Floats, row: Floats, column: Floats) -> tuple[Floats, Floats]:
        """Unit vectors [..., 3] and solid angles of a pixel, sr."""
        right, up = 2 * column / self.size - 1, 1 - 2 * row / self.size
        one = np.ones_like(right)
        # Of each face, in the order of FACES.
        ways = [
            (right, up, -one), (one, up, right), (-right, up, one), (-one, up, -right),
            (right, one, up), (right, -one, -up),
        ]  # fmt: skip
        which = np.broadcast_to(face, right.shape).astype(int)
        chosen = np.stack(
            [np.choose(which, [way[axis] for way in ways]) for axis in range(3)], axis=-1
        )
        length = np.sqrt(1 + right**2 + up**2)
        return chosen / length[..., None], (2 / self.size) ** 2 / length**3


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Fisheye:
    """A fisheye's picture: the lens looks ahead (-Z), +Y is at the top.

    By the angle from the lens's axis θ, a point lies at a distance r from the middle with r ~ θ
    (equidistant), sin(θ/2) (equisolid), tan(θ/2) (stereographic) or sin θ (orthographic), up to
    half the field at the rim of the image circle (Miyamoto 1964, J Opt Soc Am 54:1060).

    Args:
        height, width: of the picture.
        field_deg: that the image circle shows, across.
        lens: its law.
        circle_px: the diameter of the image circle, in the middle of the picture; 0: the shorter
            side.

    Raises:
        omma.Error: a size or an angle out of its range.
    """

    height: int
    width: int
    field_deg: float = 180.0
    lens: Lens = "equidistant"
    circle_px: float = 0.0

    def __post_init__(self) -> None:
        _check_size(height=self.height, width=self.width)
        one_of(self.lens, _LENSES, "lens")
        within(self.field_deg, "field_deg", 1, _LENSES[self.lens])
        within(self.circle_px, "circle_px", 0, 4 * _MOST_PIXELS)

    @property
    def shape(self) -> tuple[int, ...]:
        """(height, width)."""
        return self.height, self.width

    def at(self, face: Floats, row: Floats, column: Floats) -> tuple[Floats, Floats]:
        """Unit vectors [..., 3] and solid angles of a pixel, sr."""
        radius = (self.circle_px or min(self.height, self.width)) / 2
        right, up = (column - self.width / 2) / radius, (self.height / 2 - row) / radius
        r = np.hypot(right, up)
        inside = r <= 1
        r = np.clip(r, 1e-12, 1)
        rim = np.radians(self.field_deg) / 2
        # θ of r, and dθ/dr.
        if self.lens == "equidistant":
            theta, slope = r * rim, np.full_like(r, rim)
        elif self.lens == "equisolid":
            edge = np.sin(rim / 2)
            theta = angle_of_chord(2 * r * edge)
            slope = 2 * edge / np.sqrt(1 - (r * edge) ** 2)
        elif self.lens == "stereographic":
            edge = np.tan(rim / 2)
            theta = 2 * np.arctan(r * edge)
            slope = 2 * edge / (1 + (r * edge) ** 2)
        else:
            edge = np.sin(rim)
            cosine = np.sqrt(np.maximum(1 - (r * edge) ** 2, 1e-12))
            theta, slope = np.arctan2(r * edge, cosine), edge / cosine
        across = np.sin(theta)
        ways = [across * right / r, across * up / r, -np.cos(theta)]
        solid_angle = np.where(inside, across / r * slope / radius**2, 0.0)
        return np.stack(ways, axis=-1), solid_angle


Layout = Equirectangular | CubeFaces | Fisheye

# The widest field of each law, degrees.
_LENSES = {"equidistant": 360.0, "equisolid": 359.0, "stereographic": 300.0, "orthographic": 180.0}


def pixels_of(layout: Layout) -> tuple[Floats, Floats, Floats]:
    """Face, row and column of the middle of each pixel, in the order of the picture."""
    shape = layout.shape if len(layout.shape) == 3 else (1, *layout.shape)
    face, row, column = np.indices(shape, dtype=float).reshape(3, -1)
    return face, row + 0.5, column + 0.5


def _check_size(**sizes: int) -> None:
    for name, size in sizes.items():
        whole(size, name, 1, _MOST_PIXELS)
