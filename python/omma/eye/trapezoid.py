"""Where a fly's six outer receptors look: a trapezoid of steps of the local lattice of axes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye
from omma.base.arrays import Floats, Ints
from omma.base.directions import normalized
from omma.eye.neighbours import direction_lattice

# Rhabdomeres R1 to R6 about R7, in steps along two rows of the lattice: "anterior and dorsal" and
# "dorsal". Of the dorsal half of an eye; the ventral half is its mirror image. R1, R2, R3 lie in a
# row on the anterior side and R3 at the dorsal tip, so that R4 is dorsal, R5 and R6 posterior.
TRAPEZOID = {"R1": (1, -1), "R2": (1, 0), "R3": (1, 1), "R4": (0, 1), "R5": (-1, 1), "R6": (-1, 0)}


def trapezoid_offsets(eye: Eye, dorsal: NDArray[np.bool_]) -> Floats:
    """Where R1 to R6 look: (N, 6, 2), to the ommatidium's right and up, rad."""
    axes = normalized(eye.axis.astype(np.float64))
    # A frame that does not depend on the up vectors: towards the zenith, and what is right of it.
    north = np.array([0.0, 1.0, 0.0]) - axes * axes[:, 1:2]
    steep = np.linalg.norm(north, axis=1) < 1e-6
    north[steep] = eye.up[steep]
    north = normalized(north)
    east = np.cross(axes, north)
    # Anterior is left on a right eye, whose axes point to +x, and right on a left one.
    left_eye = np.zeros(len(eye), bool)
    for number in np.unique(eye.eye_id):
        mine = eye.eye_id == number
        left_eye[mine] = axes[mine, 0].mean() < 0
    rows = _lattice_rows(eye, axes, north, east, np.where(left_eye, -1.0, 1.0))
    # rows[:, k] is the row nearest to 30 + 60 k degrees, from east towards north: 1 is dorsal.
    forward = np.where(left_eye, 0, 2)
    backward_down = np.where(left_eye, 5, 3)  # the anterior row below the horizon
    one = np.arange(len(eye))
    anterior = np.where(dorsal[:, None], rows[one, forward], rows[one, backward_down])
    polar = np.where(dorsal[:, None], rows[one, 1], rows[one, 4])
    up, right = eye.up.astype(np.float64), eye.right.astype(np.float64)
    offsets = np.empty((len(eye), len(TRAPEZOID), 2))
    for k, (a, b) in enumerate(TRAPEZOID.values()):
        # The lens inverts: what lies anterior looks posterior.
        looking = -(a * anterior + b * polar)
        vector = looking[:, :1] * east + looking[:, 1:] * north
        offsets[:, k, 0] = np.sum(vector * right, axis=1)
        offsets[:, k, 1] = np.sum(vector * up, axis=1)
    return offsets


def _lattice_rows(eye: Eye, axes: Floats, north: Floats, east: Floats, side: Floats) -> Floats:
    """The six steps of the lattice of axes around each ommatidium: (N, 6, 2), east and north, rad.

    Fitted to its neighbours as the steps of a lattice, so that opposite ones are each other's
    negative. In the middle of each eye row k is the one at 30 + 60 k degrees from east, up to 45°
    more or 15° less on right eyes (side 1), and the mirror image of that on left ones (-1): so a
    lattice with rows along the horizon and none along the meridian is clear, too. From there rows
    go on from neighbour to neighbour, however the lattice turns.
    """
    lattice = direction_lattice(axes, eye.eye_id)
    pairs = np.concatenate([lattice.pairs, lattice.pairs[:, ::-1]])
    one, other = pairs.T
    cosine = np.sum(axes[one] * axes[other], axis=1)
    sine = np.sqrt(np.maximum(1 - cosine**2, 1e-30))
    angle = np.arctan2(sine, cosine) / sine
    step = np.empty((len(pairs), 2))
    step[:, 0] = angle * np.sum(axes[other] * east[one], axis=1)
    step[:, 1] = angle * np.sum(axes[other] * north[one], axis=1)
    if len(pairs) == 0:
        raise Error(f"{eye.path or 'eye'}: expected at least four ommatidia, found {len(eye)}")
    # The direction of row 0 by the sixfold pattern, within 30 degrees of the middle of its range.
    middle = np.radians(30 + 15 * side)
    z = step[:, 0] + 1j * step[:, 1]
    wave = np.zeros(len(axes), complex)
    np.add.at(wave, one, (z / np.abs(z)) ** 6)
    phase = np.angle(wave * np.exp(-6j * middle)) / 6 + middle
    phase = _continuous(phase, pairs, axes, north, east)
    which = np.rint((np.angle(z) - phase[one]) / (np.pi / 3)).astype(int) % 6
    # Least squares of z = a e0 + b e1 with (a, b) the lattice coordinates of the six steps.
    coordinates = np.array([[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]], np.float64)
    normal = np.zeros((len(axes), 2, 2))
    both = np.zeros((len(axes), 2, 2))
    c = coordinates[which]
    np.add.at(normal, one, c[:, :, None] * c[:, None, :])
    np.add.at(both, one, c[:, :, None] * step[:, None, :])
    # Where neighbours are too few, a regular hexagon of their mean distance.
    spacing = np.zeros(len(axes))
    count = np.bincount(one, minlength=len(axes))
    np.add.at(spacing, one, np.abs(z))
    spacing /= np.maximum(count, 1)
    regular = phase[:, None] + np.radians([0, 60])
    hexagon = spacing[:, None, None] * np.stack([np.cos(regular), np.sin(regular)], axis=-1)
    sound = np.linalg.det(normal) > 0.5
    basis = hexagon
    basis[sound] = np.linalg.solve(normal[sound], both[sound])
    return np.asarray(np.einsum("kc,ncd->nkd", coordinates, basis))


def _continuous(phase: Floats, pairs: Ints, axes: Floats, north: Floats, east: Floats) -> Floats:
    """Directions known but for sixths of a turn, made to agree between neighbours, (N,), rad.

    From the ommatidium in the middle of each connected component outwards.
    """
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    one, other = pairs.T
    count = len(axes)
    graph = csr_matrix((np.ones(len(pairs)), (one, other)), shape=(count, count))
    phase = phase.copy()
    components, labels = connected_components(graph, directed=False)
    for component in range(components):
        members = np.flatnonzero(labels == component)
        start = members[np.argmax(axes[members] @ axes[members].sum(axis=0))]
        order, before = breadth_first_order(graph, start, directed=False)
        to, origin = order[1:], before[order[1:]]
        # East of the one before, carried along the great circle to the next.
        seen = np.sum(east[origin] * axes[to], axis=1) / (
            1 + np.sum(axes[origin] * axes[to], axis=1)
        )
        carried = east[origin] - seen[:, None] * (axes[origin] + axes[to])
        turn = np.arctan2(np.sum(carried * north[to], axis=1), np.sum(carried * east[to], axis=1))
        for i, p, t in zip(to.tolist(), origin.tolist(), turn.tolist(), strict=True):
            phase[i] += np.pi / 3 * round((phase[p] + t - phase[i]) / (np.pi / 3))
    return phase
