"""Colour spaces: where catches lie in the colour hexagon, the Maxwell triangle, the tetrahedron of
four receptor classes, and the four categories of flies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats
from omma.base.values import value_class
from omma.colour_vision.catches import as_catches, relative

# Sectors of the hexagon, clockwise from its blue corner at the top (Chittka et al. 1994, Vision Res
# 34:1489).
_SECTORS = np.array(["blue", "blue-green", "green", "UV-green", "UV", "UV-blue"])

# Corners of a tetrahedron of height 1 around its centre, in the order of ultraviolet, short, medium
# and long wavelengths, as Endler & Mielke (2005) and Stoddard & Prum (2008) turn it: that of
# ultraviolet up, that of short wavelengths along -x.
TETRAHEDRON_CORNERS = np.array([
    (0, 0, 3 / 4),
    (-math.sqrt(6) / 4, -math.sqrt(2) / 4, -1 / 4),
    (0, math.sqrt(2) / 2, -1 / 4),
    (math.sqrt(6) / 4, -math.sqrt(2) / 4, -1 / 4),
])  # fmt: skip


@checked
def excitations(catches: ArrayLike) -> Floats:
    """How much receptors are excited, 0 to 1: E = P/(P + 1), of adapted catches P.

    A catch as of the background excites half as much as can be (Chittka 1992, J Comp Physiol A
    170:533).

    Args:
        catches: (..., N), divided by those of the background, as `von_kries` does.

    Example:
        >>> omma.colour_vision.excitations([0.0, 1.0, 3.0]).tolist()
        [0.0, 0.5, 0.75]

    Raises:
        omma.Error: catches that are negative or not finite.
    """
    seen = as_catches(catches, "catches")
    return np.asarray(seen / (seen + 1))


@checked
def hexagon(excited: ArrayLike) -> Floats:
    """Loci in the colour hexagon of bees (..., 2): x, y.

    x = sin 60° (E_G - E_UV), y = E_B - (E_UV + E_G)/2 (Chittka 1992). Corners are 1 from
    the middle, where the background is; distances are colour contrast, in hexagon units.

    Args:
        excited: (..., 3), excitations of ultraviolet, blue and green receptors, 0 to 1, as
            `excitations` gives them.

    Example:
        >>> omma.colour_vision.hexagon([0.0, 1.0, 0.0]).tolist()  # the blue corner
        [0.0, 1.0]

    Raises:
        omma.Error: excitations beyond 0 to 1, or not three.
    """
    uv, blue, green = np.moveaxis(_excited(excited, "excited"), -1, 0)
    return np.stack([math.sin(math.radians(60)) * (green - uv), blue - (uv + green) / 2], axis=-1)


@checked
def hexagon_contrast(first: ArrayLike, second: ArrayLike) -> Floats:
    """Colour contrast between excitations (..., 3) in hexagon units, 0 to 2: (...).

    The distance of their loci. Of two colours 0.06 apart, honeybees trained on both chose right in
    82 % (Dyer & Garcia 2014, Insects 5:629).

    Example:
        >>> float(omma.colour_vision.hexagon_contrast([0, 1, 0], [1, 0, 1]))
        2.0

    Raises:
        omma.Error: excitations beyond 0 to 1, not three, or shapes that do not go together.
    """
    one, other = _excited(first, "first"), _excited(second, "second")
    try:
        apart = hexagon(one) - hexagon(other)
    except ValueError:
        raise Error(
            f"first, second: expected shapes that go together, found {one.shape}, {other.shape}"
        ) from None
    return np.asarray(np.hypot(apart[..., 0], apart[..., 1]))


@checked
def hexagon_hue_deg(loci: ArrayLike) -> Floats:
    """The hue of loci (..., 2) in the hexagon: (...), from 0 to below 360°, clockwise from the blue
    corner, so that green is at 120° and ultraviolet at 240° (Chittka et al. 1994). In the middle it
    is 0.

    Example:
        >>> [round(float(hue)) for hue in omma.colour_vision.hexagon_hue_deg([[0, 1], [1, 0]])]
        [0, 90]

    Raises:
        omma.Error: loci that are not finite or not two numbers.
    """
    x, y = np.moveaxis(array_of(loci, "loci", (..., 2), finite=True), -1, 0)
    turned = np.degrees(np.arctan2(x, y)) % 360
    return np.where(turned < 360, turned, 0.0)  # of a little below 0, the remainder rounds to 360


@checked
def hexagon_sector(loci: ArrayLike) -> NDArray[np.str_]:
    """The colour of loci (..., 2) for bees, in six sectors of 60° around the corners: texts (...),
    "blue", "blue-green", "green", "UV-green", "UV" and "UV-blue" (Chittka et al. 1994);
    "uncoloured" in the very middle.

    Example:
        >>> omma.colour_vision.hexagon_sector([[0, 1], [0, -1]]).tolist()
        ['blue', 'UV-green']

    Raises:
        omma.Error: loci that are not finite or not two numbers.
    """
    hue = hexagon_hue_deg(loci)
    sector = np.floor(hue / 60 + 0.5).astype(int) % 6
    coloured = np.any(array_of(loci, "loci") != 0, axis=-1)
    return np.where(coloured, _SECTORS[sector], "uncoloured")


@checked
def maxwell_triangle(catches: ArrayLike) -> Floats:
    """Loci in the Maxwell triangle (..., 2): x, y, of what share each of three classes has.

    Corners are √(2/3) from the middle and √2 from each other: short wavelengths up, medium to the
    left, long to the right; x = (l - m)/√2, y = √(2/3) (s - (m + l)/2).

    Args:
        catches: (..., 3), of short, medium and long wavelengths, such as a bee's ultraviolet, blue
            and green ones; those of the background, if they are adapted to it, lie in the middle.

    Example:
        >>> omma.colour_vision.maxwell_triangle([[1, 1, 1], [2, 0, 0]]).round(4).tolist()
        [[0.0, 0.0], [0.0, 0.8165]]

    Raises:
        omma.Error: catches that are negative or not finite, not three, or all 0.
    """
    short, medium, long = np.moveaxis(relative(catches, "catches", 3), -1, 0)
    return np.stack([
        (long - medium) / math.sqrt(2), math.sqrt(2 / 3) * (short - (medium + long) / 2)
    ], axis=-1)  # fmt: skip


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class TetrahedralColour:
    """Colours in the tetrahedron of four receptor classes, as `tetrahedron` finds them.

    Attributes:
        position: (..., 3), x, y, z; corners are 3/4 from the middle, where all classes catch the
            same.
        theta_rad: (...), hue around z, from x towards y, -π to π.
        phi_rad: (...), hue above the plane of x and y, towards ultraviolet, -π/2 to π/2.
        chroma: (...), r, the distance from the middle.
        largest_chroma: (...), r_max: the distance of the tetrahedron's surface in that direction;
            in the middle, where there is none, that of the corners, 0.75.
    """

    position: Floats
    theta_rad: Floats
    phi_rad: Floats
    chroma: Floats
    largest_chroma: Floats


@checked
def tetrahedron(catches: ArrayLike) -> TetrahedralColour:
    """Where colours lie in the tetrahedron of four receptor classes.

    By the share of each class (Goldsmith 1990, Q Rev Biol 65:281; Stoddard & Prum 2008, Am Nat
    171:755). Given ln Q of adapted catches, as far as they are positive, it is the space of Endler
    & Mielke 2005, Biol J Linn Soc 86:405.

    Args:
        catches: (..., 4), of ultraviolet or violet, short, medium and long wavelengths.

    Example:
        >>> colour = omma.colour_vision.tetrahedron([1.0, 0.0, 0.0, 0.0])
        >>> colour.position.tolist(), float(colour.chroma / colour.largest_chroma)
        ([0.0, 0.0, 0.75], 1.0)

    Raises:
        omma.Error: catches that are negative or not finite, not four, or all 0.
    """
    share = relative(catches, "catches", 4) - 1 / 4
    position = share @ TETRAHEDRON_CORNERS
    x, y, z = np.moveaxis(position, -1, 0)
    chroma = np.sqrt(np.sum(position**2, axis=-1))
    # The surface is where the first share becomes 0.
    least = -np.min(share, axis=-1)
    somewhere = chroma > 1e-12
    safe = np.where(somewhere, chroma, 1.0)
    largest = np.where(somewhere, chroma / 4 / np.where(somewhere, least, 1.0), 3 / 4)
    sine = np.where(somewhere, np.clip(z / safe, -1, 1), 0.0)
    return TetrahedralColour(position, np.arctan2(y, x), np.arcsin(sine), chroma, largest)


@checked
def fly_opponents(catches: ArrayLike) -> Floats:
    """What flies compare, R7 with R8 in pale and in yellow ommatidia: (..., 2).

    x = R7p - R8p, y = R7y - R8y, of catches as shares of the four (Troje 1993, Z Naturforsch C
    48:96).

    Args:
        catches: (..., 4), of R7p, R8p, R7y and R8y, in that order.

    Example:
        >>> omma.colour_vision.fly_opponents([3.0, 1.0, 2.0, 2.0]).tolist()
        [0.25, 0.0]

    Raises:
        omma.Error: catches that are negative or not finite, not four, or all 0.
    """
    share = relative(catches, "catches", 4)
    return np.asarray(share[..., [0, 2]] - share[..., [1, 3]])


@checked
def fly_category(catches: ArrayLike) -> NDArray[np.str_]:
    """The colour category of flies: texts (...), "p+y+", "p+y-", "p-y+" and "p-y-".

    Flies tell categories apart and nothing within one (Troje 1993): the signs of `fly_opponents`.
    A difference of 0 has the sign "0", as it lies on a border.

    Args:
        catches: (..., 4), of R7p, R8p, R7y and R8y, in that order.

    Example:
        >>> omma.colour_vision.fly_category([[3, 1, 1, 2], [1, 3, 1, 2]]).tolist()
        ['p+y-', 'p-y-']

    Raises:
        omma.Error: catches that are negative or not finite, not four, or all 0.
    """
    seen = as_catches(catches, "catches", 4)
    relative(seen, "catches", 4)
    # Of the catches themselves: shares of equal ones are equal, but differences round.
    signs = np.sign(seen[..., [0, 2]] - seen[..., [1, 3]]).astype(int)
    names = np.array([[f"p{p}y{y}" for y in "0+-"] for p in "0+-"])
    return np.asarray(names[signs[..., 0], signs[..., 1]])


def _excited(value: ArrayLike, name: str) -> Floats:
    excited = as_catches(value, name, 3)
    if not np.all(excited <= 1):
        raise Error(
            f"{name}: expected excitations from 0 to 1, found {np.max(excited):g}; of catches, "
            "divided by those of the background, `excitations` makes them"
        )
    return excited
