"""What there is to detect, as an eye sees it from a distance: photons of each receptor with the
target and without it."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omma._core import Background, Error, Eye
from omma.base.arguments import array_of, as_named, positive, within
from omma.base.poses import look_at
from omma.base.values import value_class
from omma.light.bands import Bands
from omma.light.lights import Light
from omma.light.spectrum import Spectrum
from omma.receptors.catches import photon_catch
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_axis, receptor_matrix
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed
from omma.scene.solids import disc
from omma.scene.world import World

Floats = NDArray[np.float64]

# Corners of the polygon that is a disc: its area is the circle's to 2.5e-5.
_CORNERS = 512
# Diameters by which it lies behind the world's origin, so that no head far from it looks as if its
# millimetres were taken for metres.
_BEHIND = 4.0
# Widths of an acceptance beyond which it sees nothing: a Gaussian is 1e-11 there.
_WIDTHS = 3.0


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class DiscTarget:
    """A flat disc on even ground that fills the rest of the field: a flower on leaves, a dark spot.

    The eye looks straight at it. Both are matte and in the same light, so that they have the
    radiance ρ E/π of their reflectance ρ and of the irradiance E.

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
        facing = array_of(self.facing, "facing", (3,))
        if not (np.all(np.isfinite(facing)) and np.any(facing)):
            raise Error("facing: expected a direction, found one that is zero or not finite")
        object.__setattr__(self, "facing", tuple(facing.tolist()))


@dataclass(frozen=True, eq=False)
class Seen:
    """Photons of each receptor (R,): without the target, and how many more there are with it; the
    standard error of that, from the rays."""

    background: Floats
    added: Floats
    error: Floats


class DiscView:
    """A disc of a target in light, as some of an eye's ommatidia see it from any distance, always
    by the same rays."""

    def __init__(
        self, whole: Eye, target: DiscTarget, light: Light, direction: Floats, time_s: float
    ) -> None:
        self._whole, self._target, self._light = whole, target, light
        self._direction, self._time_s = direction, time_s
        with as_named(normal="facing"):
            falls = sum(light.irradiance(target.facing))
        self._radiance = [
            falls / math.pi * _band_means(light.bands, getattr(target, name), name)
            for name in ("background", "reflectance")
        ]
        # 1 on the disc and 0 beside it, in one band: the share of the disc in what is seen.
        self._world = World(
            disc(
                target.diameter_m / 2,
                center_m=(0, 0, -_BEHIND * target.diameter_m),
                segments=_CORNERS,
            ),
            background=Background.constant((0, 0, 0)),
            band_from_rgb=[[0, 1, 0]],
        )
        self._widest_rad = _widest_rad(whole)
        self._off_axis_rad = _off_axis_rad(whole, direction)
        up = (0, 1, 0) if abs(direction[1]) < 0.99 else (0, 0, 1)
        self._turned = look_at((0, 0, 0), direction, up)[:3, :3].T

    def farthest_m(self) -> float:
        """From beyond that its corners would not be seen in their places, single precision being
        what it is: 100,000 diameters."""
        return 1e5 * self._target.diameter_m

    def nearest(self, count: int) -> NDArray[np.intp]:
        """The ommatidia that look nearest to its middle, or all, if there are fewer."""
        return np.sort(np.argsort(self._off_axis_rad, kind="stable")[:count])

    def reached(self, nearest_m: float) -> NDArray[np.intp]:
        """The ommatidia that see anything of it at this distance or beyond; at least one."""
        reach = math.atan2(self._target.diameter_m / 2, nearest_m) + _WIDTHS * self._widest_rad
        # Lenses lie beside the middle of the head, from where they see the disc elsewhere.
        beside = float(np.max(np.sqrt(np.sum(self._whole.position_m**2, axis=1))))
        reach += math.asin(min(beside / nearest_m, 1.0))
        return np.flatnonzero(self._off_axis_rad <= max(reach, float(self._off_axis_rad.min())))

    def through(self, ommatidia: NDArray[np.intp], sampling: Fixed, seed: int) -> DiscSeen:
        """What these ommatidia see, by so many rays."""
        eye = self._whole.take(ommatidia)
        matrix = receptor_matrix(eye, bands=self._light.bands)
        catches = [
            photon_catch(
                eye,
                (matrix @ radiance)[eye.receptor_type],
                self._light,
                integration_time_s=self._time_s,
            )
            for radiance in self._radiance
        ]
        renderer = Renderer(self._world, eye, sampling, seed=seed)
        pose = np.eye(4)
        pose[:3, :3], pose[2, 3] = self._turned, -_BEHIND * self._target.diameter_m
        return DiscSeen(renderer, pose, catches[0], catches[1] - catches[0])


class DiscSeen:
    """Responses to a disc at any distance, of one eye."""

    def __init__(self, renderer: Renderer, on_disc: Floats, background: Floats, more: Floats):
        self.eye = renderer.eye
        self._renderer, self._on_disc = renderer, on_disc
        self._background, self._more = background, more

    def at(self, distance_m: float) -> Seen:
        """From this distance between the disc's middle and the head's origin."""
        pose = self._on_disc.copy()
        pose[2, 3] += distance_m
        ones = np.ones((len(self.eye.receptor_types), 1))
        with warnings.catch_warnings():
            # Of far heads: rays are rounded by 2⁻²⁴ of the distance, all alike, which shifts the
            # disc by so much (`farthest_m`).
            warnings.simplefilter("ignore", RuntimeWarning)
            share, error = self._renderer.render_receptors(pose, matrix=ones, standard_error=True)
        return Seen(
            self._background,
            self._more * share[0].astype(np.float64),
            np.abs(self._more) * error[0].astype(np.float64),
        )


def _band_means(bands: Bands, reflectance: Spectrum | float, name: str) -> Floats:
    if isinstance(reflectance, float):
        return np.full(len(bands), reflectance)
    with as_named(spectrum=name):
        return bands.mean(reflectance.value, reflectance.wavelength_nm)


def _widest_rad(eye: Eye) -> float:
    own = [one.acceptance.mean_width_rad for one in eye.receptor_types if one.acceptance]
    return max([float(np.max(eye.acceptance_angle_rad)), *own])


def _off_axis_rad(eye: Eye, direction: Floats) -> Floats:
    """How far from a direction the nearest receptor of each ommatidium looks: (N,)."""
    cosine = np.clip(receptor_axis(eye).astype(np.float64) @ direction, -1, 1)
    nearest = np.full(len(eye), np.pi)
    np.minimum.at(nearest, ommatidium_of_receptor(eye), np.arccos(cosine))
    return nearest
