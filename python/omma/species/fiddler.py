"""A fiddler crab, whose eyes on stalks see all round, finest just above and below the horizon."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.base.arrays import Floats
from omma.base.progress import Stage
from omma.eye.facets import acceptance_from_facets
from omma.receptors.mosaic import OmmatidiumType
from omma.species._receptors import mixed, receptor
from omma.species._revolution import Profile
from omma.species._shape import blended, elevation_rad, laid, smooth_step
from omma.species.facts import number

_CRAB = "fiddler_crab"


def build_fiddler_crab(progress: Stage | None) -> list[Eye]:
    """The right eye, grown anew."""
    streak, above, below, level = (
        number(_CRAB, name)
        for name in (
            "streak_vertical_angle",
            "dorsal_vertical_angle",
            "ventral_vertical_angle",
            "horizontal_angle",
        )
    )
    at = number(_CRAB, "streak_elevation")
    equator, outer = number(_CRAB, "facet_diameter"), number(_CRAB, "outer_facet_diameter")

    def off(up: Floats) -> Floats:
        """0 at the streaks and between them, 1 where the gradient has ended."""
        return np.where(
            up > 0,
            smooth_step(up - at, 0.0, number(_CRAB, "dorsal_gradient_reach")),
            smooth_step(-up - at, 0.0, number(_CRAB, "ventral_gradient_reach")),
        )

    def facet(up: Floats) -> Floats:
        return blended(equator, outer, off(up))

    def vertical(up: Floats) -> Floats:
        angle = blended(streak, np.where(up > 0, above, below), off(up))
        # A little coarser on the horizon itself, between the two streaks.
        between = number(_CRAB, "dip_between_streaks") * np.exp(-((2 * up / at) ** 2))
        return np.asarray(angle * (1 + between))

    # A surface of revolution about the upright: facets and vertical angles give the curvature of
    # its meridian, that its girth, and that the horizontal angles.
    upper = Profile(lambda angle: facet(angle) / vertical(angle), math.pi / 2)
    lower = Profile(lambda angle: facet(-angle) / vertical(-angle), math.pi / 2)

    def girth_m(up: Floats) -> Floats:
        return equator / level - np.where(up > 0, upper.drop(up), lower.drop(up))

    lowest, highest = (number(_CRAB, f"field_{end}") for end in ("lowest", "highest"))

    def seen(directions: Floats) -> NDArray[np.bool_]:
        up = elevation_rad(directions)
        return np.asarray((up > lowest) & (up < highest))

    def horizontal(directions: Floats) -> Floats:
        up = elevation_rad(directions)
        return np.asarray(facet(up) * np.cos(up) / girth_m(up))

    axis = laid(
        _CRAB, horizontal, lambda directions: vertical(elevation_rad(directions)), seen, progress
    )
    up = elevation_rad(axis)
    girth, height = girth_m(up), np.where(up > 0, upper.along(up), lower.along(up))
    across = axis[:, [0, 2]] / np.cos(up)[:, None] * girth[:, None]
    centre = [number(_CRAB, "eye_centre_right"), number(_CRAB, "eye_centre_up"), 0.0]
    position = np.stack([across[:, 0], height, across[:, 1]], axis=1) + centre
    eye = Eye(position, axis, 0.0, eye_id=1, facet_diameter_m=facet(up))
    eye = acceptance_from_facets(eye, wavelength_nm=number(_CRAB, "green_peak"))
    region = np.where(np.abs(up) < 2 * at, "streaks", np.where(up > 0, "dorsal", "ventral"))
    eye = eye.replace(columns={"region": region.tolist()})
    return [_crab_receptors(eye)]


def _crab_receptors(eye: Eye) -> Eye:
    ps = number(_CRAB, "ps")
    upright, level = (
        receptor(
            _CRAB, name, "green_peak", polarisation_sensitivity=ps, microvillus_angle_rad=angle
        )
        for name, angle in (("R1, R2, R5, R6", 0.0), ("R3, R4, R7", math.pi / 2))
    )
    many = round(number(_CRAB, "microvilli_cells_horizontal"))
    cells = (upright,) * (7 - many) + (level,) * many + (receptor(_CRAB, "R8", "uv_peak"),)
    return mixed(eye, [OmmatidiumType("usual", cells)])
