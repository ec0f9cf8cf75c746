"""Writes the two eyes of a honeybee worker, honeybee_worker_left.eye and honeybee_worker_right.eye.

The directions are those of the model of Giger (1996) as given by Stürzl et al. (2010): rows of
ommatidia at half the vertical interommatidial angle, every other row shifted by half a column.
Azimuth is measured from straight ahead to the eye's own side and passes 180 degrees where the eye
looks across the back; elevation is positive upwards.

    python examples/make_honeybee.py [folder]

Only the standard library is used, so that the bytes do not depend on a library's sine.
"""

import math
import sys
from pathlib import Path

ACCEPTANCE_DEG = 2.6  # Eheim & Wehner (1972) measured 2.57 degrees optically

# (elevation, azimuth of the temporal edge), degrees, from Giger (1996).
TEMPORAL_EDGE_DEG = [(-60.2, 176.8), (-30.3, 166.8), (0.0, 156.7), (30.1, 174.3), (58.9, 215.8)]
NASAL_EDGE_LEVEL_DEG = -14.5
NASAL_EDGE_UP_DEG = -42.0  # at elevation +60
NASAL_EDGE_DOWN_DEG = -52.0  # at elevation -60

# The surface on which the lenses sit is an assumption, not part of the model: a half ellipsoid of
# the size of a worker's eye (length 2.6 mm, lenses to 20 micrometres across: Somanathan et al.
# 2009, J Exp Biol 212:2448, Table 1; the micro-CT of one worker by G. Taylor, MorphoSource
# 00000C646: 2.4 x 0.9 x 0.7 mm, 1.1 to 1.9 mm from the mid-line).
EYE_CENTRE_MM = (1.4, 0.05, 0.0)
EYE_SEMI_AXES_MM = (0.42, 1.2, 0.4)  # sideways, upwards, forwards
SURFACE_HALF_WIDTH_DEG = 75.0  # longitude of the nasal and temporal edge on the ellipsoid


def interpolate(x, points):
    """Piecewise linear through points (x, y) sorted by x, constant beyond the first and last."""
    if x <= points[0][0]:
        return points[0][1]
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        if x <= x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    return points[-1][1]


def vertical_angle_deg(elevation_deg):
    return 1.5 + 3.0 * abs(elevation_deg) / 90.0


def horizontal_angle_deg(azimuth_deg, elevation_deg):
    # The function is given from straight ahead on; across the mid-line its value there is kept.
    angle = interpolate(azimuth_deg, [(0, 3.7), (45, 2.4), (90, 3.7), (150, 4.6)])
    if abs(elevation_deg) > 50 and 90 < azimuth_deg < 180:
        angle = 3.7 + (angle - 3.7) * (90 - abs(elevation_deg)) / 40
    return angle


def azimuth_step_deg(azimuth_deg, elevation_deg):
    half = math.radians(horizontal_angle_deg(azimuth_deg, elevation_deg)) / 2
    # Near the poles the wanted angle is wider than the circle of latitude: half a turn then.
    ratio = min(1.0, math.sin(half) / math.cos(math.radians(elevation_deg)))
    return 2 * math.degrees(math.asin(ratio))


def temporal_edge_deg(elevation_deg):
    # Linear between the five published values. Above and below them nothing is published; the last
    # value is kept, which matters for few axes only as the circles of latitude close there.
    return interpolate(elevation_deg, TEMPORAL_EDGE_DEG)


def nasal_edge_deg(elevation_deg):
    # Three values are published. The edge is a smooth line on the real eye, so it gets a parabola
    # with its vertex at the equator on each side (straight lines would meet there in a corner, and
    # give 2 % more axes); beyond 60 degrees the value is kept, as for the temporal edge.
    far = NASAL_EDGE_UP_DEG if elevation_deg > 0 else NASAL_EDGE_DOWN_DEG
    fraction = min(1.0, abs(elevation_deg) / 60.0) ** 2
    return NASAL_EDGE_LEVEL_DEG + (far - NASAL_EDGE_LEVEL_DEG) * fraction


