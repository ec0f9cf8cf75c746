"""Bands of wavelengths: which there are, what red, green and blue stand for, and the matrix that
lifts them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma import _core
from omma._core import Error
from omma.base.arguments import array_of, checked, whole
from omma.base.arrays import Floats
from omma.base.values import value_class

# Between samples inside of a band: spectra of pigments, leaves and skies change little over it.
_STEP_NM = 1.0
# As of `Spectrum`; beyond it nothing here knows light, and bands would take memory without end.
_SHORTEST_NM, _LONGEST_NM = 100.0, 5000.0


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
    _check_range(edges, "edges_nm")
    return edges


def _check_range(ascending_nm: Floats, name: str) -> None:
    if not (ascending_nm[0] >= _SHORTEST_NM and ascending_nm[-1] <= _LONGEST_NM):
        raise Error(
            f"{name}: expected {_SHORTEST_NM:g} to {_LONGEST_NM:g} nm, found "
            f"{ascending_nm[0]:g} to {ascending_nm[-1]:g}"
        )


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


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Bands:
    """Bands of wavelengths that light is in: each a weighted mean over wavelengths.

    Made by `Bands.equal` (by default 16 of 25 nm from 300 to 700 nm), `Bands.from_edges` or
    `Bands.from_sensitivities`; or from weights of one's own.

    wavelength_nm: (K,), ascending.
    weight: (B, K), at least 0; what a band's row adds up to is made 1.
    edges_nm: (B + 1,) where the bands lie side by side; else None.
    cell_nm: (K,), how much there is about each wavelength that its weight stands for: spectra that
        are straight between their values count by their exact means over it. None: with edges, an
        equal share of its band; without, the wavelengths alone.

    Raises:
        omma.Error: wavelengths that do not ascend or are not within 100 to 5000 nm, weights that
            are negative, not finite or all 0, more than 128 bands.
    """

    wavelength_nm: Floats
    weight: Floats
    edges_nm: Floats | None = None
    cell_nm: Floats | None = None

    def __post_init__(self) -> None:
        nm = array_of(self.wavelength_nm, "wavelength_nm", (None,))
        if not (len(nm) and np.all(np.isfinite(nm)) and np.all(np.diff(nm) > 0)):
            raise Error("wavelength_nm: expected wavelengths that ascend")
        _check_range(nm, "wavelength_nm")
        weight = array_of(self.weight, "weight", (None, len(nm)))
        if not 1 <= len(weight) <= _core.most_bands:
            raise Error(f"weight: expected 1 to {_core.most_bands} bands, found {len(weight)}")
        if not np.all(np.isfinite(weight)) or np.any(weight < 0) or np.any(weight.sum(axis=1) <= 0):
            raise Error("weight: expected weights of at least 0, in each band some above 0")
        edges = None
        if self.edges_nm is not None:
            edges = band_edges(self.edges_nm).copy()
            if len(edges) != len(weight) + 1:
                raise Error(f"edges_nm: expected {len(weight) + 1}, found {len(edges)}")
        cell = None
        if self.cell_nm is not None:
            cell = array_of(self.cell_nm, "cell_nm", (len(nm),)).copy()
            if not (np.all(np.isfinite(cell)) and np.all(cell >= 0)):
                raise Error("cell_nm: expected widths of at least 0")
        elif edges is not None:
            counts = np.count_nonzero(weight, axis=1)
            if counts.sum() == len(nm):
                cell = np.repeat(np.diff(edges) / counts, counts)
        fields = {
            "wavelength_nm": nm.copy(),
            "weight": weight / weight.sum(axis=1, keepdims=True),
            "edges_nm": edges,
            "cell_nm": cell,
        }
        for name, value in fields.items():
            if value is not None:
                value.flags.writeable = False
            object.__setattr__(self, name, value)

    @staticmethod
    @checked
    def from_edges(edges_nm: ArrayLike) -> Bands:
        """Bands side by side: band b is the mean from edges_nm[b] to edges_nm[b + 1], nm.

        Raises:
            omma.Error: edges that do not ascend, fewer than 2 or more than 129.
        """
        edges = band_edges(edges_nm)
        steps = np.ceil(np.diff(edges) / _STEP_NM).astype(int)
        first = np.concatenate([[0], np.cumsum(steps)])
        nm = np.empty(first[-1])
        weight = np.zeros((len(steps), len(nm)))
        for b, (low, high) in enumerate(itertools.pairwise(edges)):
            inside = slice(first[b], first[b + 1])
            nm[inside] = low + (np.arange(steps[b]) + 0.5) * (high - low) / steps[b]
            weight[b, inside] = 1 / steps[b]
        return Bands(nm, weight, edges)

    @staticmethod
    @checked
    def equal(count: int = 16, low_nm: float = 300.0, high_nm: float = 700.0) -> Bands:
        """``count`` bands of the same width from ``low_nm`` to ``high_nm``.

        Example:
            >>> omma.light.Bands.equal().widths_nm[:3]
            array([25., 25., 25.])

        Raises:
            omma.Error: less than 1 or more than 128 bands, wavelengths that do not ascend.
        """
        count = whole(count, "count", 1, _core.most_bands)
        if not low_nm < high_nm:
            raise Error(f"low_nm, high_nm: expected low < high, found {low_nm}, {high_nm}")
        return Bands.from_edges(np.linspace(low_nm, high_nm, count + 1))

    @staticmethod
    @checked
    def from_sensitivities(wavelength_nm: ArrayLike, sensitivity: ArrayLike) -> Bands:
        """One band for each sensitivity, which weighs wavelengths as that does.

        The fewest bands that do: exact for light that comes straight from a lamp or the sky, and
        the worse the more often it is reflected (`band_error`).

        Args:
            wavelength_nm: (K,), ascending.
            sensitivity: (B, K), at least 0, linear between.

        Raises:
            omma.Error: wavelengths that do not ascend, negative sensitivities, or those of a band
                all 0.
        """
        knots = array_of(wavelength_nm, "wavelength_nm", (None,))
        rows = array_of(sensitivity, "sensitivity", (None, len(knots)))
        if len(knots) < 2 or not np.all(np.isfinite(knots)) or not np.all(np.diff(knots) > 0):
            raise Error("wavelength_nm: expected two or more wavelengths that ascend")
        _check_range(knots, "wavelength_nm")
        if not np.all(np.isfinite(rows)) or np.any(rows < 0):
            raise Error("sensitivity: expected numbers of at least 0")
        steps = int(np.ceil((knots[-1] - knots[0]) / _STEP_NM))
        cell = np.full(steps, (knots[-1] - knots[0]) / steps)
        nm = knots[0] + (np.arange(steps) + 0.5) * cell
        weight = means_of_pieces(knots, rows.T, nm, cell).T
        if np.any(weight.sum(axis=1) <= 0):
            raise Error("sensitivity: expected some above 0 in each band")
        return Bands(nm, weight, cell_nm=cell)

    def __len__(self) -> int:
        return len(self.weight)

    def __repr__(self) -> str:
        low, high = self.wavelength_nm[[0, -1]]
        text = f"{len(self)} band{'s' if len(self) != 1 else ''} from {low:.4g} to {high:.4g} nm"
        if self.edges_nm is not None:
            low, high = self.edges_nm[[0, -1]]
            widths = np.diff(self.edges_nm)
            text = f"{len(self)} band{'s' if len(self) != 1 else ''} from {low:g} to {high:g} nm"
            if np.ptp(widths) < 1e-9 * widths[0]:
                text += f", {widths[0]:g} nm each"
        return f"Bands({text})"

    @property
    def centers_nm(self) -> Floats:
        """Mean wavelength of each band: (B,), nm."""
        return np.asarray(self.weight @ self.wavelength_nm)

    @property
    def steps_nm(self) -> Floats:
        """The wavelengths that each sample stands for: (K,), nm."""
        if self.cell_nm is not None:
            return self.cell_nm
        if len(self.wavelength_nm) == 1:
            return np.ones(1)
        return np.asarray(np.gradient(self.wavelength_nm))

    @property
    def widths_nm(self) -> Floats:
        """Width of each band: (B,), nm; of one that is no interval, 1 / ∫ w² dλ of its weights w
        per nm, which is the width of an interval."""
        return np.asarray(1 / (self.weight**2 / self.steps_nm).sum(axis=1))

    def mean(self, spectrum: Any, wavelength_nm: ArrayLike | None = None) -> Floats:
        """Means of a spectrum over each band: (B, ...).

        Args:
            spectrum: a `Spectrum`; a function of wavelengths (K,), nm, that gives values (K, ...);
                or values (N, ...) at ``wavelength_nm`` (N,), linear between.

        Raises:
            omma.Error: values that are not finite, or that do not reach over all bands.
        """
        if isinstance(spectrum, _core.Spectrum):
            values = self._at_samples(spectrum.value, spectrum.wavelength_nm)
        elif callable(spectrum):
            values = array_of(spectrum(self.wavelength_nm), "spectrum")
        elif wavelength_nm is None:
            raise Error("wavelength_nm: expected those of the spectrum, found None")
        else:
            values = self._at_samples(spectrum, wavelength_nm)
        if values.shape[:1] != self.wavelength_nm.shape:
            raise Error(
                f"spectrum: expected shape ({len(self.wavelength_nm)}, ...), found {values.shape}"
            )
        if not np.all(np.isfinite(values)):
            raise Error("spectrum: expected finite values")
        return np.asarray(np.tensordot(self.weight, values, axes=1))

    def _at_samples(self, spectrum: Any, wavelength_nm: ArrayLike) -> Floats:
        knots = array_of(wavelength_nm, "wavelength_nm", (None,))
        values = array_of(spectrum, "spectrum")
        if values.shape[:1] != knots.shape:
            raise Error(f"spectrum: expected shape ({len(knots)}, ...), found {values.shape}")
        if not (len(knots) and np.all(np.isfinite(knots)) and np.all(np.diff(knots) > 0)):
            raise Error("wavelength_nm: expected wavelengths that ascend")
        used = self.wavelength_nm[np.any(self.weight > 0, axis=0)]
        if used[0] < knots[0] or used[-1] > knots[-1]:
            low, high = used[[0, -1]] if self.edges_nm is None else self.edges_nm[[0, -1]]
            raise Error(
                f"spectrum: expected values from {low:g} to {high:g} nm, where the bands are, "
                f"found {knots[0]:g} to {knots[-1]:g} nm; give bands within these, or values as "
                "far as those reach"
            )
        cell = np.zeros(len(self.wavelength_nm)) if self.cell_nm is None else self.cell_nm
        return means_of_pieces(knots, values, self.wavelength_nm, cell)


def means_of_pieces(
    knots_nm: Floats, values: Floats, wavelength_nm: Floats, width_nm: Floats
) -> Floats:
    """Means of what is straight between its values (N, ...) at knots, and beyond them as at the
    nearest, over widths (K,) about wavelengths: (K, ...). Of no width, the value there."""
    columns = np.asarray(values, np.float64).reshape(len(knots_nm), -1)
    # The integral up to each knot, and between two that of the straight line.
    steps = np.diff(knots_nm)[:, None]
    up_to = np.concatenate([np.zeros((1, columns.shape[1])), steps * _middles(columns)]).cumsum(0)

    def at(nm: Floats) -> Floats:
        return np.stack([np.interp(nm, knots_nm, one) for one in columns.T], axis=1)

    def integral(nm: Floats) -> Floats:
        inside = np.clip(nm, knots_nm[0], knots_nm[-1])
        k = np.clip(np.searchsorted(knots_nm, inside, side="right") - 1, 0, len(knots_nm) - 1)
        trapezoid = (inside - knots_nm[k])[:, None] * 0.5 * (columns[k] + at(inside))
        return up_to[k] + trapezoid + (nm - inside)[:, None] * at(inside)

    has_width = width_nm > 0
    wide = np.where(has_width, width_nm, 1.0)
    means = (integral(wavelength_nm + wide / 2) - integral(wavelength_nm - wide / 2)) / wide[
        :, None
    ]
    found = np.where(has_width[:, None], means, at(wavelength_nm))
    return np.asarray(found.reshape(len(wavelength_nm), *np.shape(values)[1:]))


def _middles(columns: Floats) -> Floats:
    return np.asarray(0.5 * (columns[1:] + columns[:-1]))
