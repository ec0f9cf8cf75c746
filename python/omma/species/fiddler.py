"""A fiddler crab, whose eyes on stalks see all round, finest just above and below the horizon."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.eye_facets import acceptance_from_facets, set_facets
from omma.eye_surface import eye_on_surface
from omma.receptor_mosaic import OmmatidiumType
from omma.species._receptors import mixed, receptor
from omma.species._shape import (
    Floats,
    Progress,
    blended,
    elevation_rad,
    laid,
    smooth_step,
    species,
)
from omma.species.facts import Species, number
from omma.surfaces import ellipsoid

_CRAB = "fiddler_crab"


def fiddler_crab(progress: Progress | None = None) -> Species:
    """A fiddler crab, after *Gelasimus* (*Uca*) *vomeris*.

    A panoramic equatorial zone of fine vertical angles, a steeper gradient above it than below,
    little change horizontally, larger facets at the equator: Zeil & Al-Mutairi 1996, J Exp Biol
    199:1569 (*Uca lactea annulipes*). Two streaks just above and below the horizon: Bagheri et al.
    2020, J Exp Biol 223:jeb210195. Receptors: Jordão et al. 2007 (R1-7), J Exp Biol 223:jeb230979
    (R8); microvilli of R3, R4, R7 horizontal, of the others vertical: Alkaladi & Zeil 2014.
    Assumed: every angle's number, the number of ommatidia, the facet, acceptance by diffraction,
    the polarisation sensitivity.
    """
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

    def vertical(directions: Floats) -> Floats:
        up = elevation_rad(directions)
        off = np.where(
            up > 0,
            smooth_step(up - at, 0.0, number(_CRAB, "dorsal_gradient_reach")),
            smooth_step(-up - at, 0.0, number(_CRAB, "ventral_gradient_reach")),
        )
        angle = blended(streak, np.where(up > 0, above, below), off)
        # A little coarser on the horizon itself, between the two streaks.
        between = number(_CRAB, "dip_between_streaks") * np.exp(-((2 * up / at) ** 2))
        return np.asarray(angle * (1 + between))

    lowest, highest = (number(_CRAB, f"field_{end}") for end in ("lowest", "highest"))

    def seen(directions: Floats) -> NDArray[np.bool_]:
        up = elevation_rad(directions)
        return np.asarray((up > lowest) & (up < highest))

    axis = laid(_CRAB, lambda directions: np.full(len(directions), level), vertical, seen, progress)
    # On an ellipsoid of revolution of semi-axes a (level) and c (upright) the radii of curvature
    # at the equator are a and c²/a, and a facet is a times the horizontal angle, c²/a times the
    # vertical one.
    across = number(_CRAB, "facet_diameter") / level
    upright = across * math.sqrt(level / streak)
    centre = (number(_CRAB, "eye_centre_right"), number(_CRAB, "eye_centre_up"), 0.0)
    eye = eye_on_surface(axis, ellipsoid((across, upright, across), centre), eye_id=1)
    eye = acceptance_from_facets(set_facets(eye), wavelength_nm=number(_CRAB, "green_peak"))
    up = elevation_rad(axis)
    region = np.where(np.abs(up) < 2 * at, "streaks", np.where(up > 0, "dorsal", "ventral"))
    eye = eye.replace(columns={"region": region.tolist()})
    return species(_CRAB, "Gelasimus vomeris", _crab_receptors(eye))


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
