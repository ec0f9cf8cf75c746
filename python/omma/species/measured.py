"""A fruit fly whose every facet is measured: axes by micro-CT, by the columns of the medulla.

The table is data/drosophila_columns.csv, under a licence of its own (CC BY-SA 4.0), which says
where it is from. What it does not hold, lenses, acceptance and receptors, is of the modelled fly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from omma._core import Acceptance, Error, Eye, ReceptorType
from omma.base.arguments import checked, whole, within
from omma.base.arrays import Flags, Floats, Ints
from omma.base.directions import normalized
from omma.base.tables import packaged_rows
from omma.eye.change import merge_eyes, mirror_eye
from omma.receptors.mosaic import COLUMN
from omma.receptors.sensitivity import govardovskii
from omma.species._receptors import receptor
from omma.species._shape import on_ellipsoid
from omma.species.facts import LATIN, facts, number
from omma.species.species import Species

_NAME = "drosophila"
# What ommatidia are, by their R7 and R8; of yellow ones in the dorsal third R7 has Rh3 besides.
KINDS = ("pale", "yellow", "yellow, dorsal", "dorsal rim")
# The column of the eye that says which column of the medulla an ommatidium's R7 and R8 go to.
MEDULLA_COLUMN = "medulla_column"


@dataclass(frozen=True)
class EyeMap:
    """The table: hex1, hex2, side (-1 left, 1 right), dorsal_rim (M,); axis (M, 3), in the head."""

    hex1: Ints
    hex2: Ints
    side: Ints
    axis: Floats
    dorsal_rim: Flags


@cache
def eye_map() -> EyeMap:
    """The table of measured axes, the left eye first."""
    rows = packaged_rows("omma.species", "data/drosophila_columns.csv")
    x, y, z = (np.array([float(row[way]) for row in rows]) for way in "xyz")
    axis = np.stack([-y, z, -x], axis=1)  # x points ahead, y to the left, z up
    return EyeMap(
        np.array([int(row["hex1"]) for row in rows]),
        np.array([int(row["hex2"]) for row in rows]),
        np.array([1 if row["side"] == "right" else -1 for row in rows]),
        normalized(axis),
        np.array([row["dorsal_rim"] == "1" for row in rows]),
    )


@checked
def measured_drosophila(
    column_types: Mapping[str, str] | None = None,
    *,
    pale_fraction: float = 0.3,
    seed: int = 0,
) -> Species:
    """The fruit fly of `drosophila` with the axes that were measured of one, 850 left, 846 right.

    Axes: micro-CT of a female's head, both eyes (Zhao et al. 2025, Nature,
    doi:10.1038/s41586-025-09276-5), laid on the medulla columns of MaleCNS by its authors
    (github.com/artxz/eyemap-archive, CC BY-SA 4.0). The eye's column "medulla_column" has their
    names, as "ME_R_col_18_19"; of 892 and 880 columns 46 at the rim of the right lobe and 30 of the
    left one have no axis there.

    Receptors of each: R1-6, what the six see that meet in its cartridge, along the axis; R7 and R8,
    whose kind is in the eye's column "ommatidium_type". Dorsal rim (R7d, R8d, both with Rh3): the
    columns that have R7d or R8d in male-cns:v1.0. Pale (R7p Rh3, R8p Rh5) and yellow (R7y Rh4, R8y
    Rh6): at random, as in the fly, 30 % pale; which of a fly's are which, ``column_types`` says.
    R7 of yellow ommatidia in the dorsal third has Rh3 and Rh4 (Mazzoni et al. 2008, PLoS Biol
    6:e97); how much of each is not known, here half.

    Assumed, as in `drosophila`: the ellipsoid on which the lenses sit, facets by their distances
    there, one acceptance angle for all. Not modelled: the microvilli of the dorsal rim.

    Args:
        column_types: "pale", "yellow" or "dorsal rim" by name of column, as
            `omma.columns.load_column_types` reads them; what it does not name is drawn.
        pale_fraction: of those that are drawn, 0 to 1.
        seed: of the draw.

    Example:
        >>> fly = omma.species.measured_drosophila().eye
        >>> at = fly.columns["medulla_column"].index("ME_R_col_18_19")
        >>> omma.eye.azimuth_elevation_deg_of(fly.axis[at : at + 1])[0].round(1).tolist()
        [57.5]

    Raises:
        omma.Error: a name that is no column of this map, another type, a share out of its range.
    """
    table = eye_map()
    names = medulla_names(table.hex1, table.hex2, table.side)
    given = {} if column_types is None else column_types
    if not isinstance(given, Mapping):
        found = type(given).__name__
        raise TypeError(f"column_types: expected types by name of column, found {found}")
    share = within(pale_fraction, "pale_fraction", 0, 1)
    kinds = _kinds(table, names, given, share, whole(seed, "seed", 0, (1 << 64) - 1))
    types = _receptor_types()
    index = {one.name: k for k, one in enumerate(types)}
    inner = {
        "pale": ("R7p", "R8p"), "yellow": ("R7y", "R8y"),
        "yellow, dorsal": ("R7y, dorsal", "R8y"), "dorsal rim": ("R7d", "R8d"),
    }  # fmt: skip
    eye = _optics().replace(
        receptor_types=types,
        receptors=np.array(
            [[index[name] for name in ("R1-6", *inner[kind])] for kind in kinds], np.int32
        ),
        columns={
            "region": ["dorsal rim" if kind == "dorsal rim" else "eye" for kind in kinds],
            COLUMN: kinds,
            MEDULLA_COLUMN: names,
        },
    )
    return Species(_NAME, LATIN[_NAME], eye, facts(_NAME))


def medulla_names(hex1: Ints, hex2: Ints, side: Ints) -> list[str]:
    """As MaleCNS calls columns (M,): ME_R_col_18_19, hex1 before hex2."""
    rows = zip(hex1.tolist(), hex2.tolist(), side.tolist(), strict=True)
    return [f"ME_{'R' if s > 0 else 'L'}_col_{one:02d}_{other:02d}" for one, other, s in rows]


@cache
def _optics() -> Eye:
    """Both eyes without receptors: lenses, axes and acceptance."""
    table = eye_map()
    left, right = (
        on_ellipsoid(
            _NAME, table.axis[table.side == side] * [side, 1, 1], (80, 0), "median_facet_diameter"
        )
        for side in (-1, 1)
    )
    return merge_eyes([mirror_eye(left).replace(eye_id=0), right]).replace(
        acceptance=Acceptance.gaussian(number(_NAME, "acceptance_angle"))
    )


def _kinds(
    table: EyeMap, names: list[str], given: Mapping[str, str], pale_fraction: float, seed: int
) -> list[str]:
    unknown = set(given) - set(names)
    if unknown:
        raise Error(
            f"column_types: expected names of columns that have an axis, as {names[-1]}, found "
            f"{min(unknown, key=str)!r:.40}"
        )
    pale = np.random.default_rng(seed).random(len(names)) < pale_fraction
    row = table.hex1 + table.hex2  # counts up to dorsal
    kinds = []
    thirds = {s: np.quantile(row[table.side == s], 2 / 3) for s in (-1, 1)}
    for k, name in enumerate(names):
        drawn = "dorsal rim" if table.dorsal_rim[k] else "pale" if pale[k] else "yellow"
        kind = given.get(name, drawn)
        if kind not in ("pale", "yellow", "dorsal rim"):
            raise Error(
                f"column_types: expected pale, yellow or dorsal rim of {name}, found {kind!r:.40}"
            )
        dorsal = kind == "yellow" and row[k] > thirds[int(table.side[k])]
        kinds.append("yellow, dorsal" if dorsal else kind)
    return kinds


def _receptor_types() -> list[ReceptorType]:
    peaks = {
        "R1-6": "rh1_peak", "R7p": "rh3_peak", "R8p": "rh5_peak", "R7y": "rh4_peak",
        "R8y": "rh6_peak", "R7d": "rh3_peak", "R8d": "rh3_peak",
    }  # fmt: skip
    wavelength_nm = np.arange(300.0, 601.0, 2.0)
    both = sum(govardovskii(number(_NAME, f"rh{k}_peak"), wavelength_nm) for k in (3, 4))
    mixed = ReceptorType("R7y, dorsal", wavelength_nm=wavelength_nm, sensitivity=both / both.max())
    return [*(receptor(_NAME, name, peak) for name, peak in peaks.items()), mixed]
