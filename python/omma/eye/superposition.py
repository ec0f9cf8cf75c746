"""Superposition: several receptors, or several facets, whose light counts as one.

In flies six receptors of six neighbouring ommatidia look the same way and their axons meet in one
cartridge (neural superposition); in optical superposition eyes many facets throw light on one
rhabdom. Either way there is a wiring: which responses are pooled into which.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye, ReceptorType
from omma.base.arguments import array_of, checked, positive, whole
from omma.base.arrays import Floats, Ints
from omma.base.directions import angle_of_chord, normalized
from omma.base.values import value_class
from omma.eye.trapezoid import TRAPEZOID, trapezoid_offsets
from omma.receptors.mosaic import COLUMN, Region, region_mask
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_axis

__all__ = [
    "Wiring",
    "fly_receptors",
    "neural_superposition_wiring",
    "pool",
    "receptor_wiring",
    "superposition_facets",
]


_MOST = (1 << 63) - 1
# Offsets are rounded to this share of the median interommatidial angle, so that ommatidia with
# nearly the same share their receptor types.
_OFFSET_STEP = 1 / 10


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Wiring:
    """Which responses are pooled into which: those of target i are index[first[i]:first[i + 1]].

    first: (M + 1,); index: (K,), of what is pooled; weight: (K,), of each within its target.
    responses: how many there are to pool from, receptors or ommatidia of the eye that it was made
    for; None: not known, any number that ``index`` allows.
    """

    first: Ints
    index: Ints
    weight: Floats
    responses: int | None = None

    def __post_init__(self) -> None:
        for name, kind in (("first", np.int64), ("index", np.int64), ("weight", np.float64)):
            object.__setattr__(self, name, array_of(getattr(self, name), name, (None,), kind))
        ends = (0, len(self.index))
        if (
            not len(self.first)
            or (self.first[0], self.first[-1]) != ends
            or np.any(self.members < 0)
        ):
            raise Error(
                f"first: expected ascending numbers from 0 to {ends[1]}, one more than targets"
            )
        if len(self.weight) != len(self.index) or np.any(self.index < 0):
            raise Error("index, weight: expected as many of both, indices of at least 0")
        least = int(self.index.max(initial=-1)) + 1
        if self.responses is not None and whole(self.responses, "responses", 0, _MOST) < least:
            raise Error(
                f"responses: expected at least {least}, as index says, found {self.responses}"
            )

    def __len__(self) -> int:
        """How many targets there are."""
        return len(self.first) - 1

    @property
    def members(self) -> Ints:
        """How many responses each target pools: (M,)."""
        return np.diff(self.first)

    def histogram(self) -> dict[int, int]:
        """How many targets pool how many responses, e.g. {5: 48, 6: 700, 7: 30}."""
        members, targets = np.unique(self.members, return_counts=True)
        return dict(zip(members.tolist(), targets.tolist(), strict=True))


def _expect_responses(wiring: Wiring, count: int, what: str, where: str = "") -> None:
    """omma.Error where so many responses are not those that a wiring is of."""
    least = int(wiring.index.max(initial=-1)) + 1
    if wiring.responses is None:
        if count < least:
            raise Error(f"{what}: expected at least {least}{where}, found {count}")
    elif count != wiring.responses:
        raise Error(
            f"{what}: expected {wiring.responses}{where}, as the eye that the wiring was made "
            f"for has, found {count}"
        )


@checked
def pool(responses: ArrayLike, wiring: Wiring, *, axis: int = -1) -> NDArray[np.float32]:
    """The mean of the responses that each target pools, by weight; NaN where there is none.

    ``axis`` is that of receptors (or ommatidia), (..., R, ...), and becomes that of targets,
    (..., M, ...).

    Raises:
        omma.Error: not as many responses as the eye has that the wiring was made for, or where
            that is not known, fewer than it speaks of.
    """
    from scipy.sparse import csr_matrix

    given = array_of(responses, "responses", dtype=np.float32)
    if given.ndim == 0:
        raise Error("responses: expected an array with an axis of receptors, found one number")
    given = np.moveaxis(given, whole(axis, "axis", -given.ndim, given.ndim - 1), 0)
    _expect_responses(wiring, len(given), "responses", f" along axis {axis}")
    matrix = csr_matrix(
        (wiring.weight, wiring.index, wiring.first), shape=(len(wiring), len(given))
    )
    total = np.asarray(matrix.sum(axis=1)).reshape(-1, 1)
    with np.errstate(invalid="ignore"):
        rows = given.reshape(len(given), math.prod(given.shape[1:]))  # -1 of nothing is undefined
        means = (matrix @ rows.astype(np.float64)) / total
    shaped = means.reshape(len(wiring), *given.shape[1:]).astype(np.float32)
    return np.moveaxis(shaped, 0, axis)


@checked
def neural_superposition_wiring(
    eye: Eye, *, receptors: Sequence[str] | None = None, reach: float = 0.5
) -> Wiring:
    """Which receptors look along which ommatidium's axis: the lamina's cartridges, (N targets).

    Each receptor goes to the ommatidium of its eye whose axis is nearest to where it looks, if that
    is within ``reach`` of the local interommatidial angle there. So six are pooled inside a fly's
    eye, fewer at its border, and seven or eight along the equator, where the pattern is mirrored
    (Kirschfeld, Exp Brain Res 3:248, 1967; there with R7/8 as 7, and 8 to 9). Where the lattice has
    faults there may be more.

    Args:
        receptors: names of the types that are pooled; None: all that look beside the axis.
        reach: in local interommatidial angles, above 0; at a half the fields of two neighbouring
            cartridges meet.

    Raises:
        omma.Error: an eye without receptors, or none of these names.
    """
    from scipy.spatial import cKDTree

    reach = positive(reach, "reach")
    looking = receptor_axis(eye).astype(np.float64)
    types = eye.receptor_types
    if receptors is None:
        chosen = np.array([t.right_rad != 0 or t.up_rad != 0 for t in types])
    else:
        chosen = np.array([t.name in receptors for t in types])
    index = np.flatnonzero(chosen[eye.receptor_type])
    if len(index) == 0:
        wanted = "beside the axis" if receptors is None else f"called {', '.join(receptors)}"
        raise Error(f"{eye.path or 'eye'}: expected receptors {wanted}, found none")
    owner = ommatidium_of_receptor(eye)[index]
    axes = normalized(eye.axis.astype(np.float64))
    spacing = eye.interommatidial_angle_rad().astype(np.float64)
    target = np.full(len(index), -1)
    for number in np.unique(eye.eye_id):
        there = np.flatnonzero(eye.eye_id == number)
        mine = np.flatnonzero(eye.eye_id[owner] == number)
        chord, nearest = cKDTree(axes[there]).query(looking[index[mine]])
        found = there[nearest]
        within = angle_of_chord(chord) <= reach * spacing[found]
        target[mine[within]] = found[within]
    return _wiring(target, index, np.ones(len(index)), len(eye), len(looking))


@checked
def fly_receptors(
    eye: Eye,
    *,
    pale_fraction: float = 0.3,
    seed: int = 0,
    dorsal: Region | None = None,
    types: Mapping[str, ReceptorType] | None = None,
) -> Eye:
    """The eye with a fly's receptors: R1 to R6 around R7 and R8, in the trapezoid of neural
    superposition.

    Rhabdomere and axis lie opposite, as the lens inverts. The angle between two rhabdomeres is that
    between the ommatidia of the set (Kirschfeld, Exp Brain Res 3:248, 1967): the offsets follow the
    local lattice of axes, in steps of a tenth of its spacing. They are mirrored between the
    dorsal and the ventral half, and between left and right eyes. R7 and R8 look along the axis;
    pale and yellow ommatidia, R7p with R8p and R7y with R8y, are mixed by chance.

    Args:
        pale_fraction: of pale ommatidia, 0 to 1.
        seed: of their draw.
        dorsal: the dorsal half, a mask (N,) or a function of azimuth and elevation (N,), rad.
            None: axes above the horizon.
        types: what "R1-6", "R7p", "R7y", "R8p" and "R8y" are, but for where R1 to R6 look and their
            names. Those left out have the pigments of Drosophila, 478, 345, 375, 437 and 508 nm
            (Salcedo et al., J Neurosci 19:10716, 1999, as quoted by others). The sensitising
            pigment that makes R1 to R6 see ultraviolet is not in the template, nor how R7 filters
            R8's light.

    Raises:
        omma.Error: fewer than four ommatidia, a share out of range, an unknown name of a type.
    """
    peaks = {"R1-6": 478.0, "R7p": 345.0, "R7y": 375.0, "R8p": 437.0, "R8y": 508.0}
    plan = {name: ReceptorType(name, peak_wavelength_nm=peak) for name, peak in peaks.items()}
    unknown = set(types or {}) - set(plan)
    if unknown:
        raise Error(f"types: expected names from {', '.join(plan)}, found {min(unknown)}")
    plan |= types or {}
    if not 0 <= pale_fraction <= 1:
        raise Error(f"pale_fraction: expected 0 to 1, found {pale_fraction}")
    upper = eye.axis[:, 1] > 0 if dorsal is None else region_mask(eye, dorsal)
    offsets = trapezoid_offsets(eye, upper)
    median = np.median(eye.interommatidial_angle_rad())
    step = _OFFSET_STEP * (float(median) if median > 0 else 1.0)
    made: list[ReceptorType] = []
    known: dict[tuple[str, int, int], int] = {}

    def index_of(name: str, kind: str, right: int = 0, up: int = 0) -> int:
        if (name, right, up) not in known:
            known[name, right, up] = len(made)
            made.append(_looking(plan[kind], name, right * step, up * step))
        return known[name, right, up]

    rounded = np.rint(offsets / step).astype(int)
    draw = np.random.default_rng(whole(seed, "seed", 0, (1 << 64) - 1))
    pale = draw.random(len(eye)) < pale_fraction
    receptors = []
    for i in range(len(eye)):
        around = [
            index_of(name, "R1-6", *rounded[i, k].tolist()) for k, name in enumerate(TRAPEZOID)
        ]
        kind = "p" if pale[i] else "y"
        inner = [index_of(name + kind, name + kind) for name in ("R7", "R8")]
        receptors.append(around + inner)
    columns = {**eye.columns, COLUMN: ["pale" if one else "yellow" for one in pale]}
    return eye.replace(receptor_types=made, receptors=receptors, columns=columns)


@checked
def superposition_facets(eye: Eye, aperture_diameter_m: float | None = None) -> tuple[Eye, Wiring]:
    """Each ommatidium's facets, as those of an optical superposition eye, one by one.

    An ommatidium sees through every facet of its eye that lies within the aperture about its axis
    and is not turned away from it. Rendering the eye that is returned and pooling the responses
    (`pool` with ``axis=1``) gives what `Eye.aperture_diameter_m` stands for, with the facets where
    they are: an entry for each pair, with the facet's position and diameter and the ommatidium's
    axis and receptors, weighted by the facet's area where its diameter is known. What
    `render_receptors` gives is pooled by `receptor_wiring`.

    Args:
        aperture_diameter_m: of the disc across the axis; None: the eye's own. Told here alone it is
            unknown to `omma.receptors.photon_catch`, which then counts photons of one facet: give
            it to the eye, ``eye.replace(aperture_diameter_m=...)``.

    Raises:
        omma.Error: an ommatidium without an aperture, or with no facet in it.
    """
    if aperture_diameter_m is None:
        aperture = eye.aperture_diameter_m.astype(np.float64)
    else:
        aperture = np.full(len(eye), positive(aperture_diameter_m, "aperture_diameter_m"))
    if np.any(aperture <= 0):
        raise Error(f"aperture_diameter_m: ommatidium {np.argmin(aperture)} has none")
    axes = normalized(eye.axis.astype(np.float64))
    position = eye.position_m.astype(np.float64)
    owners, facets = [], []
    for i in range(len(eye)):
        beside = position - position[i]
        along = beside @ axes[i]
        across = np.linalg.norm(beside - along[:, None] * axes[i], axis=1)
        seen = (across <= aperture[i] / 2) & (axes @ axes[i] > 0) & (eye.eye_id == eye.eye_id[i])
        seen[i] = True
        facets.append(np.flatnonzero(seen))
        owners.append(np.full(int(seen.sum()), i))
    owner, facet = np.concatenate(owners), np.concatenate(facets)
    area = eye.facet_diameter_m[facet].astype(np.float64) ** 2
    weight = area if np.all(area > 0) else np.ones(len(facet))
    views = eye.take(owner).replace(
        position_m=eye.position_m[facet],
        facet_diameter_m=eye.facet_diameter_m[facet],
        aperture_diameter_m=0.0,
    )
    return views, _wiring(owner, np.arange(len(owner)), weight, len(eye), len(owner))


@checked
def receptor_wiring(views: Eye, wiring: Wiring) -> Wiring:
    """How receptors of views are pooled where the views are pooled by a wiring.

    Of `superposition_facets`: each receptor of an ommatidium pools those that are in its place in
    the ommatidium's views. Targets are the receptors of the eye that was taken apart, in their
    order.

    Raises:
        omma.Error: views without receptors, not as many as the wiring was made for, or of
            different numbers of receptors in one target.
    """
    if len(views.receptor_type) == 0:
        raise Error("views: expected receptors, found none; give them to the eye before its views")
    _expect_responses(wiring, len(views), "views")
    first = views.first_receptor.astype(np.int64)
    owner = np.repeat(np.arange(len(wiring)), wiring.members)
    count = np.diff(first)[wiring.index]
    of_target = np.zeros(len(wiring), np.int64)
    of_target[owner] = count
    if np.any(of_target[owner] != count):
        uneven = int(owner[np.argmax(of_target[owner] != count)])
        raise Error(f"views: expected as many receptors in all of target {uneven}")
    first_target = np.concatenate([[0], np.cumsum(of_target)])
    entry = np.repeat(np.arange(len(count)), count)
    place = np.arange(len(entry)) - np.repeat(np.cumsum(count) - count, count)
    return _wiring(
        first_target[owner[entry]] + place,
        first[wiring.index[entry]] + place,
        wiring.weight[entry],
        int(first_target[-1]),
        int(first[-1]),
    )


def _looking(kind: ReceptorType, name: str, right_rad: float, up_rad: float) -> ReceptorType:
    """A receptor type by another name, looking elsewhere."""
    pigment = kind.peak_wavelength_nm != 0
    return ReceptorType(
        name,
        peak_wavelength_nm=kind.peak_wavelength_nm,
        wavelength_nm=None if pigment else kind.wavelength_nm,
        sensitivity=None if pigment else kind.sensitivity,
        microvillus_angle_rad=kind.microvillus_angle_rad,
        polarisation_sensitivity=kind.polarisation_sensitivity,
        absorption_per_m=kind.absorption_per_m,
        length_m=kind.length_m,
        right_rad=right_rad,
        up_rad=up_rad,
        acceptance=kind.acceptance,
        allow_unusual=True,  # a coarse eye looks far beside its axes
    )


def _wiring(target: Ints, index: Ints, weight: Floats, count: int, responses: int) -> Wiring:
    """A wiring of ``count`` targets from pairs (target, index); a target of -1 is none."""
    order = np.argsort(target, kind="stable")
    order = order[target[order] >= 0]
    first = np.searchsorted(target[order], np.arange(count + 1))
    return Wiring(first.astype(np.int64), index[order].astype(np.int64), weight[order], responses)
