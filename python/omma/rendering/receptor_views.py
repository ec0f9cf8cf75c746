"""Where an eye's receptors look: those beside their ommatidia's axes make an eye of their own."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma import _core
from omma._core import Error, Eye
from omma.base.arrays import Floats
from omma.light import Light
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_matrix


class ReceptorViews:
    """What a renderer needs for its eye's receptors: the eye of their views, and whose is which.

    ``views`` is None where all look where their ommatidia do, so that the eye itself serves.
    ``most_polarisation`` is the largest polarisation sensitivity among them.
    """

    def __init__(self, eye: Eye) -> None:
        if len(eye.receptor_type) == 0:
            raise Error(f"{eye.path or 'eye'}: expected ommatidia with receptors, found none")
        types = eye.receptor_types
        used = [types[t] for t in np.unique(eye.receptor_type)]
        self.most_polarisation = max(t.polarisation_sensitivity for t in used)
        self.views: Eye | None = None
        if all(t.right_rad == 0 and t.up_rad == 0 and t.acceptance is None for t in used):
            self.view_of_receptor = ommatidium_of_receptor(eye).astype(np.int32)
        else:
            self.views, self.view_of_receptor = _core.receptor_views(eye)
        self._eye = eye
        self._matrices: dict[tuple[float, ...] | None, Floats] = {}

    def matrix(self, light: Light | None, ultraviolet: ArrayLike | None) -> Floats:
        """`receptor_matrix` of the eye, made once: of RGB, or in a lit world of its bands."""
        key = None if ultraviolet is None else tuple(np.ravel(ultraviolet).tolist())
        if key not in self._matrices:
            self._matrices[key] = (
                receptor_matrix(self._eye, ultraviolet)
                if light is None
                else receptor_matrix(self._eye, ultraviolet, bands=light.bands)
            )
        return self._matrices[key]
