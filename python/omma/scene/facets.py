"""What the boundary of a dielectric mirrors: level, or of facets whose slopes follow GGX, as Omma
renders it (src/physics/surface/specular_albedo.h)."""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats


def mirrored_straight(roughness: float, n: float) -> float:
    """The share that facets of a roughness, as in glTF, mirror of light that falls straight on
    the surface: 0.58 of a level surface's at a roughness of 0.8 and n = 1.4."""
    return float(mirrored(np.ones(1), roughness**2, n)[0])


def surface_albedo(alpha: float, n: float) -> float:
    """The share of uniform light that a surface of GGX facets mirrors, each facet once."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    # The cosine as a square, as the share changes fast at grazing angles: 2 c dc = 4 x³ dx.
    x = (nodes + 1) / 2
    shares = fresnel(x**2, n) if alpha == 0 else mirrored(x**2, alpha, n)
    return float(weights / 2 @ (4 * x**3 * shares))


def fresnel(cosine: Floats, n: float) -> Floats:
    """The share that a smooth surface mirrors of unpolarised light."""
    inside = np.sqrt(n**2 - 1 + cosine**2)
    across = (cosine - inside) / (cosine + inside)
    along = (n**2 * cosine - inside) / (n**2 * cosine + inside)
    return np.asarray((across**2 + along**2) / 2)


def mirrored(cosine: Floats, alpha: float, n: float, steps: int = 64) -> Floats:
    """The share that GGX facets mirror of light at each cosine (K,): the mean over the facets that
    it meets (spherical caps: Dupuy and Benyoub 2023), of Fresnel's share times how much of what
    each mirrors gets away (G2 / G1: Heitz 2014)."""
    middles = (np.arange(steps) + 0.5) / steps
    c = cosine[:, None, None]
    stretched = np.sqrt(alpha**2 * (1 - c**2) + c**2)
    up = c / stretched
    z = (1 - middles[:, None]) * (1 + up) - up
    about = np.cos(2 * np.pi * middles) * np.sqrt(np.maximum(1 - z**2, 0))
    sideways = np.sin(2 * np.pi * middles) * np.sqrt(np.maximum(1 - z**2, 0))
    normal = np.stack(
        np.broadcast_arrays(
            alpha * (about + alpha * np.sqrt(1 - c**2) / stretched), alpha * sideways, z + up
        )
    )
    normal /= np.linalg.norm(normal, axis=0)
    on_facet = np.sqrt(1 - c**2) * normal[0] + c * normal[2]
    away = np.maximum(2 * on_facet * normal[2] - c, 0)
    root, root_away = (np.sqrt(alpha**2 + (1 - alpha**2) * one**2) for one in (c, away))
    escaping = away * (c + root) / (away * root + c * root_away)
    return np.asarray((fresnel(on_facet, n) * escaping).mean(axis=(1, 2)))
