"""Ommatidia that are in a table twice, nearly: a lens that was marked or digitised two times."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats, Ints
from omma.base.directions import normalized

# In a lattice, however stretched, the nearest is at a third of the distance to the third nearest at
# least, as it is at the end of a row.
_NEAR = 0.2


def doubles(position: Floats, axis: Floats, eye_id: NDArray[np.int32]) -> Ints:
    """The first ommatidium of its eye that each is a double of, -1 where it is none: (N,).

    Two are doubles where they lie and look less than a fifth as far apart as the third nearest in
    position and the third nearest in direction are from either. Exact copies are doubles too, and
    count once. Of fewer than five there are no others.
    """
    first = np.arange(len(position))
    for which in np.unique(eye_id):
        members = np.flatnonzero(eye_id == which)
        rows = np.column_stack([position[members], axis[members]])
        _, index, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        label = index[inverse.reshape(-1)]
        if len(index) >= 5:
            index.sort()
            pairs = _pairs(position[members[index]], normalized(axis[members[index]]))
            for pair in index[pairs]:
                low, high = np.sort(label[pair])
                label[label == high] = low
        first[members] = members[label]
    return np.where(first == np.arange(len(first)), -1, first)


def _pairs(position: Floats, axis: Floats) -> Ints:
    # Pairs of doubles (D, 2), the first with the lower number.
    from scipy.spatial import cKDTree

    apart, near = cKDTree(position).query(position, k=4)
    place = _NEAR * apart[:, 3]
    look = _NEAR * cKDTree(axis).query(axis, k=4)[0][:, 3]
    one, other = np.repeat(np.arange(len(near)), 3), near[:, 1:].ravel()
    pairs = np.unique(np.sort(np.column_stack([one, other]), axis=1), axis=0)
    one, other = pairs.T
    close = np.linalg.norm(position[one] - position[other], axis=1) < np.minimum(
        place[one], place[other]
    )
    alike = np.linalg.norm(axis[one] - axis[other], axis=1) < np.minimum(look[one], look[other])
    return np.asarray(pairs[close & alike & (one != other)])
