"""Desert ants: Cataglyphis with its dorsal rim area, and Melophorus."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from omma._core import Acceptance, Eye
from omma.base.arrays import Floats
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.progress import Stage
from omma.receptors.mosaic import OmmatidiumType
from omma.species._receptors import mixed, receptor
from omma.species._shape import (
    blended,
    degrees,
    elevation_rad,
    graded,
    laid,
    on_ellipsoid,
    oval,
    smooth_step,
)
from omma.species.facts import number

_CATAGLYPHIS = "cataglyphis"
_MELOPHORUS = "melophorus"


def build_cataglyphis(progress: Stage | None) -> list[Eye]:
    """The right eye, grown anew."""
    outer = number(_CATAGLYPHIS, "outer_angle")
    streak = number(_CATAGLYPHIS, "streak_vertical_angle")
    level = number(_CATAGLYPHIS, "horizontal_angle")
    rim_angle = number(_CATAGLYPHIS, "dorsal_rim_interommatidial_angle")

    def horizontal(directions: Floats) -> Floats:
        return blended(level, rim_angle, _rim_fraction(directions))

    def vertical(directions: Floats) -> Floats:
        off = smooth_step(np.abs(elevation_rad(directions)), 0.0, math.radians(45))
        return blended(blended(streak, outer, off), rim_angle, _rim_fraction(directions))

    axis = laid(_CATAGLYPHIS, horizontal, vertical, oval((-10, 150), (-50, 75)), progress)
    count = round(number(_CATAGLYPHIS, "dorsal_rim_ommatidia"))
    rim = np.zeros(len(axis), bool)
    rim[np.argsort(_rim_distance(axis), kind="stable")[:count]] = True
    usual, wide = (
        number(_CATAGLYPHIS, name) for name in ("acceptance_angle", "dorsal_rim_acceptance_angle")
    )
    eye = on_ellipsoid(_CATAGLYPHIS, axis, (70, 12), "facet_diameter").replace(
        acceptance=graded(np.where(rim, wide, usual)),
        columns={"region": ["dorsal rim" if there else "eye" for there in rim]},
    )
    return [_ant_receptors(eye, rim)]


def _rim_distance(directions: Floats) -> Floats:
    # From the rim's centre, in half heights, elevation as published and as far across.
    low, high, centre = (
        degrees(_CATAGLYPHIS, f"dorsal_rim_{name}")
        for name in ("lowest_elevation", "highest_elevation", "azimuth")
    )
    azimuth, elevation = azimuth_elevation_deg_of(directions)
    up = (elevation - (low + high) / 2) / ((high - low) / 2)
    across = (azimuth - centre) * np.cos(np.radians(elevation)) / ((high - low) / 2)
    return np.maximum(np.abs(up), np.abs(across))


def _rim_fraction(directions: Floats) -> Floats:
    return 1 - smooth_step(_rim_distance(directions), 0.9, 1.3)


def _ant_receptors(eye: Eye, rim: NDArray[np.bool_]) -> Eye:
    ultraviolet, green = (
        receptor(_CATAGLYPHIS, name, peak, polarisation_sensitivity=number(_CATAGLYPHIS, ps))
        for name, peak, ps in (
            ("ultraviolet", "uv_peak", "uv_ps"),
            ("green", "green_peak", "green_ps"),
        )
    )
    along, across = (
        receptor(
            _CATAGLYPHIS,
            f"dorsal rim ultraviolet {name}",
            "uv_peak",
            polarisation_sensitivity=number(_CATAGLYPHIS, "dorsal_rim_uv_ps"),
            microvillus_angle_rad=angle,
        )
        for name, angle in (("along", 0.0), ("across", math.pi / 2))
    )
    # The fan: the up vector, to which microvilli are referred, turns through half a turn.
    azimuth = azimuth_elevation_deg_of(eye.axis[rim])[0]
    rank = np.argsort(np.argsort(azimuth, kind="stable"), kind="stable")
    turn = (math.pi * (rank + 0.5) / len(rank))[:, None]
    up = eye.up.copy()
    up[rim] = np.cos(turn) * eye.up[rim] + np.sin(turn) * eye.right[rim]
    eye = mixed(eye.replace(up=up), [OmmatidiumType("usual", (ultraviolet, green))])
    return mixed(eye, [OmmatidiumType("dorsal rim", (along, across, green))], rim)


def build_melophorus(progress: Stage | None) -> list[Eye]:
    """The right eye, grown anew."""
    angle = number(_MELOPHORUS, "mean_interommatidial_angle")
    width = degrees(_MELOPHORUS, "horizontal_field")
    height = degrees(_MELOPHORUS, "vertical_field")
    axis = laid(
        _MELOPHORUS,
        lambda directions: np.full(len(directions), angle),
        None,
        oval((-15, width - 15), (-height / 2, height / 2)),
        progress,
    )
    eye = on_ellipsoid(_MELOPHORUS, axis, (60, 0), "facet_diameter").replace(
        acceptance=Acceptance.gaussian(number(_MELOPHORUS, "acceptance_angle")),
        columns={"region": ["eye"] * len(axis)},
    )
    both = tuple(
        receptor(_MELOPHORUS, name, peak)
        for name, peak in (("ultraviolet", "uv_peak"), ("green", "green_peak"))
    )
    eye = mixed(eye, [OmmatidiumType("usual", both)])
    return [eye]
