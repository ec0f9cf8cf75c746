"""What there is to detect: a disc on even ground, or a thing in a scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omma._core import Error, Scene
from omma.base.arguments import array_of, expect, positive, within
from omma.base.values import value_class
from omma.light.spectrum import Spectrum
from omma.scene.lighting import Ultraviolet


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class DiscTarget:
    """A flat disc on even ground that fills the rest of the field: a flower on leaves, a dark spot.

    The eye looks straight at it. Both are matte and in the same light, so that they have the
    radiance ρ E/π of their reflectance ρ and of the irradiance E; through air
    (`omma.light.with_air`) as their distance leaves it.

    Attributes:
        diameter_m: of the disc.
        reflectance: of the disc, over the wavelengths of the light; a number is grey.
        background: reflectance of the ground.
        facing: (3,), the side of the world from which light falls on both, as a normal; by default
            they lie on their back.

    Raises:
        omma.Error: a diameter that is not above 0, reflectances beyond 0 to 1, no direction.
    """

    diameter_m: float
    reflectance: Spectrum | float
    background: Spectrum | float
    facing: tuple[float, float, float] = (0.0, 1.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "diameter_m", positive(self.diameter_m, "diameter_m"))
        for name in ("reflectance", "background"):
            value = getattr(self, name)
            if isinstance(value, Spectrum):
                within(float(np.max(value.value)), name, 0, 1)
                within(float(np.min(value.value)), name, 0, 1)
            else:
                object.__setattr__(self, name, within(value, name, 0, 1))
        object.__setattr__(self, "facing", _direction(self.facing, "facing"))


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class SceneTarget:
    """A thing in a scene, which is told from the same scene without it: with its shape, its shadow
    and what light does between surfaces.

    Both are lit by paths; the head comes nearer along a straight line. What a random path adds to
    the noise of a difference is in the error bar, so that it takes many rays.

    Attributes:
        scene: with the target.
        without: the scene without it.
        diameter_m: across what differs between the two.
        center_m: (3,), its middle.
        towards: (3,), from there to the head.
        ultraviolet: as of `omma.World`, for materials of which only RGB is known.

    Raises:
        omma.Error: a diameter that is not above 0, no point, no direction.
    """

    scene: Scene
    without: Scene
    diameter_m: float
    center_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    towards: tuple[float, float, float] = (0.0, 0.0, 1.0)
    ultraviolet: Ultraviolet = None

    def __post_init__(self) -> None:
        for name in ("scene", "without"):
            expect(getattr(self, name), Scene, name, "omma.load_scene gives one")
        object.__setattr__(self, "diameter_m", positive(self.diameter_m, "diameter_m"))
        center = array_of(self.center_m, "center_m", (3,), finite=True)
        object.__setattr__(self, "center_m", tuple(center.tolist()))
        object.__setattr__(self, "towards", _direction(self.towards, "towards"))


def _direction(value: object, name: str) -> tuple[float, ...]:
    direction = array_of(value, name, (3,))
    if not (np.all(np.isfinite(direction)) and np.any(direction)):
        raise Error(f"{name}: expected a direction, found one that is zero or not finite")
    return tuple(direction.tolist())
