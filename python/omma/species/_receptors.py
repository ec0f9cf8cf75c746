"""Receptors of the species: which types there are, and which ommatidium has which."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye, ReceptorType
from omma.species.facts import number

_SEED = 20  # of the random arrangement of types over an eye: any number, always the same


def receptor(animal: str, name: str, peak: str, **properties: float) -> ReceptorType:
    """A receptor whose visual pigment peaks at the table's ``peak``."""
    return ReceptorType(name, peak_wavelength_nm=number(animal, peak), **properties)


def shared_out(shares: Sequence[float], count: int) -> NDArray[np.int64]:
    """Kinds (count,) in these shares, exact to one, in a random order that is always the same."""
    edges = np.round(np.cumsum(shares) / np.sum(shares) * count).astype(np.int64)
    kinds = np.repeat(np.arange(len(shares)), np.diff(edges, prepend=0))
    return np.random.default_rng(_SEED).permutation(kinds)


def with_receptors(
    eye: Eye, types: Sequence[ReceptorType], sets: Sequence[list[int]], kind: NDArray[np.int64]
) -> Eye:
    """The eye with the set ``kind[i]`` of receptors in ommatidium i."""
    return eye.replace(receptor_types=list(types), receptors=[sets[k] for k in kind])


def bee_receptors(eye: Eye, animal: str, **properties: float) -> Eye:
    """Ommatidia of type I (1 ultraviolet, 1 blue, 6 green), II (2 UV, 6 green), III (2 blue, 6
    green) at random: Wakakuwa et al. 2005."""
    types = [
        receptor(animal, name, peak, **properties)
        for name, peak in (("ultraviolet", "uv_peak"), ("blue", "blue_peak"), ("green", "green_peak"))
    ]
    first, second = number(animal, "type_1_share"), number(animal, "type_2_share")
    kind = shared_out([first, second, 1 - first - second], len(eye))
    green = [2] * 6
    return with_receptors(eye, types, [[0, 1, *green], [0, 0, *green], [1, 1, *green]], kind)


def drone_receptors(eye: Eye, animal: str, dorsal: NDArray[np.bool_]) -> Eye:
    """Below, the worker's three types; above, blue with none, one or two ultraviolet receptors."""
    types = [
        receptor(animal, name, peak)
        for name, peak in (("ultraviolet", "uv_peak"), ("blue", "blue_peak"), ("green", "green_peak"))
    ]
    green = [2] * 6
    sets = [[0, 1, *green], [0, 0, *green], [1, 1, *green], [1] * 8, [0] + [1] * 7, [0, 0] + [1] * 6]
    shares = [number("honeybee_worker", f"type_{k}_share") for k in (1, 2, 3)]
    kind = np.empty(len(eye), np.int64)
    kind[~dorsal] = shared_out(shares, int((~dorsal).sum()))
    kind[dorsal] = 3 + shared_out([1, 1, 1], int(dorsal.sum()))
    return with_receptors(eye, types, sets, kind)
