"""How lit worlds are checked against closed forms: what a check is, and small eyes that measure.

The checks themselves are in lit_checks_surfaces.py, lit_checks_volumes.py and lit_checks_lights.py;
test_lit_forms.py runs them, and docs/make_validation.py writes their numbers down.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import omma
from omma.base.directions import normalized
from omma.light import Bands, Light, Spectrum
from omma.scene import Material, Mesh

Floats = NDArray[np.float64]

BAND = Bands.equal(1, 500, 600)
# Single precision, summed over some thousand samples.
ROUNDING = 1e-5
# Three standard errors, which are under 0.1 %.
MOST_ERRORS, LARGEST_ERROR = 3.0, 1e-3

DARK = Light(BAND, "watts")


@dataclass(frozen=True)
class Check:
    """One number of one effect.

    effect, form: what it is, and the closed form, as a reader of the table wants it.
    expected, found: of the closed form and of Omma.
    standard_error: of `found`; 0 where nothing is random.
    tolerance: as a share of `scale`, beside the standard errors.
    scale: what shares are of; None: of `expected`.
    """

    effect: str
    form: str
    expected: float
    found: float
    standard_error: float = 0.0
    tolerance: float = ROUNDING
    scale: float | None = None

    def measure(self) -> float:
        return abs(self.expected) if self.scale is None else self.scale

    def error(self) -> float:
        return (self.found - self.expected) / self.measure()

    def limit(self) -> float:
        return self.tolerance + MOST_ERRORS * self.standard_error / self.measure()


Case = Callable[[str], Iterable[Check]]


def matter(reflectance: float = 0.0, **changes: object) -> Material:
    """Matter without gloss, seen from both sides, that reflects so much in all bands."""
    grey = Spectrum([200.0, 800.0], [reflectance, reflectance])
    parts = {"specular": 0.0, "double_sided": True, "reflectance": grey, **changes}
    return Material(**parts)  # type: ignore[arg-type]


def shining(radiance: float, reflectance: float = 0.0) -> Material:
    """Matter that shines with so many W m⁻² sr⁻¹ nm⁻¹."""
    flat = Spectrum([200.0, 800.0], [radiance, radiance])
    return matter(reflectance, emissive=(1.0, 1.0, 1.0), emission=flat)


def flat_spectrum(value: float) -> Spectrum:
    return Spectrum([200.0, 800.0], [value, value])


def square(
    size_m: float, center_m: ArrayLike, facing: ArrayLike, material: int = 0, **parts: object
) -> Mesh:
    """A square about a place, with texture coordinates."""
    normal = normalized(np.asarray(facing, float))
    helper = np.array([0.0, 0, -1]) if abs(normal[1]) > 0.5 else np.array([0.0, 1, 0])
    across = normalized(np.cross(helper, normal))
    up = np.cross(normal, across)
    half = size_m / 2
    corners = [
        np.asarray(center_m) + half * (a * across + b * up)
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return Mesh(
        corners,
        [[0, 1, 2], [0, 2, 3]],
        texture_coordinates=[[0, 1], [1, 1], [1, 0], [0, 0]],
        material=material,
        **parts,  # type: ignore[arg-type]
    )


def room(size_m: float, material: int = 0) -> list[Mesh]:
    """The six walls of a closed cube about the origin, facing inwards."""
    half = size_m / 2
    sides = np.concatenate([np.eye(3), -np.eye(3)])
    return [square(size_m, -half * side, side, material) for side in sides]


def eyes_at(positions_m: ArrayLike, axes: ArrayLike, up: ArrayLike | None = None) -> omma.Eye:
    """Ommatidia that look along one ray each."""
    positions, axes = np.broadcast_arrays(np.asarray(positions_m, float), np.asarray(axes, float))
    positions, axes = np.atleast_2d(positions), np.atleast_2d(axes)
    if up is None:
        return omma.Eye(positions, axes, 0.0)
    return omma.Eye(positions, axes, 0.0, up=np.broadcast_to(np.asarray(up, float), axes.shape))


def look_each(
    world: omma.World,
    position_m: ArrayLike,
    axis: ArrayLike,
    *,
    count: int = 32,
    samples: int = 256,
    up: ArrayLike | None = None,
) -> Floats:
    """Radiance along one ray as many ommatidia see it, each with random numbers of its own.

    (count, B), or (count, 3, B) in polarised worlds.
    """
    eye = eyes_at(np.tile(position_m, (count, 1)), axis, up)
    renderer = omma.Renderer(world, eye, omma.Fixed(samples))
    seen = renderer.render_stokes(np.eye(4)) if world.polarized else renderer.render(np.eye(4))
    return seen[0].astype(float)


def look(
    world: omma.World, position_m: ArrayLike, axis: ArrayLike, **how: Any
) -> tuple[Floats, Floats]:
    """The mean of `look_each` and its standard error, from how much they differ."""
    seen = look_each(world, position_m, axis, **how)
    return seen.mean(axis=0), seen.std(axis=0, ddof=1) / np.sqrt(len(seen))


def look_many(
    world: omma.World,
    positions_m: ArrayLike,
    axes: ArrayLike,
    *,
    samples: int = 64,
    repeats: int = 8,
) -> tuple[Floats, Floats]:
    """Radiance along N rays, (N, B), and its standard errors, from renders with other seeds."""
    world_eye = eyes_at(positions_m, axes)
    renderer = omma.Renderer(world, world_eye, omma.Fixed(samples))
    seen = np.array(
        [
            renderer.with_eye(world_eye, seed=seed).render(np.eye(4))[0]
            for seed in range(1, repeats + 1)
        ],
        float,
    )
    return seen.mean(axis=0), seen.std(axis=0, ddof=1) / np.sqrt(repeats)


def slanted(angle_deg: float) -> tuple[Floats, Floats]:
    """Where to stand and which way to look to see the origin from above, so far off its normal."""
    angle = np.radians(angle_deg)
    back = np.array([0.0, np.cos(angle), np.sin(angle)])
    return back, -back
