"""Bees: the honeybee's worker and drone, and a bumblebee worker.

Worker: the directions are those of the model of Giger (1996) as given by Stürzl et al. (2010):
rows of ommatidia at half the vertical interommatidial angle, every other row shifted by half a
column. They are the same as those of examples/make_honeybee.py, to the last digit but rounding.
"""

from __future__ import annotations

import math

import numpy as np

from omma._core import Acceptance, Eye
from omma.base.arrays import Floats
from omma.base.directions import direction
from omma.base.progress import Stage
from omma.eye.facets import set_facets
from omma.receptors.mosaic import OmmatidiumType
from omma.species._receptors import bee_kinds, bee_receptors, mixed
from omma.species._shape import (
    angle_from,
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

_WORKER = "honeybee_worker"
_DRONE = "honeybee_drone"
_BUMBLEBEE = "bumblebee"


def build_honeybee_worker(progress: Stage | None) -> list[Eye]:
    """The right eye, grown anew."""
    if progress:
        progress("placing ommatidia", None)
    azimuth, elevation = worker_directions_deg()
    axis = direction(azimuth, elevation)
    eye = Eye(
        _worker_surface_m(azimuth, elevation),
        axis,
        eye_id=1,
        acceptance=Acceptance.gaussian(number(_WORKER, "acceptance_angle")),
        columns={"region": ["eye"] * len(axis)},
    )
    kinds = bee_kinds(
        _WORKER,
        _WORKER,
        absorption_per_m=number(_WORKER, "absorption"),
        length_m=number(_WORKER, "rhabdom_length"),
    )
    return [mixed(set_facets(eye), kinds)]


def worker_directions_deg() -> tuple[Floats, Floats]:
    """Azimuth and elevation (N,) of the right eye's axes, row by row from below, the odd ones
    counted the other way."""
    azimuths: list[float] = []
    elevations: list[float] = []
    for count, (row, elevation) in enumerate(_row_elevations_deg()):
        here = _row_azimuths_deg(row, elevation)
        azimuths += here[::-1] if count % 2 else here
        elevations += [elevation] * len(here)
    return np.array(azimuths), np.array(elevations)


def _row_elevations_deg() -> list[tuple[int, float]]:
    level, pole = (degrees(_WORKER, f"vertical_angle_at_{at}") for at in ("equator", "pole"))
    above = [0.0]
    while True:
        following = above[-1] + (level + (pole - level) * above[-1] / 90.0) / 2
        if following >= 90:
            break
        above.append(following)
    last = len(above) - 1
    return [(k, math.copysign(above[abs(k)], k)) for k in range(-last, last + 1)]


def _row_azimuths_deg(row: int, elevation: float) -> list[float]:
    # Columns are counted from straight ahead, both ways.
    first = _azimuth_step_deg(0, elevation) / 2 if row % 2 else 0.0
    azimuths = []
    azimuth = first
    while azimuth <= _temporal_edge_deg(elevation):
        azimuths.append(azimuth)
        azimuth += _azimuth_step_deg(azimuth, elevation)
    azimuth = first - _azimuth_step_deg(0, elevation)
    while azimuth >= _nasal_edge_deg(elevation):
        azimuths.insert(0, azimuth)
        azimuth -= _azimuth_step_deg(azimuth, elevation)
    return azimuths


def _azimuth_step_deg(azimuth: float, elevation: float) -> float:
    ahead, least, behind = (
        degrees(_WORKER, f"horizontal_angle_{where}") for where in ("ahead", "least", "behind")
    )
    angle = float(np.interp(azimuth, [0, 45, 90, 150], [ahead, least, ahead, behind]))
    if abs(elevation) > 50 and 90 < azimuth < 180:
        angle = ahead + (angle - ahead) * (90 - abs(elevation)) / 40
    # Near the poles the wanted angle is wider than the circle of latitude: half a turn then.
    ratio = min(1.0, math.sin(math.radians(angle) / 2) / math.cos(math.radians(elevation)))
    return 2 * math.degrees(math.asin(ratio))


def _temporal_edge_deg(elevation: float) -> float:
    at, edge = (
        [degrees(_WORKER, f"temporal_edge_{k}_{what}") for k in range(1, 6)]
        for what in ("elevation", "azimuth")
    )
    return float(np.interp(elevation, at, edge))


def _nasal_edge_deg(elevation: float) -> float:
    # Three values are published; the edge is smooth on the real eye, so a parabola on each side.
    level = degrees(_WORKER, "nasal_edge_level")
    far = degrees(_WORKER, "nasal_edge_up" if elevation > 0 else "nasal_edge_down")
    return level + (far - level) * min(1.0, abs(elevation) / 60.0) ** 2


def _worker_surface_m(azimuth: Floats, elevation: Floats) -> Floats:
    # Latitude on the ellipsoid is the elevation of the axis; longitude runs evenly from the nasal
    # to the temporal edge of the row.
    nasal = np.array([_nasal_edge_deg(e) for e in elevation])
    temporal = np.array([_temporal_edge_deg(e) for e in elevation])
    fraction = 2 * (azimuth - nasal) / (temporal - nasal) - 1
    longitude = number(_WORKER, "surface_half_width") * fraction
    latitude = np.radians(elevation)
    unit = np.stack(
        [
            np.cos(latitude) * np.cos(longitude),
            np.sin(latitude),
            np.cos(latitude) * np.sin(longitude),
        ],
        axis=1,
    )
    centre, semi_axes = (
        np.array([number(_WORKER, f"eye_{what}_{way}") for way in ("right", "up", "forward")])
        for what in ("centre", "semi_axis")
    )
    return np.asarray(centre * [1, 1, -1] + semi_axes * unit)


def build_honeybee_drone(progress: Stage | None) -> list[Eye]:
    """The right eye, grown anew."""

    def dorsal(elevation: Floats) -> Floats:
        border = number(_DRONE, "border_elevation")
        half = number(_DRONE, "border_half_width")
        return smooth_step(elevation, border - half, border + half)

    def between(quantity: str, elevation: Floats) -> Floats:
        below, above = (number(_DRONE, f"{part}_{quantity}") for part in ("ventral", "dorsal"))
        return blended(below, above, dorsal(elevation))

    def angle_per_facet(from_zenith: Floats) -> Floats:
        elevation = math.pi / 2 - from_zenith
        ratio = between("interommatidial_angle", elevation) / between("facet_diameter", elevation)
        # All of it would give facets four times as long as wide below.
        return np.asarray(np.sqrt(ratio))

    axis = laid(
        _DRONE,
        lambda directions: between("interommatidial_angle", elevation_rad(directions)),
        None,
        oval((-20, 165), (-75, 95)),
        progress,
    )
    up = elevation_rad(axis)
    upper = dorsal(up) > 0.5
    eye = on_ellipsoid(
        _DRONE, axis, (0, 90), "dorsal_facet_diameter", angle_at=angle_per_facet
    ).replace(
        facet_diameter_m=between("facet_diameter", up),
        acceptance=graded(between("acceptance_angle", up)),
        columns={"region": ["dorsal" if up else "ventral" for up in upper]},
    )
    eye = mixed(mixed(eye, bee_kinds(_DRONE, _WORKER)), _dorsal_kinds(), upper)
    return [eye]


def _dorsal_kinds() -> list[OmmatidiumType]:
    # Blue, with none, one or two ultraviolet receptors; no green.
    ultraviolet, blue, _ = bee_receptors(_DRONE)
    most = round(number(_DRONE, "dorsal_uv_receptors_most"))
    return [
        OmmatidiumType(f"dorsal {k}", (ultraviolet,) * k + (blue,) * (8 - k))
        for k in range(most + 1)
    ]


def build_bumblebee(progress: Stage | None) -> list[Eye]:
    """The right eye, grown anew."""
    least, largest = (
        number(_BUMBLEBEE, f"{which}_interommatidial_angle") for which in ("least", "largest")
    )

    wider = number(_BUMBLEBEE, "horizontal_over_vertical")
    acute = degrees(_BUMBLEBEE, "acute_azimuth")

    def angle_at(from_acute: Floats) -> Floats:
        # Such a course, in such a field, has the scan's percentiles and number of ommatidia.
        edge = smooth_step(from_acute, 0.0, math.radians(80))
        return blended(least, 1.15 * largest, edge)

    axis = laid(
        _BUMBLEBEE,
        lambda directions: math.sqrt(wider) * angle_at(angle_from(directions, acute, 0)),
        lambda directions: angle_at(angle_from(directions, acute, 0)) / math.sqrt(wider),
        oval((-25, 110), (-72, 55)),
        progress,
    )
    eye = on_ellipsoid(
        _BUMBLEBEE, axis, (acute, 0), "median_facet_diameter", angle_at=angle_at
    ).replace(
        acceptance=Acceptance.gaussian(number(_BUMBLEBEE, "acceptance_angle")),
        columns={"region": ["eye"] * len(axis)},
    )
    return [mixed(eye, bee_kinds(_BUMBLEBEE, _BUMBLEBEE))]
