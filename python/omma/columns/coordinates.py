"""How columns are numbered: (p, q) as FlyWire has it, (hex1, hex2) as MaleCNS does, (u, v) of the
hexals of flyvis-like models; and the ways from one to another (sources:
docs/motion-detection.md).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, one_of, whole
from omma.base.arrays import Ints

Front = Literal["right", "left"]

# Of MaleCNS: the column (hex1, hex2) that has p = 0 and q = 0.
ORIGIN = (18, 19)
_LARGEST_RADIUS = 1000


@checked
def pq_from_hex(hex1: ArrayLike, hex2: ArrayLike) -> tuple[Ints, Ints]:
    """(p, q) of columns of MaleCNS: p = hex2 - 19, q = hex1 - 18.

    Args:
        hex1, hex2: (M,), as neuPrint names them (hex1_id, hex2_id).

    Example:
        >>> p, q = omma.columns.pq_from_hex([18, 20], [19, 19])
        >>> p.tolist(), q.tolist()
        ([0, 0], [0, 2])

    Raises:
        omma.Error: they are no whole numbers, or not as many of both.
    """
    first, second = _pair(hex1, hex2, "hex1", "hex2")
    return second - ORIGIN[1], first - ORIGIN[0]


@checked
def hex_from_pq(p: ArrayLike, q: ArrayLike) -> tuple[Ints, Ints]:
    """(hex1, hex2) of MaleCNS of columns (p, q): the way back from `pq_from_hex`.

    Raises:
        omma.Error: they are no whole numbers, or not as many of both.
    """
    p_, q_ = _pair(p, q, "p", "q")
    return q_ + ORIGIN[0], p_ + ORIGIN[1]


@checked
def uv_from_pq(p: ArrayLike, q: ArrayLike, front: Front = "right") -> tuple[Ints, Ints]:
    """Axial coordinates (u, v) of hexals, of columns (p, q).

    In flyvis' pictures u points down and v to the right and down, so that the dorsal direction,
    p + q, is -u. With the front on the right, q (dorsal and to the front) points to the right and
    up: u = -q, v = q - p. With the front on the left u = -p, v = p - q.

    Args:
        front: where the front of the eye lies in the picture. The preferred directions of flyvis'
            T4a (front to back) point to the left: the front is on the right.

    Example:
        >>> u, v = omma.columns.uv_from_pq([1], [1])  # one step dorsal
        >>> u.tolist(), v.tolist()
        ([-1], [0])

    Raises:
        omma.Error: they are no whole numbers, not as many of both, or another word for ``front``.
    """
    p_, q_ = _pair(p, q, "p", "q")
    if one_of(front, ("right", "left"), "front") == "left":
        p_, q_ = q_, p_
    return -q_, q_ - p_


@checked
def pq_from_uv(u: ArrayLike, v: ArrayLike, front: Front = "right") -> tuple[Ints, Ints]:
    """Columns (p, q) of hexals (u, v): the way back from `uv_from_pq`.

    Raises:
        omma.Error: they are no whole numbers, not as many of both, or another word for ``front``.
    """
    u_, v_ = _pair(u, v, "u", "v")
    q, p = -u_, -u_ - v_
    return (p, q) if one_of(front, ("right", "left"), "front") == "right" else (q, p)


@checked
def hexals(radius: int) -> Ints:
    """All hexals within so many steps of the middle, in the order of flyvis: by u, then by v.

    Returns:
        (1 + 3 radius (radius + 1), 2): u and v.

    Example:
        >>> len(omma.columns.hexals(15))
        721

    Raises:
        omma.Error: a radius below 0 or above 1000.
    """
    most = whole(radius, "radius", 0, _LARGEST_RADIUS)
    u, v = np.meshgrid(np.arange(-most, most + 1), np.arange(-most, most + 1), indexing="ij")
    inside = np.abs(u + v) <= most
    return np.stack([u[inside], v[inside]], axis=1).astype(np.int64)


def _pair(one: ArrayLike, other: ArrayLike, name: str, second: str) -> tuple[Ints, Ints]:
    found = array_of(one, name, dtype=np.int64), array_of(other, second, dtype=np.int64)
    if found[0].shape != found[1].shape:
        raise Error(
            f"{name}, {second}: expected as many of both, found {found[0].shape} and "
            f"{found[1].shape}"
        )
    return found
