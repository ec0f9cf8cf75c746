"""Receptors of many eyes rendered in one call: each eye's are those that it has alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Eye
from omma.base.arrays import Floats, Ints, new_floats
from omma.base.progress import Progress
from omma.rendering.call import Responses
from omma.rendering.receptor_frames import Mixtures, Weighed, weights_of
from omma.rendering.receptor_views import ReceptorViews
from omma.rendering.without_polarisation import tell_without_polarisation

# Of some outputs: (P, N, C) responses, and their errors where asked for.
Filled = tuple[Responses, Responses | None]


def views_of(eye: Eye, sizes: Ints) -> tuple[ReceptorViews, Ints]:
    """Where the receptors look of eyes of so many ommatidia (E,), one behind the other, and how
    many views each has: its own one after the other, as it has them alone."""
    views = ReceptorViews(eye)
    if views.views is None:
        return views, sizes
    made: list[Eye] = []
    own, last = [], 0
    for first, end in zip(np.cumsum(sizes) - sizes, np.cumsum(sizes), strict=True):
        seen, view_of_receptor = _core.receptor_views(eye.take(np.arange(first, end)))
        made.append(seen)
        own.append(view_of_receptor + last)
        last += len(seen)
    views.views = _core.merge_eyes(made)
    views.view_of_receptor = np.concatenate(own)
    return views, np.array([len(one) for one in made])


def receptors_of(
    self: Weighed,
    fill: Callable[[Progress | None, Floats | None], Filled],
    matrix: ArrayLike | None,
    ultraviolet: ArrayLike | None,
    errors: bool,
    progress: Progress | None,
) -> Filled:
    """Responses (P, R) of all receptors, and their errors where asked for.

    Args:
        fill: renders the views; given mixtures of the bands (outputs, components x bands), or None
            for the bands.
        matrix, ultraviolet: as of `Renderer.render_receptors`.
    """
    views, _ = self._receptor_views()
    tell_without_polarisation(self.world, views.most_polarisation)
    weights, kinds = weights_of(self, matrix, ultraviolet), self.eye.receptor_type
    if not errors and not self.world.polarized:
        radiance = fill(progress, None)[0][:, views.view_of_receptor]
        responses = new_floats(radiance.shape[:2])
        responses[...] = np.einsum("prb,rb->pr", radiance, weights[kinds])
        return responses, None
    found: list[NDArray[np.float32]] = []
    for told, group, those, one in Mixtures(weights, kinds).groups(progress):
        view = views.view_of_receptor[those]
        for k, filled in enumerate(fill(told, group)):
            if filled is None:
                continue
            if len(found) == k:
                found.append(new_floats((len(filled), len(kinds))))
            found[k][:, those] = filled[:, view, one]
    return found[0], found[1] if errors else None
