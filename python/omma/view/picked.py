"""One ommatidium: its numbers, where its rays go and what they meet, its acceptance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omma._core import Acceptance, Background, Error, Eye, Scene
from omma.base.arguments import whole
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed
from omma.scene.world import World
from omma.view.state import Look, Looker

# Of the picture from which a ray's direction is read: finer than any acceptance angle.
_ROWS = 512
# So narrow that it is one ray.
_NARROW_RAD = 1e-6


@dataclass(frozen=True)
class Rays:
    """Rays of an ommatidium in the world. start_m, direction: (S, 3); distance_m: (S,), to what
    they meet first, infinite where that is nothing; radiance: (S, C)."""

    start_m: Floats
    direction: Floats
    distance_m: Floats
    radiance: NDArray[np.float32]


def check_ommatidium(eye: Eye, number: int) -> int:
    """The number, where there is such an ommatidium."""
    return whole(number, "ommatidium", 0, len(eye) - 1)


def rays_of(looker: Looker, look: Look, ommatidium: int, samples: int) -> Rays:
    """The very rays that an ommatidium's response is the mean of.

    Their directions are read off: in an empty world before a picture whose colours are directions
    each ray brings its own. What they meet in the real world, and how far away, one ray of the same
    start and direction tells.
    """
    renderer = looker.renderer(look, samples)
    eye = renderer.eye
    check_ommatidium(eye, ommatidium)
    if eye.aperture_diameter_m[ommatidium] > 0:
        raise Error("rays: those of a wide aperture start all over it, and are not drawn")
    pose = look.pose.world_from_head
    # The direction in the head's frame is what an empty world shows a head that is not turned.
    empty = World(Scene(), background=_directions_as_colours(), threads=1)
    options = {**looker.options, "footprints": False}
    there = Renderer(empty, eye, Fixed(samples), threads=looker.threads, **options)  # type: ignore[arg-type]
    seen = there.render_rays(np.eye(4))[0, ommatidium].astype(np.float64)
    ahead = 2 * seen - 1
    ahead = normalized(ahead)
    offset = float(eye.focal_offset_m[ommatidium])
    start = eye.position_m[ommatidium] - offset * eye.axis[ommatidium]
    single = Eye(np.tile(start, (samples, 1)), ahead, _NARROW_RAD)
    met = Renderer(looker.world, single, Fixed(1), threads=looker.threads).ground_truth(pose)
    turn = pose[:3, :3]
    starts = np.tile(turn @ start + pose[:3, 3], (samples, 1))
    radiance = renderer.render_rays(pose)[0, ommatidium]
    return Rays(starts, ahead @ turn.T, met.distance_m[0].astype(np.float64), radiance)


def ommatidium_towards(eye: Eye, direction: Floats) -> int:
    """Whose axis is nearest to a direction (3,) in the head's frame."""
    return int(np.argmax(eye.axis.astype(np.float64) @ (direction / np.linalg.norm(direction))))


def ommatidium_looking_at(
    looker: Looker, look: Look, start_m: Floats, direction: Floats, head_radius_m: float
) -> int | None:
    """Which ommatidium a click on the page means: the one drawn on the head where the ray of the
    click meets it, else the one that looks at what the ray meets; None of the sky."""
    pose = look.pose.world_from_head
    ahead = direction / np.linalg.norm(direction)
    to_head = pose[:3, 3] - start_m
    along = float(to_head @ ahead)
    aside = float(np.linalg.norm(to_head - along * ahead))
    if along > 0 and aside < head_radius_m < np.linalg.norm(to_head):
        on_head = ahead * (along - np.sqrt(head_radius_m**2 - aside**2)) - to_head
        return ommatidium_towards(looker.eye, on_head @ pose[:3, :3])
    one = Eye(np.zeros((1, 3)), [[0.0, 0.0, -1.0]], _NARROW_RAD)
    there = Renderer(looker.world, one, Fixed(1), threads=looker.threads)
    # Turned so that it looks along the ray; any turn about the ray will do.
    aside_axis = np.cross(ahead, [0.0, 1.0, 0.0] if abs(ahead[1]) < 0.9 else [1.0, 0.0, 0.0])
    aside_axis /= np.linalg.norm(aside_axis)
    camera = np.eye(4)
    camera[:3, :3] = np.stack([aside_axis, np.cross(aside_axis, ahead), -ahead], axis=1)
    camera[:3, 3] = start_m
    distance = float(there.ground_truth(camera).distance_m[0, 0])
    if not np.isfinite(distance):
        return None
    towards = start_m + distance * ahead - pose[:3, 3]
    return ommatidium_towards(looker.eye, towards @ pose[:3, :3])


def cone_of(eye: Eye, ommatidium: int, count: int = 32) -> Floats:
    """Directions (count, 3), in the head's frame, in which it is half as sensitive as at best."""
    acceptance = eye.acceptance(ommatidium)
    axis, up = (np.asarray(each[ommatidium], np.float64) for each in (eye.axis, eye.up))
    right = np.cross(axis, up)
    azimuth = np.linspace(0, 2 * np.pi, count, endpoint=False)
    half = np.array([acceptance.width_rad(float(each)) / 2 for each in azimuth])
    aside = np.cos(azimuth)[:, None] * up + np.sin(azimuth)[:, None] * right
    return np.asarray(np.cos(half)[:, None] * axis + np.sin(half)[:, None] * aside)


def profile_of(acceptance: Acceptance) -> tuple[Floats, Floats]:
    """Angles from the axis, rad, towards up (below 0: down), and relative sensitivities."""
    reach = 1.6 * max(acceptance.width_rad(0.0), acceptance.width_rad(np.pi / 2))
    theta = np.linspace(0, min(reach, np.pi), 81)
    if acceptance.kernel == "compoundray":
        theta = theta[1:]  # it is infinite at the axis
    up = np.asarray(acceptance.eval(theta, 0.0), np.float64)
    down = np.asarray(acceptance.eval(theta, np.pi), np.float64)
    angle = np.concatenate([-theta[::-1], theta])
    values = np.concatenate([down[::-1], up])
    return angle, values / values.max()


def angles_deg(direction: Floats) -> tuple[float, float]:
    """Azimuth, to the right, and elevation, deg, of a direction (3,)."""
    x, y, z = direction / np.linalg.norm(direction)
    return float(np.degrees(np.arctan2(x, -z))), float(np.degrees(np.arcsin(np.clip(y, -1, 1))))


def _directions_as_colours() -> Background:
    """A panorama whose red, green and blue are (x + 1) / 2, (y + 1) / 2, (z + 1) / 2."""
    elevation = np.pi * (0.5 - (np.arange(_ROWS) + 0.5) / _ROWS)[:, None]
    azimuth = 2 * np.pi * ((np.arange(2 * _ROWS) + 0.5) / (2 * _ROWS) - 0.5)[None]
    across = np.cos(elevation)
    x, z = np.sin(azimuth) * across, -np.cos(azimuth) * across
    y = np.broadcast_to(np.sin(elevation), x.shape)
    colours = np.stack([x, y, z], axis=2) / 2 + 0.5
    return Background.image(colours.astype(np.float32))
