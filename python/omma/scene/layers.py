"""Stacks of thin layers: what they and bare metals reflect, by wavelength, angle and polarisation.

Amplitudes follow Rouard's recursion over the layers from inside to outside (Born and Wolf 1999,
Principles of Optics, 1.6; Heavens 1955), which in absorbing layers only ever multiplies by numbers
below 1. The indices are n + ik, k at least 0; fields go as exp(-i omega t). Signs of the amplitudes
are those of physics/surface/fresnel.h.
"""

from __future__ import annotations

import numbers
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import BoundaryTable, Error, Material
from omma.base.arguments import array_of, checked, one_of, within
from omma.base.arrays import Floats
from omma.base.tables import packaged_rows
from omma.base.values import value_class
from omma.base.warn import warn_caller
from omma.scene.spectrum_colours import linear_srgb

Complex = NDArray[np.complex128]
# A number for all wavelengths, or rows of wavelength (nm), n and, unless it is 0, k.
Index = complex | float | Floats

# Nodes of the tables that `boundary` makes: as many as the engine has.
_COSINES = 129
_STEP_NM = 2.0
# What a table may be off by between its nodes without a word; one in so many wavelengths is tried.
_FINE, _EACH_TRIED = 0.01, 8
_BAND_NM, _STEEP_DEG = 25.0, 80
_LEAST_NM, _MOST_NM = 0.5, 1e5  # of the thickest layer: two atoms
# No clear matter has an index above this, and no layer that shines is thinner than so many nm: both
# together are a pair the wrong way round.
_SWAPPED = 10.0
_MOST_SPREAD = 0.2
# Of |n + ik|, and wavelengths: wider than those of any matter and light that animals see.
_SIZES = (0.01, 100)
_WAVELENGTHS_NM = (10, 100_000)
# Thicknesses are averaged over so many standard deviations on both sides.
_REACH = 4.0
_POINTS_AT_ONCE = 1 << 12
# Grazing light counts as this, as in layers of air beams without end would add up there.
_LEAST_COSINE = 1e-6


