"""Poses on the ground: where a body stands, by the ground under its legs, and along a track."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Scene
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.base.poses import Matrices, as_poses, warn_of_radians
from omma.base.values import value_class
from omma.base.warn import warn_caller
from omma.motion.footing import Below, bounds_of, rounding_m, standing
from omma.motion.ground_rays import first_below, names_of_ground, ray_bundle, shoot, upright
from omma.motion.tracks import Track, heading_along
from omma.rendering.pose_warnings import warn_of_poses
from omma.rendering.renderer import Renderer
from omma.scene.world import World

# What a body stands on, by default, in heights of its head: length and width.
_STANCE = (3.0, 2.0)
_MOST_NAMED = 5  # points that a message lists


@checked
def place_on(
    ground: World | Scene,
    xz_m: ArrayLike,
    *,
    height_m: float,
    heading_deg: ArrayLike = 0.0,
    legs_m: ArrayLike | None = None,
    from_m: float | None = None,
    on: str | Sequence[str] = (),
) -> Matrices:
    """Poses of heads on the ground: (P, 4, 4), ``world_from_head``, m.

    At each point a body stands on the highest surface: its pitch and roll are those of the plane
    through the ground under its legs (least squares), its yaw is the heading, and the head is
    ``height_m`` above, along the plane's normal. Where the ground in the middle is higher than
    that plane, the head is above the ground. Rays go straight down to find all that, with things
    of a world where they are now; surfaces that face down and are single-sided are no ground. Among
    Gaussian splats the ground is where half of a ray's light is reached.

    A leg reaches up and down, from the ground in the middle, by twice the distance of the farthest
    leg from it; one that finds no ground there, as over an edge, is left out. With fewer than three
    legs on the ground, or all in a line, the body stands by the normal of the ground in the middle,
    upright on splats, which have none.
    A hole that more than half of the legs stand around is bridged.

    Args:
        ground: a world, or a scene, of which a world is made: for many calls make it once.
        xz_m: (P, 2) or (2,), m, where: the world's x and z, as +Y is up.
        height_m: of the head above the ground.
        heading_deg: (P,) or one for all, yaw: 0 looks along -Z, 90 along +X.
        legs_m: where legs touch the ground, from below the head: (L, 2), m, to the right and
            ahead, three or more; or (2,), length and width of a rectangle for six, at its corners
            and the middles of its long sides. None: 3 ``height_m`` long and 2 wide.
        from_m: the y below which ground is looked for, as under trees and roofs. None: from above
            everything.
        on: names of instances that are ground, or that of one; all else is looked through. ():
            everything is.

    Example:
        >>> floor = omma.scene.plane((2, 2))
        >>> pose = omma.motion.place_on(floor, (0.3, -0.2), height_m=0.003, heading_deg=90)
        >>> pose[0, :3, 3].round(6).tolist()
        [0.3, 0.003, -0.2]

    Raises:
        omma.Error: there is no ground below some points, which it names; a wrong shape, a number
            that is not finite, no instance of such a name.

    Warns:
        UserWarning: how many legs found no ground, and at how many points fewer than three did;
            headings that look like radians.
    """
    points = _points(xz_m)
    heading = array_of(heading_deg, "heading_deg")
    if heading.shape not in ((), (len(points),)) or not np.isfinite(heading).all():
        raise Error(
            f"heading_deg: expected one finite number or {len(points)}, found {heading!r:.60}"
        )
    warn_of_radians(heading.reshape(-1, 1), "heading_deg")
    return _placed(ground, points, heading, height_m, _Stance(legs_m, from_m, on))


class _Stance(NamedTuple):
    """As arguments of `place_on`."""

    legs_m: ArrayLike | None
    from_m: float | None
    on: str | Sequence[str]


def _placed(
    ground: World | Scene, points: Floats, heading_deg: Floats, height_m: float, stance: _Stance
) -> Matrices:
    """What `place_on` gives at points (P, 2), for one heading or (P,)."""
    height = positive(height_m, "height_m")
    legs = _legs(stance.legs_m, height)
    world = ground if isinstance(ground, World) else World(ground)
    yaw = np.broadcast_to(np.radians(heading_deg), len(points))
    on = names_of_ground(world, stance.on)
    if len(points) == 0:
        return np.empty((0, 4, 4))
    below = Below(world, np.concatenate([[(0.0, 0.0)], legs]), stance.from_m, on)
    foot, normal, is_found = standing(below, points, yaw)
    _tell(world, points, np.isfinite(foot), is_found)
    return _poses(points, foot, normal, yaw, height)


@checked
def walk_on(
    ground: World | Scene,
    track: Track | ArrayLike,
    *,
    height_m: float,
    legs_m: ArrayLike | None = None,
    from_m: float | None = None,
    on: str | Sequence[str] = (),
) -> Matrices:
    """Poses of a head that walks along a track over the ground: (P, 4, 4), m.

    Each is that of `place_on`. Headings are the track's own; without, along it, by the chord of as
    much of the track as the legs are apart, so that corners are turned smoothly.

    Args:
        track: a `Track`, as `load_track` reads it, or (P, 2), m, the world's x and z.
        ground, height_m, legs_m, from_m, on: as of `place_on`.

    Example:
        >>> track = omma.motion.Track([(0, 0), (0, -1)]).at_speed(0.1, step_s=0.5)
        >>> poses = omma.motion.walk_on(omma.scene.plane((4, 4)), track, height_m=0.003)
        >>> poses.shape
        (21, 4, 4)

    Raises:
        omma.Error: what `place_on` raises; a track that goes nowhere, without headings.

    Warns:
        UserWarning: as `place_on`.
    """
    given = track if isinstance(track, Track) else Track(array_of(track, "track"))
    heading = given.heading_deg
    if heading is None:
        ahead = _legs(legs_m, positive(height_m, "height_m"))[:, 1]
        heading = heading_along(given.xz_m, float(np.ptp(ahead)))
    return _placed(ground, given.xz_m, heading, height_m, _Stance(legs_m, from_m, on))


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class GroundAt:
    """What heads have under and ahead of them, as `ground_at` found it."""

    height_m: Floats
    """(P,), of the head above the ground straight below it."""
    slope_deg: Floats
    """(P,), of that ground: 0 is level, 90 a wall; NaN on Gaussian splats without ``splat_span_m``:
    they have no normals."""
    climb_deg: Floats
    """(P,), of that ground along the heading: above 0 uphill; NaN where the slope is."""
    ahead_m: Floats
    """(P,), from the head to the first surface straight ahead of it, where the head looks;
    infinite where nothing is."""


@checked
def ground_at(
    ground: World | Scene,
    poses: ArrayLike | tuple[ArrayLike, ArrayLike],
    *,
    on: str | Sequence[str] = (),
    splat_span_m: float | None = None,
) -> GroundAt:
    """The slope of the ground below heads, and how far it is to what is ahead.

    By one ray straight down and one straight ahead, from each head.

    Args:
        ground: a world, or a scene, of which a world is made.
        poses: (P, 4, 4), or (positions (P, 3), quaternions (P, 4)).
        on: names of instances that are ground, as of `place_on`. Ahead of heads everything counts.
        splat_span_m: Gaussian splats have no normals; their slope is that between two points so far
            apart along x and two along z, around the one below the head. None: it is NaN.

    Example:
        >>> room = omma.scene.merge_scenes([omma.scene.plane((9, 9)), omma.scene.box((1, 1, 1))])
        >>> there = omma.motion.ground_at(room, omma.look_at((0, 0.2, 2), (0, 0.2, 0)))
        >>> there.height_m.round(3).tolist(), there.ahead_m.round(3).tolist()
        ([0.2], [1.5])

    Raises:
        omma.Error: there is no ground below some heads, which it names; poses that are none, no
            instance of such a name.

    Warns:
        RuntimeWarning, UserWarning: what `Renderer.render` tells of odd poses.
    """
    heads = as_poses(poses)
    span = None if splat_span_m is None else positive(splat_span_m, "splat_span_m")
    world = ground if isinstance(ground, World) else World(ground)
    on = names_of_ground(world, on)
    if len(heads) == 0:
        return GroundAt(*np.empty((4, 0)))
    start = heads[:, :3, 3]
    down, step = ray_bundle(world, [[0, -1, 0]]), rounding_m(world, start)
    met, normal = first_below(down, start, step, on)
    of_splats = ~normal.any(axis=1)  # they have none
    normal[of_splats] = np.nan
    if span is not None and of_splats.any():
        normal[of_splats] = _across(down, start[of_splats], span, step[of_splats], on)
    height = start[:, 1] - met
    without_legs = np.ones((len(heads), 0), np.bool_)
    _tell(world, start[:, [0, 2]], np.isfinite(height), without_legs)
    forward = -heads[:, :3, 2]
    ahead = ray_bundle(world, [[0, 0, -1]])
    warn_of_poses(ahead._engine, heads)
    level = np.hypot(forward[:, 0], forward[:, 2])
    rise = -(normal[:, [0, 2]] * forward[:, [0, 2]]).sum(axis=1)
    return GroundAt(
        height,
        np.degrees(np.arctan2(np.hypot(normal[:, 0], normal[:, 2]), normal[:, 1])),
        np.degrees(np.arctan2(rise, normal[:, 1] * level)),
        shoot(ahead, heads).distance_m[:, 0],
    )


def _across(
    down: Renderer, start_m: Floats, span_m: float, step_m: Floats, on: Sequence[str]
) -> Floats:
    """Normals (P, 3) of the ground below (P, 3), m, by its heights around; NaN where some of these
    lie over no ground."""
    aside = span_m / 2 * np.array([(1.0, 0, 0), (-1, 0, 0), (0, 0, 1), (0, 0, -1)])
    around = (start_m[:, None] + aside).reshape(-1, 3)
    height = first_below(down, around, np.repeat(step_m, 4), on)[0].reshape(-1, 4)
    rise = (height[:, [0, 2]] - height[:, [1, 3]]) / span_m
    normal = np.column_stack([-rise[:, 0], np.ones(len(rise)), -rise[:, 1]])
    return normalized(normal)


def _where(world: World, points: Floats) -> str:
    """Where a world lies of which points (P, 2) find no ground, and what may be wrong with them."""
    bounds = bounds_of(world)
    if bounds is None:
        return "the scene has no surfaces"
    low, high = bounds[:, [0, 2]]
    (x, z), (to_x, to_z) = low, high
    place = f"the scene lies at x {x:.10g} to {to_x:.10g}, z {z:.10g} to {to_z:.10g}"
    turned = points * [1, -1]
    if not ((points >= low) & (points <= high)).all(axis=1).any():
        if ((turned >= low) & (turned <= high)).all():
            place += ", where these are with z of the other sign: z is the northing's negative"
        return place
    return f"{place}; single-sided surfaces that face down are not seen from above"


def _poses(points: Floats, foot: Floats, normal: Floats, yaw: Floats, height_m: float) -> Matrices:
    up = normalized(normal)
    forward = np.column_stack([np.sin(yaw), np.zeros(len(yaw)), -np.cos(yaw)])
    forward[:, 1] = -(up * forward).sum(axis=1) / up[:, 1]  # along the plane, by the same azimuth
    forward = normalized(forward)
    poses = upright(np.column_stack([points[:, 0], foot, points[:, 1]]) + height_m * up)
    poses[:, :3, 0], poses[:, :3, 1], poses[:, :3, 2] = np.cross(forward, up), up, -forward
    return poses


def _points(xz_m: ArrayLike) -> Floats:
    given = array_of(xz_m, "xz_m")
    points = given[None] if given.ndim == 1 else given
    if points.ndim != 2 or points.shape[1] != 2:
        raise Error(f"xz_m: expected shape (P, 2) or (2,), found {given.shape}")
    if not np.isfinite(points).all():
        bad = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise Error(f"xz_m: expected finite numbers, found {points[bad].tolist()} in row {bad}")
    return points


def _legs(legs_m: ArrayLike | None, height_m: float) -> Floats:
    """(L, 2), m, to the right and ahead."""
    given = height_m * np.array(_STANCE) if legs_m is None else array_of(legs_m, "legs_m")
    if not np.isfinite(given).all():
        raise Error(f"legs_m: expected finite numbers, found {given.tolist()}")
    if given.shape == (2,):
        if not (given > 0).all():
            raise Error(f"legs_m: expected a length and a width above 0, found {given.tolist()}")
        ahead, right = given / 2
        return np.array([(s * right, a) for s in (-1, 1) for a in (ahead, 0.0, -ahead)])
    if given.ndim != 2 or given.shape[1] != 2 or len(given) < 3:
        raise Error(
            "legs_m: expected (length, width), or (L, 2), to the right and ahead, with three legs "
            f"or more, found shape {given.shape}"
        )
    apart = given - given.mean(axis=0)
    if np.linalg.matrix_rank(apart, 1e-3 * np.abs(apart).max()) < 2:
        raise Error("legs_m: expected legs that are not all in a line")
    return given


def _tell(
    world: World, points: Floats, is_there: NDArray[np.bool_], legs: NDArray[np.bool_]
) -> None:
    """omma.Error where points (P, 2) have no ground, a warning where legs (P, L) have none."""
    missing = np.flatnonzero(~is_there)
    if len(missing):
        named = ", ".join(
            f"{k} (x {points[k, 0]:.10g}, z {points[k, 1]:.10g})" for k in missing[:_MOST_NAMED]
        )
        more = "" if len(missing) <= _MOST_NAMED else f" and {len(missing) - _MOST_NAMED} more"
        raise Error(
            f"no ground below {len(missing)} of {len(points)} points: {named}{more}; "
            f"{_where(world, points[missing])}"
        )
    without = int((~legs).sum())
    if without:
        few, some = int((legs.sum(axis=1) < 3).sum()), int((~legs).any(axis=1).sum())
        warn_caller(
            f"{without} of {legs.size} legs reach no ground, at {some} of {len(points)} points, "
            f"and were left out; at {few} fewer than three do, where bodies stand by the normal of "
            "the ground in the middle",
            UserWarning,
        )
