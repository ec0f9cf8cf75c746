"""What a Gaussian ommatidium answers, by quadrature over its angular sensitivity.

S(θ) = exp(-4 ln2 (θ/Δρ)²) with θ the true angle from the axis, so the measure is sinθ dθ dφ. Discs
are summed over rings around the axis, of which one knows what they cover; all else over directions.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache

import numpy as np

from omma.base.arrays import Floats
from omma.base.directions import tangents
from omma.base.spirals import GOLDEN_ANGLE_RAD

# Beyond this many acceptance angles S is under 1e-7.
_REACH = 2.4
# Over so many directions the mean of an edge through a field is within 5e-4, of a sine 1e-4.
_DIRECTIONS = 32_768
# Rings where what lies in each is known exactly.
_RINGS = 512


def field_directions(axis: Floats, acceptance_rad: float) -> Floats:
    """Directions (Q, 3) over the field of an ommatidium, each with the same share of a response.

    On a spiral by the golden angle, which has no rows along which an edge could run, at polar
    angles that share the sensitivity evenly.
    """
    theta, phi = _polar_angles(acceptance_rad), GOLDEN_ANGLE_RAD * np.arange(_DIRECTIONS)
    right, up = tangents(axis)
    across = np.cos(phi)[:, None] * right + np.sin(phi)[:, None] * up
    return np.asarray(np.cos(theta)[:, None] * axis + np.sin(theta)[:, None] * across)


@lru_cache(maxsize=64)
def _polar_angles(acceptance_rad: float) -> Floats:
    """Polar angles (Q,), rad, in order: the middles of equal shares of the sensitivity."""
    x = np.linspace(0, _farthest(acceptance_rad), 20_001)
    density = _density(x, acceptance_rad)
    below = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    share = (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS
    return np.asarray(acceptance_rad * np.interp(share, below / below[-1], x))


def gaussian_means(
    radiance: Callable[[Floats, float], Floats],
    axes: Floats,
    acceptance_rad: Floats,
    times_s: Floats,
) -> Floats:
    """Responses (T, N) to a radiance, a function of directions (Q, 3) and the time, s."""
    means = np.empty((len(times_s), len(axes)))
    for n, (axis, width) in enumerate(zip(axes, acceptance_rad, strict=True)):
        directions = field_directions(axis, float(width))
        for k, time_s in enumerate(times_s):
            means[k, n] = radiance(directions, time_s).mean()
    return means


def caps_share(axis: Floats, acceptance_rad: float, centres: Floats, radii_rad: Floats) -> float:
    """The share of an ommatidium's sensitivity that falls on any of some round caps of the sphere.

    Args:
        axis: (3,), of length 1.
        centres: (K, 3), directions to the middles of the caps.
        radii_rad: (K,), half their widths, under π/2 each.
    """
    reach = _REACH * acceptance_rad
    away = np.arccos(np.clip(centres @ axis, -1, 1))
    near = away < reach + radii_rad
    if not near.any():
        return 0.0
    away, radius, centre = away[near], radii_rad[near], centres[near]
    if acceptance_rad == 0:
        return float((away < radius).any())
    right, up = tangents(axis)
    azimuth = np.arctan2(centre @ up, centre @ right)
    if len(away) == 1:
        # The covered share of a ring as a function of θ has kinks where the cap begins and ends:
        # integrate between them.
        kinks = [abs(away[0] - radius[0]), away[0] + radius[0]]
        theta, share = _split_rings(acceptance_rad, kinks)
    else:
        theta, share = _ring_shares(acceptance_rad)
    # A cap covers of the ring at θ what is within ± half of its azimuth: the cosine rule.
    sines = np.sin(theta)[:, None] * np.sin(away)
    excess = np.cos(radius) - np.cos(theta)[:, None] * np.cos(away)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(sines > 0, excess / sines, np.where(excess > 0, np.inf, -np.inf))
    half = np.arccos(np.clip(cosine, -1, 1))
    return float((_union(azimuth - half, azimuth + half) * share).sum())


def _ring_shares(acceptance_rad: float) -> tuple[Floats, Floats]:
    """Polar angles of rings (R,), rad, and the share of each in a response; the shares sum to 1."""
    nodes, weights = _gauss(_RINGS)
    x = _farthest(acceptance_rad) * (nodes + 1) / 2
    share = weights * _density(x, acceptance_rad)
    return acceptance_rad * x, share / share.sum()


def _farthest(acceptance_rad: float) -> float:
    """How far sensitivity reaches, in acceptance angles."""
    return float(min(_REACH, np.pi / acceptance_rad)) if acceptance_rad > 0 else _REACH


def _density(x: Floats, acceptance_rad: float) -> Floats:
    """Sensitivity times sinθ at θ of x acceptance angles, up to a factor; also where Δρ is 0."""
    return np.asarray(np.exp(-4 * np.log(2) * x**2) * x * np.sinc(x * acceptance_rad / np.pi))


@cache
def _gauss(count: int) -> tuple[Floats, Floats]:
    """Nodes and weights of Gauss-Legendre from -1 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


def _split_rings(acceptance_rad: float, kinks: list[float]) -> tuple[Floats, Floats]:
    """As `_ring_shares`, with the same number of nodes in each section between kinks, where the
    covered share goes as a square root: nodes crowd towards both ends of a section."""
    end = min(_REACH * acceptance_rad, np.pi)
    bounds = sorted({0.0, end, *(min(kink, end) for kink in kinks)})
    nodes, weights = _gauss(_RINGS // 8)
    # x = sin²(π/2 s) from s in [0, 1].
    s, ds = (nodes + 1) / 2, weights / 2
    x, dx = np.sin(np.pi / 2 * s) ** 2, np.pi / 2 * np.sin(np.pi * s) * ds
    theta = np.concatenate([a + (b - a) * x for a, b in zip(bounds[:-1], bounds[1:])])
    width = np.concatenate([(b - a) * dx for a, b in zip(bounds[:-1], bounds[1:])])
    share = width * np.exp(-4 * np.log(2) * (theta / acceptance_rad) ** 2) * np.sin(theta)
    return theta, share / share.sum()


def _union(start: Floats, end: Floats) -> Floats:
    """The covered share of each ring, (R,), 0 to 1, by arcs (R, K), rad, that may overlap. Arcs lie
    between -3π/2 and 5π/2 and are taken modulo a turn."""
    turns = 2 * np.pi * np.array([-1.0, 0.0, 1.0])[:, None, None]
    starts = np.clip(np.concatenate(list(start + turns), axis=1), -np.pi, np.pi)
    ends = np.clip(np.concatenate(list(end + turns), axis=1), -np.pi, np.pi)
    order = np.argsort(starts, axis=1)
    starts = np.take_along_axis(starts, order, axis=1)
    ends = np.take_along_axis(ends, order, axis=1)
    # Where what came before has ended.
    before = np.maximum.accumulate(ends, axis=1)
    before = np.concatenate([np.full((len(ends), 1), -np.pi), before[:, :-1]], axis=1)
    added = np.maximum(ends - np.maximum(starts, before), 0)
    return np.asarray(added.sum(axis=1) / (2 * np.pi))
