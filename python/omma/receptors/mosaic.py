"""Who has which receptors: ommatidia of several types mixed over an eye, or over a region of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye, ReceptorType
from omma.base.arguments import array_of, checked
from omma.base.arrays import Flags
from omma.base.values import value_class

# A region of an eye: a mask (N,), or a function of azimuth and elevation (N,), rad, that gives one.
Region = ArrayLike | Callable[[NDArray[np.float64], NDArray[np.float64]], ArrayLike]

# The column that says which type an ommatidium is of.
COLUMN = "ommatidium_type"


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class OmmatidiumType:
    """What the ommatidia of one type have, and how common they are.

    receptors: those of each such ommatidium; the same type may come several times.
    abundance: how many ommatidia are of it, relative to the other types.

    Raises:
        omma.Error: receptors that are no sequence of `ReceptorType`, an abundance that is negative
            or not finite.
    """

    name: str
    receptors: tuple[ReceptorType, ...]
    abundance: float = 1.0

    def __post_init__(self) -> None:
        receptors = self.receptors
        if not isinstance(receptors, Sequence) or not all(
            isinstance(one, ReceptorType) for one in receptors
        ):
            raise Error(
                "receptors: expected a tuple of omma.receptors.ReceptorType, found "
                f"{receptors!r:.80}"
            )
        object.__setattr__(self, "receptors", tuple(receptors))
        if not (isinstance(self.abundance, Real) and 0 <= self.abundance < math.inf):
            raise Error(f"abundance: expected a number of at least 0, found {self.abundance!r:.40}")


@checked
def assign_receptors(
    eye: Eye,
    types: OmmatidiumType | Sequence[OmmatidiumType],
    *,
    where: Region | None = None,
    seed: int = 0,
) -> Eye:
    """The eye with receptors: each ommatidium draws its type, by itself and by chance.

    So pale and yellow ommatidia of flies are mixed, and the three types of bees. The same seed
    gives the same draw, whatever ``where`` is. Which type an ommatidium got is in the eye's column
    "ommatidium_type". Receptor types are numbered in the order given, after those that are kept.

    Args:
        types: one, or several with their shares.
        where: the region of the eye that gets them, others keep what they have: a mask (N,) or a
            function of azimuth and elevation (N,), rad. None: all of it.
        seed: of the draw, at least 0.

    Raises:
        omma.Error: no type, shares that are all 0, a mask of another shape.
    """
    kinds = (types,) if isinstance(types, OmmatidiumType) else tuple(types)
    if not kinds:
        raise Error("types: expected at least one OmmatidiumType, found none")
    abundance = np.array([kind.abundance for kind in kinds], np.float64)
    if abundance.sum() <= 0:
        found = [kind.abundance for kind in kinds]
        raise Error(f"types: expected abundances that are not all 0, found {found}")
    if seed < 0:
        raise Error(f"seed: expected at least 0, found {seed}")
    inside = region_mask(eye, where)
    drawn = np.random.default_rng(seed).random(len(eye))
    kind_of = np.searchsorted(np.cumsum(abundance)[:-1] / abundance.sum(), drawn, side="right")
    # What is kept first, then new types in the order given, whatever the draw.
    before = eye.receptor_types
    is_kept = np.repeat(~inside, np.diff(eye.first_receptor)) if before else np.zeros(0, bool)
    kept = [before[t] for t in np.unique(eye.receptor_type[is_kept])]
    drawn_kinds = np.unique(kind_of[inside]).tolist()
    new = [receptor for k in drawn_kinds for receptor in kinds[k].receptors]
    known = list(dict.fromkeys([*kept, *new]))
    index = {receptor: k for k, receptor in enumerate(known)}
    receptors_of_kind = {k: [index[one] for one in kinds[k].receptors] for k in drawn_kinds}

    lists: list[list[int]] = []
    names = list(eye.columns.get(COLUMN, [""] * len(eye)))
    for i in range(len(eye)):
        if inside[i]:
            names[i] = kinds[kind_of[i]].name
            lists.append(receptors_of_kind[kind_of[i]])
        else:
            own = eye.receptor_type[eye.first_receptor[i] : eye.first_receptor[i + 1]]
            lists.append([index[before[t]] for t in own])
    columns = {**eye.columns, COLUMN: [str(name) for name in names]}
    return eye.replace(receptor_types=known, receptors=lists, columns=columns)


@checked
def up_towards(eye: Eye, direction: ArrayLike, *, where: Region | None = None) -> Eye:
    """The eye with up vectors that point, across each axis, to one direction (3,) in the head.

    A fan: microvilli at an angle of 0 then lie along great circles through that direction, those at
    90° along circles around it. Towards the zenith it is what an eye has anyway.

    Raises:
        omma.Error: a direction that is not finite or zero, or along an axis; a mask of another
            shape.
    """
    target = array_of(direction, "direction")
    if target.shape != (3,) or not np.all(np.isfinite(target)) or not target.any():
        raise Error(f"direction: expected three numbers, not all 0, found {target.tolist()}")
    target = target / np.abs(target).max()  # whose square is a number, however small or large
    up = eye.up.astype(np.float64)
    inside = region_mask(eye, where)
    up[inside] = target / np.linalg.norm(target)
    return eye.replace(up=up)


def region_mask(eye: Eye, where: Region | None) -> Flags:
    """Which ommatidia are in a region of an eye: (N,)."""
    if where is None:
        return np.ones(len(eye), bool)
    if callable(where):
        x, y, z = eye.axis.T.astype(np.float64)
        where = where(np.arctan2(x, -z), np.arctan2(y, np.hypot(x, z)))
    try:
        mask = np.asarray(where)
    except ValueError:
        expected = f"a mask of {len(eye)} truth values"
        raise Error(f"where: expected {expected}, found rows of different lengths") from None
    if mask.shape != (len(eye),) or mask.dtype != np.bool_:
        raise Error(
            f"where: expected a mask of {len(eye)} truth values, found {mask.dtype} of shape "
            f"{mask.shape}"
        )
    return mask


@checked
def honeybee_ommatidia() -> tuple[OmmatidiumType, OmmatidiumType, OmmatidiumType]:
    """The three types of a honeybee worker's ommatidia, I, II and III, for `assign_receptors`.

    I: an ultraviolet, a blue and six green receptors; II: two ultraviolet, six green; III: two
    blue, six green; about 44:46:10 of them, mixed rather randomly, III up to 18 % in the front of
    the ventral part (Wakakuwa, Kurasawa, Giurfa and Arikawa, Naturwissenschaften 92:464, 2005). The
    ninth, short cell is left out, as its spectral quality is not known. Peaks at 344, 436 and 544
    nm (Peitsch et al. 1992, as quoted by others), in rhabdoms of 320 µm that absorb 0.0067 per µm,
    so that pigments screen themselves: the receptors of `omma.species.honeybee_worker`.
    """
    uv, blue, green = (
        ReceptorType(
            name, peak_wavelength_nm=peak, absorption_per_m=0.0067 * 1e6, length_m=320 * 1e-6
        )
        for name, peak in (("ultraviolet", 344), ("blue", 436), ("green", 544))
    )
    greens = (green,) * 6
    return (
        OmmatidiumType("I", (uv, blue, *greens), 0.44),
        OmmatidiumType("II", (uv, uv, *greens), 0.46),
        OmmatidiumType("III", (blue, blue, *greens), 0.10),
    )
