"""Hunters with foveas: the robber fly Holcocephala fusca and the dragonfly Anax junius.

Large facets and small angles between axes at once mean a surface that is nearly flat: radius of
curvature R = D/Δφ. Both eyes are made from such radii and facets; axes are the surface's normals,
and the angles along and across follow.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.base.arrays import Floats
from omma.base.progress import Stage
from omma.eye.facets import acceptance_from_facets
from omma.eye.on_surface import lay_on_surface
from omma.receptors.mosaic import OmmatidiumType
from omma.species._receptors import mixed, receptor
from omma.species._revolution import Profile, Revolution
from omma.species._shape import blended, laid, smooth_step
from omma.species.facts import number

_HOLCOCEPHALA = "holcocephala"
_DRAGONFLY = "dragonfly"


def build_holcocephala(progress: Stage | None) -> list[Eye]:
    """The right eye, grown anew."""
    front, side = (
        number(_HOLCOCEPHALA, f"{part}_radius_of_curvature") for part in ("front", "side")
    )
    inner, outer = (
        number(_HOLCOCEPHALA, f"{which}_facet_diameter") for which in ("largest", "outer")
    )
    fovea = number(_HOLCOCEPHALA, "fovea_half_width")
    profile = Profile(
        lambda angle: blended(front, side, smooth_step(angle, 0.3 * fovea, 1.2 * fovea)), math.pi
    )
    tip = np.array([number(_HOLCOCEPHALA, "eye_centre_right"), 0.0, 0.0])
    surface = Revolution(profile, number(_HOLCOCEPHALA, "eye_edge"), tip)

    def facet(angle: Floats) -> Floats:
        return blended(inner, outer, smooth_step(angle, 0.3 * fovea, 1.5 * fovea))

    nasal = math.sin(number(_HOLCOCEPHALA, "nasal_edge"))
    eye = lay_on_surface(
        surface,
        lambda points: facet(surface.angle(points)),
        progress=progress,
    )
    # What would look too far across the head is left out.
    eye = eye.take(np.flatnonzero(eye.axis[:, 0] > -nasal))
    angle = surface.angle(eye.position_m.astype(np.float64))
    region = np.where(angle < fovea, "fovea", "eye").tolist()
    eye = eye.replace(eye_id=1, facet_diameter_m=facet(angle), columns={"region": region})
    eye = acceptance_from_facets(eye, wavelength_nm=number(_HOLCOCEPHALA, "wavelength"))
    return [eye]


def build_dragonfly(progress: Stage | None) -> list[Eye]:
    """The right eye, grown anew."""
    barrel = _Barrel()
    low, high, back, ahead = (
        number(_DRAGONFLY, f"edge_{where}") for where in ("below", "above", "behind", "ahead")
    )

    def seen(directions: Floats) -> NDArray[np.bool_]:
        around, forward = barrel.angles(directions)
        middle, half = (low + high) / 2, (high - low) / 2
        centre, reach = (ahead + back) / 2, (ahead - back) / 2
        inside = ((around - middle) / half) ** 4 + ((forward - centre) / reach) ** 4 <= 1
        return np.asarray(inside, dtype=bool)

    canonical = laid(_DRAGONFLY, barrel.along_rad, barrel.across_rad, seen, progress)
    around, forward = barrel.angles(canonical)
    from_axis, to_front = barrel.surface(around, forward)
    position = np.stack([from_axis * np.cos(around), from_axis * np.sin(around), -to_front], axis=1)
    position += [number(_DRAGONFLY, "eye_centre_right"), 0.0, 0.0]
    x, y, z = canonical.T
    band = (barrel.dorsal(around) > 0.5) & (np.abs(forward) < barrel.half)
    eye = Eye(
        position,
        np.stack([-z, x, -y], axis=1),
        0.0,
        eye_id=1,
        facet_diameter_m=barrel.facet(around, forward),
        columns={"region": np.where(band, "dorsal band", "eye").tolist()},
    )
    eye = acceptance_from_facets(eye, wavelength_nm=number(_DRAGONFLY, "wavelength"))
    return [_dragonfly_receptors(eye, barrel.dorsal(around))]


class _Barrel:
    """The dragonfly's eye: a barrel whose axis runs along the animal, its profile flat above.

    In the canonical frame that axis is up: ``around`` runs from the side (0) over the top (a
    quarter turn), ``forward`` from the plane of the band to the front.
    """

    def __init__(self) -> None:
        self.large, self.small = (
            number(_DRAGONFLY, f"{which}_facet_diameter") for which in ("largest", "ventral")
        )
        self.radius = number(_DRAGONFLY, "eye_radius")
        self.half = number(_DRAGONFLY, "band_half_width")
        flat, end = number(_DRAGONFLY, "band_radius_of_curvature"), self.radius / 2
        self._above = Profile(
            lambda angle: blended(flat, end, smooth_step(angle, 0.3 * self.half, 2 * self.half)),
            math.pi / 2,
        )
        self._below = Profile(lambda angle: np.full(len(angle), self.radius), math.pi / 2)

    def angles(self, directions: Floats) -> tuple[Floats, Floats]:
        x, y, z = directions.T
        return np.arctan2(x, -z), np.arcsin(np.clip(y, -1.0, 1.0))

    def dorsal(self, around: Floats) -> Floats:
        """0 in the ventral eye, 1 in the dorsal."""
        return smooth_step(around, math.radians(-20), math.radians(35))

    def facet(self, around: Floats, forward: Floats) -> Floats:
        """Facet diameter, metres."""
        in_band = 1 - smooth_step(np.abs(forward), self.half, 6 * self.half)
        return blended(self.small, self.large, self.dorsal(around) * in_band)

    def surface(self, around: Floats, forward: Floats) -> tuple[Floats, Floats]:
        """Distance from the barrel's axis and how far forward along it, metres."""
        fraction = self.dorsal(around)
        drop = (1 - fraction) * self._below.drop(forward) + fraction * self._above.drop(forward)
        along = (1 - fraction) * self._below.along(forward) + fraction * self._above.along(forward)
        return self.radius - drop, along

    def across_rad(self, directions: Floats) -> Floats:
        """The angle to a neighbour across the band."""
        around, forward = self.angles(directions)
        above = self.dorsal(around)
        radius = (1 - above) * self._below.radius(forward) + above * self._above.radius(forward)
        return self.facet(around, forward) / radius

    def along_rad(self, directions: Floats) -> Floats:
        """The angle to a neighbour along the band."""
        around, forward = self.angles(directions)
        from_axis = self.surface(around, forward)[0]
        return self.facet(around, forward) * np.cos(forward) / from_axis


def _dragonfly_receptors(eye: Eye, dorsal: Floats) -> Eye:
    ultraviolet, violet, green, orange = (
        receptor(_DRAGONFLY, name, f"{name}_peak")
        for name in ("ultraviolet", "violet", "green", "orange")
    )
    below = OmmatidiumType("ventral", (ultraviolet, violet, green, orange))
    above = OmmatidiumType("dorsal", (ultraviolet, violet))
    return mixed(mixed(eye, [below]), [above], dorsal > 0.5)
