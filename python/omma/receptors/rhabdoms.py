"""How the photoreceptors of an ommatidium share the light that its lens throws on them."""

from __future__ import annotations

import numpy as np

from omma._core import Acceptance, Eye
from omma.base.arguments import checked
from omma.base.arrays import Floats
from omma.receptors.sensitivity import ommatidium_of_receptor


@checked
def rhabdom_share(eye: Eye) -> Floats:
    """The share of its rhabdom's cross-section that each receptor has: (R,).

    Receptors of an ommatidium that look the same way, with the same acceptance, are cells of one
    fused rhabdom, alike in cross-section: each of n has 1/n, and all of them together catch no more
    than what enters. Those that look beside it, as flies' R1-6, have a rhabdomere of their own.
    Cells one behind the other, as flies' R7 and R8, are not told from cells side by side: they have
    half each, where the first one has all and the second what it leaves.

    Example:
        >>> bee = omma.species.honeybee_worker().eye
        >>> omma.receptors.rhabdom_share(bee)[:3]  # of eight
        array([0.125, 0.125, 0.125])
    """
    fields: dict[tuple[float, float, Acceptance | None], int] = {}
    of_type = np.array(
        [
            fields.setdefault((one.right_rad, one.up_rad, one.acceptance), len(fields))
            for one in eye.receptor_types
        ],
        np.int64,
    )
    places = ommatidium_of_receptor(eye) * len(fields) + of_type[eye.receptor_type]
    _, which, count = np.unique(places, return_inverse=True, return_counts=True)
    return np.asarray(1 / count[which])
