"""A disc on even ground, as an eye sees it from a distance: of each acceptance the share that is
filled by the disc is rendered, and photons follow from that."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from omma._core import Background, Eye
from omma.base.arguments import as_named
from omma.base.arrays import Floats
from omma.base.warn import warn_caller
from omma.colour_vision.targets import DiscTarget
from omma.colour_vision.views import Seen, View, met
from omma.light.bands import Bands
from omma.light.lights import Light
from omma.light.spectrum import Spectrum
from omma.receptors.catches import photon_catch
from omma.receptors.sensitivity import receptor_matrix
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed
from omma.scene.solids import disc
from omma.scene.world import World

# Corners of the polygon that is a disc: its area is the circle's to 2.5e-5.
_CORNERS = 512
# Diameters by which it lies behind the world's origin, so that no head far from it looks as if its
# millimetres were taken for metres.
_BEHIND = 4.0


class DiscView(View):
    """A disc of a target in light, as some of an eye's ommatidia see it from any distance, always
    by the same rays."""

    def __init__(
        self, whole: Eye, target: DiscTarget, light: Light, direction: Floats, time_s: float
    ) -> None:
        super().__init__(whole, target.diameter_m, direction)
        self._light, self._time_s = light, time_s
        self._center_m = np.array([0, 0, -_BEHIND * target.diameter_m])
        with as_named(normal="facing"):
            falls = sum(light.irradiance(target.facing))
        if not np.any(falls):
            warn_caller(
                f"target: no light falls on the side {target.facing} that the disc and its ground "
                "face, so that both are black; turn facing towards the light, and take a "
                "SceneTarget where lamps of a scene light it",
                UserWarning,
            )
        # (2, B), of ground and disc.
        self._radiance = np.array(
            [
                falls / math.pi * _band_means(light.bands, getattr(target, name), name)
                for name in ("background", "reflectance")
            ]
        )
        x, _, z = target.facing
        ahead = (-x, 0.0, -z) if x or z else (0.0, 0.0, -1.0)
        self._horizon = replace(light, discs=()).radiance(ahead)[0]
        # 1 on the disc and 0 beside it, in one band: the share of the disc in what is seen.
        self._world = World(
            disc(
                target.diameter_m / 2,
                center_m=self._center_m,
                segments=_CORNERS,
            ),
            background=Background.constant((0, 0, 0)),
            band_from_rgb=[[0, 1, 0]],
        )

    def through(self, ommatidia: NDArray[np.intp], sampling: Fixed, seed: int) -> DiscSeen:
        """What these ommatidia see, by so many rays."""
        eye = self._whole.take(ommatidia)
        matrix = receptor_matrix(eye, bands=self._light.bands)
        air = self._light.extinction_per_m
        # Photons for a response of 1.
        each = photon_catch(
            eye, np.ones(len(eye.receptor_type)), self._light, integration_time_s=self._time_s
        )

        def catches(distance_m: float) -> tuple[Floats, Floats]:
            left = 1.0 if air is None else np.exp(-air * distance_m)
            ground, disc = (
                (matrix @ radiance)[eye.receptor_type] * each
                for radiance in left * self._radiance + (1 - left) * self._horizon
            )
            return ground, disc - ground

        renderer = Renderer(self._world, eye, sampling, seed=seed)
        pose = self.pose_on(self._center_m, np.array([0.0, 0.0, 1.0]))
        return DiscSeen(renderer, pose, catches)


class DiscSeen:
    """Responses to a disc at any distance, of one eye.

    catches: at a distance, m, what its receptors catch where the ground fills their acceptance, and
        how much more where the disc does; through the air that there is.
    """

    def __init__(
        self, renderer: Renderer, on_disc: Floats, catches: Callable[[float], tuple[Floats, Floats]]
    ):
        self._eye = renderer.eye
        self._renderer, self._on_disc, self._catches = renderer, on_disc, catches

    def at(self, distance_m: float) -> Seen:
        """From this distance between the disc's middle and the head's origin."""
        pose = self._on_disc.copy()
        pose[2, 3] += distance_m
        ones = np.ones((len(self._eye.receptor_types), 1))
        with warnings.catch_warnings():
            # Of far heads: rays are rounded by 2⁻²⁴ of the distance, all alike, which shifts the
            # disc by so much (`View.farthest_m`).
            warnings.simplefilter("ignore", RuntimeWarning)
            share, error = self._renderer.render_receptors(pose, matrix=ones, standard_error=True)
        share, error = share[0].astype(np.float64), error[0].astype(np.float64)
        ground, more = self._catches(distance_m)
        same = not np.any(more)
        enough = same or met(share, error)
        return Seen(self._eye, ground, more * share, np.abs(more) * error, enough)


def _band_means(bands: Bands, reflectance: Spectrum | float, name: str) -> Floats:
    if isinstance(reflectance, float):
        return np.full(len(bands), reflectance)
    with as_named(spectrum=name):
        return bands.mean(reflectance)
