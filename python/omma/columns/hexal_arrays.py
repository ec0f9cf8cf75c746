"""Hexals, the regular hexagonal lattice of flyvis-like models: where they look, and responses in
the shape [sample, frame, channel, hexal] that such models take."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, one_of, positive, within
from omma.base.srgb import srgb_of_linear
from omma.base.warn import warn_caller
from omma.columns.coordinates import Front, hexals, pq_from_uv, uv_from_pq
from omma.columns.lattice import Columns, expect_columns

# Share of light above white that is no longer that of some highlights.
_MUCH_WHITE = 0.05


@checked
def hexal_columns(
    radius: int,
    spacing_rad: float,
    towards: ArrayLike,
    *,
    side: int | Literal["left", "right"] = 1,
    front: Front = "right",
) -> Columns:
    """A regular lattice of columns in the order of hexals, that look in evenly spaced directions.

    Hexals are laid out around the middle by angle (azimuthal equidistant), so that rows through the
    middle are spaced evenly.

    Args:
        radius: steps from the middle to the border; 15 makes 721.
        spacing_rad: between neighbours.
        towards: (3,), where the middle looks, in the head's frame.
        side: of which eye: "left" or -1, "right" or 1.
        front: as of `uv_from_pq`.

    Example:
        >>> towards = omma.eye.direction(60.0, 0.0)
        >>> columns = omma.columns.hexal_columns(15, np.radians(5), towards)
        >>> len(columns)
        721

    Raises:
        omma.Error: an argument out of its range, or a lattice that would go around the sphere.
    """
    u, v = hexals(radius).T
    spacing = positive(spacing_rad, "spacing_rad")
    if radius * spacing > math.pi / 2:
        raise Error(
            f"spacing_rad: expected at most a quarter turn from the middle to the border, found "
            f"{math.degrees(radius * spacing):.0f}°"
        )
    sign = {"left": -1, "right": 1}.get(side, 0) if isinstance(side, str) else side
    if sign not in (-1, 1):
        raise Error(f"side: expected left (-1) or right (1), found {side!r:.40}")
    middle = array_of(towards, "towards", (3,))
    length = np.linalg.norm(middle)
    across = np.cross(middle, (0.0, 1.0, 0.0))
    if not np.isfinite(length) or length == 0 or np.linalg.norm(across) < 1e-6 * length:
        raise Error("towards: expected a direction that is not straight up or down")
    middle, right = middle / length, across / np.linalg.norm(across)
    # Seen by itself, the right eye has the front on its left.
    as_seen = (one_of(front, ("right", "left"), "front") == "right") == (sign == -1)
    x, y = spacing * math.sqrt(3) / 2 * v * (1 if as_seen else -1), -spacing * (u + v / 2)
    angle = np.hypot(x, y)
    step = np.outer(x, right) + np.outer(y, np.cross(right, middle))
    sine = np.sin(angle) / np.where(angle > 0, angle, 1)
    axis = np.cos(angle)[:, None] * middle + sine[:, None] * step
    p, q = pq_from_uv(u, v, front)
    return Columns(p, q, np.full(len(p), sign), axis)


@checked
def to_hexals(
    responses: ArrayLike,
    columns: Columns,
    radius: int = 15,
    *,
    middle: tuple[int, int] = (0, 0),
    front: Front = "right",
    fill: float | None = None,
) -> NDArray[np.float32]:
    """Responses of columns as flyvis-like models take them: [sample, frame, channel, hexal].

    Args:
        responses: (M, C), a frame; (T, M, C), frames; or (S, T, M, C), samples of frames: of the
            columns of one eye.
        radius: of the lattice of hexals, steps.
        middle: the column (p, q) that is the middle hexal.
        front: as of `uv_from_pq`.
        fill: what hexals without a column are given; None: they are an error.

    Returns:
        float32 (S, T, C, 1 + 3 radius (radius + 1)), contiguous; hexals in the order of `hexals`.

    Raises:
        omma.Error: a wrong shape, columns of two eyes, hexals without a column.
    """
    expect_columns(columns)
    given = array_of(responses, "responses", dtype=None)
    if given.ndim not in (2, 3, 4) or given.shape[-2] != len(columns):
        raise Error(
            f"responses: expected shape (M, C), (T, M, C) or (S, T, M, C) with M = "
            f"{len(columns)}, found {given.shape}"
        )
    if len(np.unique(columns.side)) > 1:
        raise Error("columns: expected those of one eye, found those of two")
    whole_lattice = hexals(radius)
    start = array_of(middle, "middle", (2,), np.int64)
    u, v = uv_from_pq(columns.p - start[0], columns.q - start[1], front)
    row_of = {hexal: k for k, hexal in enumerate(zip(u.tolist(), v.tolist(), strict=True))}
    row = np.array([row_of.get((u, v), -1) for u, v in whole_lattice.tolist()])
    missing = np.flatnonzero(row < 0)
    if len(missing) and fill is None:
        first = whole_lattice[missing[0]]
        p, q = pq_from_uv(first[0], first[1], front)
        raise Error(
            f"columns: {len(missing)} of {len(row)} hexals have none, the first p = "
            f"{p + start[0]}, q = {q + start[1]}; expected all, or a value to fill in (fill=)"
        )
    given = given.reshape((1,) * (4 - given.ndim) + given.shape)
    found = np.ascontiguousarray(given[:, :, row].swapaxes(2, 3), np.float32)
    if len(missing):
        found[..., missing] = fill
    return found


@checked
def flyvis_movie(
    light: ArrayLike,
    columns: Columns,
    *,
    white: float = 1.0,
    radius: int = 15,
    middle: tuple[int, int] = (0, 0),
    front: Front = "right",
    fill: float | None = None,
) -> NDArray[np.float32]:
    """Light of columns as flyvis' networks take it: grey levels 0 to 1 of hexals, as of a picture.

    Flyvis was trained on the grey levels of 8-bit pictures over 255 (its Sintel data set), thus on
    values behind the curve of sRGB; so linear light over ``white`` is clipped to 0 to 1 and goes
    through that curve (IEC 61966-2-1).

    Args:
        light: (T, M) frames, or (S, T, M) samples of frames: linear light of the columns of one
            eye, as r1_6 of a `PhotoreceptorTable`.
        white: the light that is white, 1: brighter light is white too. As a scene has it, or the
            brightest that is to be told apart, np.nanmax(light).
        radius, middle, front: as of `to_hexals`.
        fill: grey level, 0 to 1, of hexals without a column, and where light is NaN; None: they
            are an error.

    Returns:
        float32 (S, T, 1, 1 + 3 radius (radius + 1)), contiguous, for ``Network.simulate``.

    Example:
        >>> columns = omma.columns.hexal_columns(15, 0.08, (1, 0, 0))
        >>> movie = omma.columns.flyvis_movie(np.full((4, 721), 0.2140), columns)
        >>> movie.shape, float(movie[0, 0, 0, 0].round(3))
        ((1, 4, 1, 721), 0.5)

    Raises:
        omma.Error: as of `to_hexals`, a white or fill out of its range, light that is NaN without
            fill, or all of it.

    Warns:
        UserWarning: more than a twentieth of the light is above white.
    """
    expect_columns(columns)
    given = array_of(light, "light")
    if given.ndim not in (2, 3) or given.shape[-1] != len(columns):
        raise Error(
            f"light: expected shape (T, M) or (S, T, M) with M = {len(columns)}, found "
            f"{given.shape}"
        )
    shade = None if fill is None else within(fill, "fill", 0, 1)
    if given.size and np.all(np.isnan(given)):
        raise Error("light: expected numbers, found NaN in all frames and columns")
    relative = given / positive(white, "white")
    above = np.mean(relative > 1) if relative.size else 0.0
    if above > _MUCH_WHITE:
        warn_caller(
            f"white: {100 * above:.0f} % of the light is above {white:g} and becomes white, the "
            f"brightest is {np.nanmax(given):g}",
            UserWarning,
        )
    relative = np.clip(relative, 0, 1)
    made = to_hexals(
        srgb_of_linear(relative)[..., None], columns, radius, middle=middle, front=front, fill=shade
    )
    unknown = np.isnan(made)
    if unknown.any():
        if shade is None:
            raise Error("light: expected numbers, found NaN, or a grey level to fill in (fill=)")
        made[unknown] = shade
    return made