class _Spread(NamedTuple):
    """Thicknesses as factors, the first and how much more each next one is, and their weights."""

    first: float
    step: float
    weights: Floats


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class LayerStack:
    """Thin layers on something thick, in air: a scale, a beetle's cuticle, an oxide, a bare metal.

    Light that is not reflected is absorbed, below if not in the layers: nothing comes back from
    under the stack. An index is n + ik, k at least 0: a number, or a table (W, 2) or (W, 3) of
    wavelength in nm, ascending, n and k, linear between and held beyond (`refractive_index` has
    some).

    layers: pairs (thickness in nm, index), from outside to inside; none: the bare substrate.
    substrate: the index of what they lie on.
    spread: standard deviation of the thickness, of all layers together, as a share of it, 0 to 0.2:
        scales and cuticles are not all alike. Reflectances are averaged over it, Gaussian.

    Raises:
        omma.Error: thicknesses that are not 0 to 100,000 nm, indices with a part below 0 or of a
            size that is not 0.01 to 100, pairs the other way round, a spread out of range.

    Example:
        >>> film = omma.scene.LayerStack([(200, 1.55)], substrate=1.0)
        >>> round(float(film.mueller(500, 0)[0, 0, 0]), 3)
        0.088
    """

    layers: tuple[tuple[float, Index], ...] = ()
    substrate: Index = 1.0
    spread: float = 0.0

    def __post_init__(self) -> None:
        layers = self.layers
        if isinstance(layers, str) or not isinstance(layers, Iterable):
            raise TypeError(
                f"layers: expected pairs of a thickness and an index, found "
                f"{type(layers).__name__} {layers!r:.40}"
            )
        made = []
        for i, layer in enumerate(layers):
            if isinstance(layer, str) or not isinstance(layer, Iterable):
                raise TypeError(f"layers[{i}]: expected a pair, found {type(layer).__name__}")
            pair: tuple[Any, ...] = tuple(layer)
            if len(pair) != 2:
                raise Error(f"layers[{i}]: expected a thickness and an index, found {len(pair)}")
            thickness = within(pair[0], f"layers[{i}] thickness", 0, _MOST_NM)
            if (
                thickness < _SWAPPED
                and isinstance(pair[1], numbers.Real)
                and float(pair[1]) > _SWAPPED
            ):
                raise Error(
                    f"layers[{i}]: expected a thickness in nm and then an index, found "
                    f"{thickness:g} nm and an index of {float(pair[1]):g}: the other way round"
                )
            made.append((thickness, _checked_index(pair[1], f"layers[{i}] index")))
        thickest = max((thickness for thickness, _ in made), default=0.0)
        if 0 < thickest < _LEAST_NM:
            raise Error(
                f"layers: expected thicknesses in nm, found at most {thickest:g}, thinner than two "
                "atoms: these are metres or micrometres"
            )
        object.__setattr__(self, "layers", tuple(made))
        object.__setattr__(self, "substrate", _checked_index(self.substrate, "substrate"))
        object.__setattr__(self, "spread", within(self.spread, "spread", 0, _MOST_SPREAD))

    @checked
    def mueller(self, wavelength_nm: ArrayLike, angle_deg: ArrayLike) -> Floats:
        """Elements of the Mueller matrix of a reflection: (W, A, 3) for W wavelengths, A angles.

        a is the reflectance of unpolarised light, a + b that of light that swings across the plane
        of incidence (s), a - b of light that swings in it (p), c is Re(r_s r_p*).

        Args:
            wavelength_nm: (W,) or a number, 10 to 100,000.
            angle_deg: (A,) or a number, from the normal, 0 to 90.

        Raises:
            omma.Error: wavelengths or angles out of range.
        """
        nm = np.atleast_1d(array_of(wavelength_nm, "wavelength_nm", [(), (None,)], finite=True))
        angle = np.atleast_1d(array_of(angle_deg, "angle_deg", [(), (None,)], finite=True))
        _check_wavelengths(nm)
        if not np.all((angle >= 0) & (angle <= 90)):
            raise Error("angle_deg: expected 0 to 90")
        return self._mueller(nm, np.cos(np.radians(angle)))

    @checked
    def boundary(self, wavelength_nm: ArrayLike | None = None) -> BoundaryTable:
        """The table by which a `Material` reflects like this stack, as ``Material(boundary=)``.

        Args:
            wavelength_nm: (W,), ascending; None: every 2 nm from 300 to 700 nm. Bands of a light
                take the means over them, straight between; beyond the last it is held.

        Raises:
            omma.Error: fewer than 2 wavelengths, or some that do not ascend from 100 to 5,000 nm.

        Warns:
            UserWarning: reflectance changes faster than the table's 129 cosines or its
                wavelengths tell, as by fringes of thick films.
        """
        if wavelength_nm is None:
            nm = np.arange(300.0, 700.0 + _STEP_NM / 2, _STEP_NM)
        else:
            nm = array_of(wavelength_nm, "wavelength_nm", (None,), finite=True)
            _check_wavelengths(nm)
        cosine = np.linspace(0, 1, _COSINES)
        table = self._mueller(nm, cosine)
        self._tell_of_fringes(nm, cosine, table)
        return BoundaryTable(nm, table)

    def _tell_of_fringes(self, nm: Floats, cosine: Floats, table: Floats) -> None:
        """Warn where a table (W, C, 3) has too few nodes for the fringes of thick films."""
        # Next to grazing all boundaries rise to 1 within a few nodes.
        steep = np.flatnonzero(cosine > np.cos(np.radians(_STEEP_DEG)))
        cosine, table = cosine[steep], table[:, steep]
        by_angle = self._mueller(nm[::_EACH_TRIED], (cosine[1:] + cosine[:-1]) / 2)
        by_angle -= (table[::_EACH_TRIED, 1:] + table[::_EACH_TRIED, :-1]) / 2
        by_nm = self._mueller((nm[1:] + nm[:-1]) / 2, cosine[::_EACH_TRIED])
        by_nm -= (table[1:, ::_EACH_TRIED] + table[:-1, ::_EACH_TRIED]) / 2
        # Bands take means, in which what is off on both sides of a fringe cancels.
        of_band = max(1, round(_BAND_NM * len(by_nm) / float(nm[-1] - nm[0])))
        runs = np.arange(0, len(by_nm), of_band)
        by_nm = np.add.reduceat(by_nm, runs) / np.diff(runs, append=len(by_nm))[:, None, None]
        for off, way in (
            (by_angle, f"{_COSINES} cosines of the table"),
            (by_nm, f"{len(nm)} wavelengths of the table, of which there may be more"),
        ):
            worst = float(np.abs(off).max())
            if worst > _FINE:
                warn_caller(
                    f"layers: reflectance changes faster than the {way}, as by fringes of thick "
                    f"films; up to {_STEEP_DEG} degrees it is off by up to {worst:.2g} between "
                    "them, where `mueller` is exact",
                    UserWarning,
                )

    @checked
    def material(self, name: str = "", roughness: float = 0.0) -> Material:
        """A material of scenes that reflects like this stack, for worlds that are lit.

        Its base colour, which other programs show, is that of the reflectance at normal incidence.

        Args:
            roughness: as in glTF, of the facets that the stack lies on: 0 is a mirror.

        Raises:
            omma.Error: a roughness that is not 0 to 1.
        """
        roughness = within(roughness, "roughness", 0, 1)
        nm = np.arange(400.0, 701.0, 5.0)
        color = linear_srgb(nm, self.mueller(nm, 0)[:, 0, 0])
        return Material(
            name,
            base_color=color,
            metallic=1,
            roughness=roughness,
            boundary=self.boundary(),
        )

    def _mueller(self, nm: Floats, cosine: Floats) -> Floats:
        """(W, C, 3), averaged over thicknesses."""
        spread = self._thicknesses(nm)
        out = np.zeros((len(nm), len(cosine), 3))
        depths = [thickness for thickness, _ in self.layers]
        rows = max(1, _POINTS_AT_ONCE // max(1, len(cosine)))
        for first in range(0, len(nm), rows):
            part = nm[first : first + rows]
            indices = [_index_at(index, part) for _, index in self.layers]
            indices.append(_index_at(self.substrate, part))
            out[first : first + rows] = _elements(part, cosine, depths, indices, spread)
        return out

    def _thicknesses(self, nm: Floats) -> _Spread:
        """The trapezoidal rule, which for a Gaussian is exact where its steps are short beside
        periods of the phase, here of beams that go to and fro six times."""
        optical = sum(
            thickness * np.max(np.abs(_index_at(index, nm))) for thickness, index in self.layers
        )
        if self.spread == 0 or optical == 0:
            return _Spread(1.0, 0.0, np.ones(1))
        phase = 4 * np.pi * optical / np.min(nm) * self.spread  # of a standard deviation
        half = int(np.ceil(_REACH * (6 * phase + _REACH) / (2 * np.pi))) + 2
        weights = np.exp(-(np.linspace(-_REACH, _REACH, 2 * half + 1) ** 2) / 2)
        reach = self.spread * _REACH
        return _Spread(1 - reach, reach / half, weights / weights.sum())

    def __repr__(self) -> str:
        thickness = sum(thickness for thickness, _ in self.layers)
        layers = f"{len(self.layers)} layer{'' if len(self.layers) == 1 else 's'}"
        return f"LayerStack({layers}, {thickness:g} nm)"


@checked
def refractive_index(substance: str) -> Floats:
    """A measured refractive index n + ik: (W, 3), wavelength in nm, n and k, for `LayerStack`.

    Sources are in python/omma/scene/refractive_indices.csv. Films differ by how they were made;
    take your own numbers where you have them.

    Args:
        substance: "aluminium", "chitin", "copper", "gold" or "silver".

    Example:
        >>> omma.scene.refractive_index("gold")[0]
        array([292.4  ,   1.49 ,   1.878])

    Raises:
        omma.Error: a substance that is not among them.
    """
    known = _indices()
    index: Floats = known[one_of(substance, known, "substance")].copy()
    return index


@cache
def _indices() -> dict[str, Floats]:
    found: dict[str, list[list[float]]] = {}
    for row in packaged_rows("omma.scene", "refractive_indices.csv"):
        numbers_there = [float(row[column]) for column in ("wavelength_nm", "n", "k")]
        found.setdefault(row["substance"], []).append(numbers_there)
    return {name: np.array(rows) for name, rows in found.items()}


def _check_wavelengths(nm: Floats) -> None:
    if not np.all((nm >= _WAVELENGTHS_NM[0]) & (nm <= _WAVELENGTHS_NM[1])):
        raise Error(f"wavelength_nm: expected {_WAVELENGTHS_NM[0]:,} to {_WAVELENGTHS_NM[1]:,} nm")


def _checked_index(given: Any, name: str) -> Index:
    if isinstance(given, numbers.Complex) and not isinstance(given, bool):
        index = complex(given)
        if not (index.real >= 0 and index.imag >= 0 and _SIZES[0] <= abs(index) <= _SIZES[1]):
            raise Error(
                f"{name}: expected n + ik, neither below 0, of a size of {_SIZES[0]} to "
                f"{_SIZES[1]}, found {given!r:.40}"
            )
        return index if index.imag else index.real
    table: Floats = array_of(given, name, [(None, 2), (None, 3)], finite=True).copy()
    if len(table) < 2 or not np.all(np.diff(table[:, 0]) > 0) or table[0, 0] <= 0:
        raise Error(f"{name}: expected 2 or more wavelengths that ascend")
    size = np.linalg.norm(table[:, 1:], axis=1)
    if np.any(table[:, 1:] < 0) or np.any((size < _SIZES[0]) | (size > _SIZES[1])):
        raise Error(
            f"{name}: expected n and k that are not below 0, n + ik of a size of {_SIZES[0]} to "
            f"{_SIZES[1]}"
        )
    table.flags.writeable = False
    return table


def _index_at(index: Index, nm: Floats) -> Complex:
    """(W, 1)."""
    if not isinstance(index, np.ndarray):
        return np.full((len(nm), 1), index, np.complex128)
    at = [np.interp(nm, index[:, 0], index[:, column]) for column in range(1, index.shape[1])]
    return cast(Complex, (at[0] + 1j * (at[1] if len(at) > 1 else 0)).reshape(-1, 1))


def _elements(
    nm: Floats, cosine: Floats, depths_nm: list[float], indices: list[Complex], spread: _Spread
) -> Floats:
    """a, b and c, (W, C, 3), of layers of these depths and the substrate last."""
    cosine = np.maximum(cosine, _LEAST_COSINE)
    sine2 = 1 - cosine**2
    # n cos of the angle inside: its imaginary part is at least 0, so that waves decay inwards.
    q = [cosine.astype(np.complex128)[None, :]]
    q += [np.sqrt(index**2 - sine2) for index in indices]
    of_p = [of / index**2 for of, index in zip(q, [np.ones((1, 1)), *indices])]
    steps = [[_step(ways[i], ways[i + 1]) for i in range(len(indices))] for ways in (q, of_p)]
    # On the way to and fro in each layer; for the next thickness a factor more.
    ways = [4j * np.pi / nm[:, None] * depth * of for depth, of in zip(depths_nm, q[1:])]
    beams = [np.exp(way * spread.first) for way in ways]
    more = [np.exp(way * spread.step) for way in ways]
    out = np.zeros((len(nm), len(cosine), 3))
    for weight in spread.weights:
        amplitudes = []
        for step in steps:
            r = step[-1]
            for i in reversed(range(len(beams))):
                inside = r * beams[i]
                r = (step[i] + inside) / (1 + step[i] * inside)
            amplitudes.append(r)
        s, p = amplitudes
        s2, p2 = np.abs(s) ** 2, np.abs(p) ** 2
        out[..., 0] += weight * (s2 + p2) / 2
        out[..., 1] += weight * (s2 - p2) / 2
        out[..., 2] += weight * (s * np.conj(p)).real
        for beam, factor in zip(beams, more):
            beam *= factor
    out[..., 0] = np.minimum(out[..., 0], 1)
    return out


def _step(outside: Complex, inside: Complex) -> Complex:
    """Fresnel's amplitude between two layers; that of no difference is 0."""
    total = outside + inside
    even = total == 0
    return np.where(even, 0, (outside - inside) / np.where(even, 1, total))
