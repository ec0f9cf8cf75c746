"""One eye of FlyGym's: where its hexagons look, by its camera's picture and the fisheye lens that
bends it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, positive, within
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.base.optional import needs

# What FlyGym 2.1 has in its vision.yaml.
FOVY_DEG, DISTORTION, ZOOM = 157.0, 3.8, 2.72


@checked
def fly_eye(
    ommatidia_id_map: ArrayLike,
    *,
    fovy_deg: float = FOVY_DEG,
    distortion: float = DISTORTION,
    zoom: float = ZOOM,
    acceptance_angle_deg: float | None = None,
) -> Eye:
    """One eye of FlyGym's in the frame of its camera, an ommatidium for each hexagon of its map.

    Args:
        ommatidia_id_map: (H, W) whole numbers, which pixel of the bent picture is whose: 1 to N, 0
            nobody's.
        fovy_deg: vertical field of view of the camera.
        distortion, zoom: of the fisheye lens: a point r from the middle of the bent picture, in
            half sizes, is at r / zoom / (1 - distortion (r / zoom)²) in the camera's.
        acceptance_angle_deg: full width at half maximum. None: each ommatidium's mean angle to its
            neighbours.

    Raises:
        omma.Error: a map with numbers left out, or a number out of its range.
    """
    ids = array_of(ommatidia_id_map, "ommatidia_id_map", (None, None), np.int64)
    count = int(ids.max(initial=0))
    pixels = np.bincount(ids[ids > 0], minlength=count + 1)[1:]
    if count < 1 or ids.min() < 0 or not pixels.all():
        raise Error("ommatidia_id_map: expected each of 1 to N at least once, and 0 elsewhere")
    row, column = np.nonzero(ids)
    optics = {"fovy_deg": fovy_deg, "distortion": distortion, "zoom": zoom}
    direction = bent_directions(row.astype(float), column.astype(float), ids.shape, **optics)
    if np.isnan(direction).any():
        raise Error("distortion: expected one at which all of the map is before the lens")
    axis = np.stack(
        [np.bincount(ids[row, column] - 1, direction[:, k], count) for k in range(3)], -1
    )
    eye = Eye(np.zeros((count, 3)), axis, 0.0)
    if acceptance_angle_deg is None:
        return eye.replace(acceptance_angle_rad=eye.interommatidial_angle_rad())
    width = positive(acceptance_angle_deg, "acceptance_angle_deg")
    return eye.replace(acceptance_angle_rad=np.radians(width))


def camera_directions(
    row: Floats, column: Floats, shape: tuple[int, ...], *, fovy_deg: float = FOVY_DEG
) -> Floats:
    """Directions (..., 3) of points of the camera's picture of that shape; whole numbers are edges
    of pixels."""
    rows, columns = shape
    half = np.tan(np.radians(within(fovy_deg, "fovy_deg", 1, 179)) / 2)
    right, down = half * (2 * column - columns) / rows, half * (2 * row - rows) / rows
    direction = np.stack([right, -down, -np.ones_like(right)], -1)
    direction = normalized(direction)
    return direction


def bent_directions(
    row: Floats,
    column: Floats,
    shape: tuple[int, ...],
    *,
    fovy_deg: float = FOVY_DEG,
    distortion: float = DISTORTION,
    zoom: float = ZOOM,
) -> Floats:
    """Directions (..., 3) of pixels of the bent picture of that shape; NaN where none is before the
    lens."""
    rows, columns = shape
    scale = positive(zoom, "zoom")
    down = (2 * row - rows) / rows / scale
    right = (2 * column - columns) / columns / scale
    shrink = 1 - within(distortion, "distortion", 0, 1e6) * (down**2 + right**2)
    shrink = np.where(shrink > 0, shrink, np.nan)
    source_row, source_column = (1 + down / shrink) * rows / 2, (1 + right / shrink) * columns / 2
    return camera_directions(source_row, source_column, shape, fovy_deg=fovy_deg)


def flygym_retina(who: str) -> Any:
    """FlyGym's own, with its map and lens; omma.Error says who needs it."""
    return needs("flygym.vision.retina", "", f"{who} needs FlyGym 2").Retina()
