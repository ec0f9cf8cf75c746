"""Panoramas of 1/f noise, which have the spectrum of natural scenes and nothing else of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from omma._core import Error, Scene
from omma.base.arguments import within
from omma.base.arrays import Floats
from omma.base.values import value_class
from omma.scene.paint import painted_scene
from omma.stimuli.checks import check_fields
from omma.stimuli.random_fields import random_field
from omma.stimuli.shapes import grey, longitude_latitude_deg, sphere_patch
from omma.stimuli.turning import Turning

# Noise has within 2 % of so much contrast, as some 1 % of its pixels are below black.
_MOST_CONTRAST = 0.4


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class NoisePanorama(Turning):
    """Noise all around the head whose amplitude falls as 1/f^slope with spatial frequency, the same
    in all directions, and that turns. Natural scenes have slopes around 1 (Field 1987, J Opt Soc Am
    A 4:2379).

    A Gaussian random field on the sphere: harmonics of degree l from 1 on have the variance C_l ~
    l^(-2 slope), down to wavelengths of four pixels. The picture is what is shown, interpolated
    between its pixels, and its contrast and mean are those of what is shown. What would be darker
    than black, is black: of a contrast of 0.3 that takes up to 0.3 %, of 0.4 up to 2 %. More than
    0.4 is refused, of which it would take more.

    Args:
        slope: 0 is white noise.
        contrast: standard deviation over mean of what is shown, 0 to 0.4.
        mean: radiance; 0 only without a contrast.
        pixel_deg: size of the picture's pixels at the horizon, 180 over a whole number.
        speed_deg_s: of its drift about the poles across its direction.
        direction_deg: where it drifts as seen ahead: 0 is to the right, 90 upwards.
        seed: of the noise.
        background: radiance behind it, which nobody sees.
        name: of the thing that turns.

    Raises:
        omma.Error: a parameter out of its range.
    """

    slope: float = 1.0
    contrast: float = 0.3
    mean: float = 0.5
    pixel_deg: float = 0.5
    speed_deg_s: float = 30.0
    direction_deg: float = 0.0
    seed: int = 0
    background: float = 0.5
    name: str = "panorama"

    def __post_init__(self) -> None:
        check_fields(self, slope=(0.0, 4.0), contrast=_of_noise, pixel_deg=_of_whole_rows)

    @cached_property
    def picture(self) -> Floats:
        """Radiance (H, 2 H), equirectangular: ahead at time 0 in the middle, row 0 at the top."""
        noise = _noise(self.slope, round(180 / self.pixel_deg), self.seed)
        return np.asarray(np.maximum(self.mean * (1 + self.contrast * noise), 0.0))

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        picture = self.picture
        rows, columns = picture.shape
        longitude, latitude = longitude_latitude_deg(
            directions, float(self._drift_deg(time_s)), self.direction_deg
        )
        x = (longitude / 360 + 0.5) * columns - 0.5
        y = (0.5 - latitude / 180) * rows - 0.5
        column, row = np.floor(x).astype(int), np.floor(y).astype(int)
        above, below = np.clip(row, 0, rows - 1), np.clip(row + 1, 0, rows - 1)
        left, right = column % columns, (column + 1) % columns
        dx, dy = x - column, y - row
        upper = (1 - dx) * picture[above, left] + dx * picture[above, right]
        lower = (1 - dx) * picture[below, left] + dx * picture[below, right]
        return np.asarray((1 - dy) * upper + dy * lower)

    def _scene(self) -> Scene:
        surface, _ = sphere_patch((-180.0, 180.0), (-90.0, 90.0))
        picture = grey(self.picture)
        return painted_scene([("picture", surface, picture)], self.name, (0, 0, 0), wrap_u="repeat")


def _of_noise(value: float, name: str) -> float:
    contrast = within(value, name, 0.0, 1e6)
    if contrast > _MOST_CONTRAST:
        mean, reached = clipped_noise(contrast)
        raise Error(
            f"{name}: expected 0 to {_MOST_CONTRAST:g}, found {contrast:g}; as nothing is darker "
            f"than black, noise would reach {reached:.3g} and have {mean:.3g} times its mean"
        )
    return contrast


def clipped_noise(contrast: float) -> tuple[float, float]:
    """Of Gaussian noise of mean 1 and this standard deviation, where what is below 0 is 0: its mean
    and its contrast. By the moments of a rectified Gaussian."""
    if contrast == 0:
        return 1.0, 0.0
    least = 1 / contrast
    above = (1 + math.erf(least / math.sqrt(2))) / 2
    density = contrast * math.exp(-(least**2) / 2) / math.sqrt(2 * math.pi)
    mean = above + density
    square = (1 + contrast**2) * above + density
    return mean, math.sqrt(square - mean**2) / mean


def _of_whole_rows(value: float, name: str) -> float:
    """Of pixels, the size nearest to it of which 180° are a whole number."""
    return 180 / round(180 / within(value, name, 0.1, 10.0))


@lru_cache(maxsize=4)
def _noise(slope: float, rows: int, seed: int) -> Floats:
    """Noise (rows, 2 rows) of mean 0 and variance 1 over the sphere as it is shown, interpolated
    between the middles of pixels."""
    # A harmonic of degree l has wavelengths of 360 / l degrees, two rows a degree of l.
    degrees = np.arange(max(rows // 2, 1) + 1)
    power = np.where(degrees > 0, np.maximum(degrees, 1.0) ** (-2 * slope), 0.0)
    field = random_field(power, rows, 2 * rows, seed)
    mean, _ = _shown(field)
    field -= mean
    _, square = _shown(field)
    field /= np.sqrt(square)
    field.flags.writeable = False
    return field


def _shown(picture: Floats) -> tuple[float, float]:
    """Means over the sphere of a picture and of its square, as it is shown: interpolated between
    the middles of pixels, on which straight lines it is nearer to its mean."""
    rows = len(picture)
    # In each half of a row, from its middle to an edge, by Gauss and Legendre.
    nodes, weights = np.polynomial.legendre.leggauss(3)
    mean = square = whole = 0.0
    for side in (-1, 1):
        beside = picture[np.clip(np.arange(rows) + side, 0, rows - 1)]
        for way, weight in zip((nodes + 1) / 4, weights, strict=True):
            row = (1 - way) * picture + way * beside
            area = weight * np.sin(np.pi * (np.arange(rows) + 0.5 + side * way) / rows)
            # Along a row, of two neighbours a and b: of ((1 - x) a + x b)², a²/3 + ab/3 + b²/3.
            squares = (2 * row**2 + row * np.roll(row, 1, axis=1)).mean(axis=1) / 3
            mean += float(area @ row.mean(axis=1))
            square += float(area @ squares)
            whole += float(area.sum())
    return mean / whole, square / whole
