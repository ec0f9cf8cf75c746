"""Large monopolar cells: the neurons behind photoreceptors that keep what is new, in time and
against the neighbours.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, expect, within
from omma.base.arrays import Floats
from omma.photoreceptors.filters import filter_frames
from omma.photoreceptors.impulse_response import ImpulseResponse

# The hover fly Eristalis tenax in bright light (James 1990, as quoted in J Vis, article 2121186).
_EXCITATION = ImpulseResponse("howard", 10.3e-3, 0.236)
_INHIBITION = ImpulseResponse("howard", 15.6e-3, 0.269)


@checked
def large_monopolar(
    signals: ArrayLike,
    frame_rate_hz: float,
    neighbours: ArrayLike,
    weights: ArrayLike = 0.1,
    *,
    strength: float = 1.0,
    excitation: ImpulseResponse = _EXCITATION,
    inhibition: ImpulseResponse = _INHIBITION,
) -> Floats:
    """What large monopolar cells make of the contrasts that their ommatidia see: excitation less a
    later inhibition, a share of which comes from the neighbours.

    y_i = h₁ * c_i - strength × h₂ * [(1 - Σw) c_i + Σ_k w_k c_k], with * for convolution in time:
    what is expected from the past and from around is taken away (Srinivasan, Laughlin and Dubs
    1982, Proc R Soc Lond B 216:427). Where a neighbour is missing, its share comes from the cell
    itself, so that an even field gives the same everywhere. Positive for more light; real cells
    hyperpolarise.

    Args:
        signals: (F, N, ...) contrasts, or other signals of which contrast is a linear part; frames,
            then ommatidia. From light to the cell: the default h₁ and h₂ contain the
            photoreceptor.
        frame_rate_hz: frames per second; light goes in straight lines between them.
        neighbours: (N, 6) or (N, K), indices of ommatidia, -1 where there is none, as
            `omma.eye.hexagonal_coordinates` gives them.
        weights: share of the inhibition that comes from each neighbour: a number, or one for each
            of the columns of ``neighbours``; together at most 1. 0: from the cell only.
        strength: of the inhibition; at 1 steady light is taken away entirely.
        excitation: h₁; by default a log-normal with its peak at 10.3 ms and σ 0.236, as James
            (1990) found in *Eristalis tenax* in bright light.
        inhibition: h₂; by default his, with its peak at 15.6 ms and σ 0.269.

    Returns:
        Of the shape of ``signals``, in their unit.

    Raises:
        omma.Error: signals of another number of ommatidia than ``neighbours``, indices that are no
            ommatidia, weights that are negative, more than 1 together or of another number.
    """
    given = array_of(signals, "signals", finite=True)
    if given.ndim < 2 or given.shape[0] == 0:
        raise Error(f"signals: expected shape (frames, ommatidia, ...), found {given.shape}")
    index = array_of(neighbours, "neighbours", (None, None), np.int64)
    count = given.shape[1]
    if len(index) != count:
        raise Error(
            f"neighbours: expected one row for each of {count} ommatidia, found {len(index)}"
        )
    outside = index[(index < -1) | (index >= count)]
    if len(outside):
        raise Error(f"neighbours: expected -1 to {count - 1}, found {outside[0]}")
    share = array_of(weights, "weights")
    if share.shape not in ((), index.shape[1:]):
        raise Error(
            f"weights: expected a number or {index.shape[1]} of them, found shape {share.shape}"
        )
    share = np.broadcast_to(share, index.shape[1:])
    if not (np.all(np.isfinite(share) & (share >= 0)) and np.sum(share) <= 1 + 1e-12):
        raise Error(
            f"weights: expected numbers from 0 on, together at most 1, found {share.tolist()}"
        )
    size = within(strength, "strength", 0.0, 1e6)
    for name, h in (("excitation", excitation), ("inhibition", inhibition)):
        expect(h, ImpulseResponse, name, "omma.photoreceptors.ImpulseResponse.howard makes one")
    around = _around(given, index, share)
    taken = filter_frames(around, frame_rate_hz, inhibition)
    return np.asarray(filter_frames(given, frame_rate_hz, excitation) - size * taken)


def _around(signals: Floats, index: NDArray[np.int64], share: Floats) -> Floats:
    """Weighted means of each ommatidium and its neighbours, in each frame."""
    own = np.arange(len(index))
    around = (1 - np.sum(share)) * signals
    for column, weight in zip(index.T, share):
        around += weight * signals[:, np.where(column < 0, own, column)]
    return around