def row_elevations_deg():
    """[(row number, elevation)] from the lowest row to the highest; row 0 is the equator."""
    above = [0.0]
    while True:
        following = above[-1] + vertical_angle_deg(above[-1]) / 2
        if following >= 90:
            break
        above.append(following)
    last = len(above) - 1
    return [(k, math.copysign(above[abs(k)], k)) for k in range(-last, last + 1)]


def row_azimuths_deg(row, elevation_deg):
    """Azimuths of one row, ascending. Columns are counted from straight ahead, both ways."""
    first = azimuth_step_deg(0, elevation_deg) / 2 if row % 2 else 0.0
    azimuths = []
    azimuth = first
    while azimuth <= temporal_edge_deg(elevation_deg):
        azimuths.append(azimuth)
        azimuth += azimuth_step_deg(azimuth, elevation_deg)
    azimuth = first - azimuth_step_deg(0, elevation_deg)
    while azimuth >= nasal_edge_deg(elevation_deg):
        azimuths.insert(0, azimuth)
        azimuth -= azimuth_step_deg(azimuth, elevation_deg)
    return azimuths


def axis(azimuth_deg, elevation_deg):
    """Unit vector of a right eye: x right, y up, z forward."""
    a, e = math.radians(azimuth_deg), math.radians(elevation_deg)
    return (math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e))


def surface_point_mm(azimuth_deg, elevation_deg):
    """Where on the right eye the lens sits that looks there.

    Latitude on the ellipsoid is the elevation of the axis; longitude runs evenly from the nasal to
    the temporal edge of the row. So the axis is not the surface's normal, as on the real eye, which
    sees far more than its own curvature spans; lenses come out 21 micrometres apart (median).
    """
    nasal, temporal = nasal_edge_deg(elevation_deg), temporal_edge_deg(elevation_deg)
    fraction = 2 * (azimuth_deg - nasal) / (temporal - nasal) - 1  # -1 nasal, 1 temporal
    longitude = math.radians(SURFACE_HALF_WIDTH_DEG * fraction)
    latitude = math.radians(elevation_deg)
    unit = (
        math.cos(latitude) * math.cos(longitude),
        math.sin(latitude),
        -math.cos(latitude) * math.sin(longitude),
    )
    return tuple(c + s * u for c, s, u in zip(EYE_CENTRE_MM, EYE_SEMI_AXES_MM, unit))


def eye_text(side):
    """The .eye file: side is +1 for the right eye, -1 for the left, its mirror image."""
    lines = []
    acceptance = f"{math.radians(ACCEPTANCE_DEG):.8g}"
    for number, (row, elevation) in enumerate(row_elevations_deg()):
        azimuths = row_azimuths_deg(row, elevation)
        if number % 2:
            azimuths.reverse()  # serpentine: neighbours in the file are neighbours in space
        for azimuth in azimuths:
            x, y, z = surface_point_mm(azimuth, elevation)
            dx, dy, dz = axis(azimuth, elevation)
            # Adding 0.0 turns a rounded -0.0 into 0.0.
            position = (f"{round(v, 6) + 0.0:.7g}" for v in (side * x, y, z))
            direction = (f"{round(v, 8) + 0.0:.9g}" for v in (side * dx, dy, dz))
            lines.append(" ".join([*position, *direction, acceptance, "0"]))
    return "\n".join(lines) + "\n"


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent
    for name, side in (("left", -1), ("right", 1)):
        path = folder / f"honeybee_worker_{name}.eye"
        text = eye_text(side)
        path.write_text(text, encoding="ascii", newline="\n")
        count = text.count("\n")
        print(f"{path}: {count} ommatidia, {len(text) / 1000:.0f} kB")


if __name__ == "__main__":
    main()
