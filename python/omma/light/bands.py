"""Bands of wavelengths: what red, green and blue stand for, and the matrix that lifts them."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error
from omma.base.arguments import array_of, checked

Floats = NDArray[np.float64]


@checked
def primary_spectra(wavelength_nm: ArrayLike) -> Any:
    """Spectra that stand for linear sRGB's red, green and blue: (..., 3) for wavelengths (...), nm.

    Smooth shares of white's photons, at least 0, that add up to 1 from 400 to 700 nm and are 0
    elsewhere; each has, under D65, the chromaticity of its primary (docs/receptors.md; after
    Mallett and Yuksel, EGSR 2019).
    """
    nm = array_of(wavelength_nm, "wavelength_nm")
    return _core.primary_spectra(np.ascontiguousarray(nm.ravel())).reshape(*nm.shape, 3)


def band_edges(edges_nm: ArrayLike) -> Floats:
    """``edges_nm`` as (B + 1,), where they are edges of bands."""
    edges = array_of(edges_nm, "edges_nm", (None,))
    if not 2 <= len(edges) <= _core.most_bands + 1 or not np.all(np.diff(edges) > 0):
        raise Error(
            f"edges_nm: expected 2 to {_core.most_bands + 1} wavelengths that ascend, found "
            f"{edges.tolist()!s:.80}"
        )
    return edges


def band_means(edges: Floats, spectra: Callable[[Floats], Floats]) -> Floats:
    """Means over each band of spectra that change over nanometres: (B, ...)."""
    means = []
    for low, high in itertools.pairwise(edges):
        steps = max(4, int(np.ceil((high - low) / 0.25)))
        nm = low + (np.arange(steps) + 0.5) * (high - low) / steps
        means.append(spectra(nm).mean(axis=0))
    return np.array(means)


@checked
def band_from_rgb(edges_nm: ArrayLike) -> Floats:
    """What linear sRGB is in bands of light: (B, 3), for `World`.

    Red, green and blue stand for their `primary_spectra`; a band's radiance is the mean over its
    wavelengths. So white is 1 in every band from 400 to 700 nm, and all is dark outside.

    Args:
        edges_nm: (B + 1,), ascending, nm: band b is from edges_nm[b] to edges_nm[b + 1].

    Example:
        >>> omma.light.band_from_rgb([300, 400, 500, 600, 700]).shape
        (4, 3)

    Raises:
        omma.Error: edges that do not ascend, fewer than 2 or more than 129.
    """
    return band_means(band_edges(edges_nm), primary_spectra)
