"""Responses of receptors, whose views beside their ommatidia's axes are an eye of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import output_array
from omma.receptors.catches import type_polarisation
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_matrix
from omma.rendering.moves import MovesOptions
from omma.rendering.settings import frame_number

if TYPE_CHECKING:
    from omma.rendering.renderer import Poses, Progress, Renderer

Floats = NDArray[np.float64]
Responses = NDArray[np.float32]

# Bytes of radiance held at once while it becomes receptors' responses.
_CHUNK_BYTES = 32 << 20
# Types whose estimates are made in one render.
_MOST_TYPES = 64


class ReceptorViews:
    """What a renderer needs for its eye's receptors: who renders their views, whose is which."""

    def __init__(self, renderer: Renderer) -> None:
        eye = renderer.eye
        if len(eye.receptor_type) == 0:
            raise Error(f"{eye.path or 'eye'}: expected ommatidia with receptors, found none")
        types = eye.receptor_types
        used = [types[t] for t in np.unique(eye.receptor_type)]
        if all(t.right_rad == 0 and t.up_rad == 0 and t.acceptance is None for t in used):
            self.renderer = renderer
            self.view_of_receptor = ommatidium_of_receptor(eye).astype(np.int32)
        else:
            views, self.view_of_receptor = _core.receptor_views(eye)
            self.renderer = renderer.with_eye(views)
        self._matrices: dict[tuple[float, ...] | None, Floats] = {}

    def matrix(self, eye: Eye, ultraviolet: ArrayLike | None) -> Floats:
        """`receptor_matrix` of the eye, made once: of RGB, or in a lit world of its bands."""
        key = None if ultraviolet is None else tuple(np.ravel(ultraviolet).tolist())
        if key not in self._matrices:
            light = self.renderer.world.light
            self._matrices[key] = (
                receptor_matrix(eye, ultraviolet)
                if light is None
                else receptor_matrix(eye, ultraviolet, bands=light.bands)
            )
        return self._matrices[key]


def _with_polarisation(eye: Eye, weights: Floats) -> Floats:
    """Weights [type, band] as [type, component x band]: how microvilli weight I, Q and U."""
    modulation, angle = type_polarisation(eye)
    components = [
        np.ones(len(angle)),
        modulation * np.cos(2 * angle),
        modulation * np.sin(2 * angle),
    ]
    return np.concatenate([one[:, None] * weights for one in components], axis=1)


def render_receptors(
    renderer: Renderer,
    views: ReceptorViews,
    poses: Poses,
    matrix: ArrayLike | None,
    ultraviolet: ArrayLike | None,
    standard_error: bool,
    out: Responses | None,
    first_pose: int | None,
    progress: Progress | None,
    moves: MovesOptions,
) -> Responses | tuple[Responses, Responses]:
    """What `Renderer.render_receptors` does, whose arguments these are."""
    eye = renderer.eye
    if matrix is None:
        if renderer.world.band_from_rgb is not None:
            raise Error(
                "matrix: expected one [type, band], as this world's bands are not RGB "
                "(receptor_matrix makes it of their edges), found None"
            )
        weights = views.matrix(eye, ultraviolet)
    elif ultraviolet is not None:
        raise Error("ultraviolet: is for the matrix that is made here; not together with matrix")
    else:
        weights = np.ascontiguousarray(matrix, np.float64)
        expected = (len(eye.receptor_types), renderer.bands)
        if weights.shape != expected or not np.all(np.isfinite(weights)):
            raise Error(
                f"matrix: expected numbers [type, band] of shape {expected}, found "
                f"{weights.shape}"
                + ("" if weights.shape != expected else ", not all of them finite")
            )
    polarized = renderer.world.polarized
    if polarized:
        weights = _with_polarisation(eye, weights)
    matrices = renderer._matrices(poses)
    first = frame_number(first_pose)
    moving = renderer._moves(matrices, moves)
    shape = (len(matrices), len(eye.receptor_type))
    responses = output_array(out, shape, "out")
    errors = np.empty(shape, np.float32) if standard_error else None
    # Errors are those of the receptors' own estimates, for some types at a time.
    groups = [weights[k : k + _MOST_TYPES] for k in range(0, len(weights), _MOST_TYPES)]
    # With polarisation or errors each type is rendered by itself; else one render of I in all bands
    # serves all.
    by_type = polarized or errors is not None
    passes = len(groups) if by_type else 1
    wide = min(len(weights), _MOST_TYPES) if by_type else renderer.bands
    chunk = max(1, _CHUNK_BYTES // (len(views.renderer.eye) * wide * 4))
    for start in range(0, len(matrices), chunk):
        piece = matrices[start : start + chunk]
        number = None if first is None else first + start
        here = moving.piece(start, len(piece))
        for k in range(passes):

            def report(
                done: float,
                before: float = start + k / passes * len(piece),
                size: float = len(piece) / passes,
            ) -> None:
                assert progress is not None
                progress((before + done * size) / len(matrices))

            tell = None if progress is None else report
            into = responses[start : start + chunk]
            if not by_type:
                radiance = views.renderer.render(
                    piece, first_pose=number, progress=tell, **here.options()
                )
                seen = radiance[:, views.view_of_receptor]
                into[...] = np.einsum("prb,rb->pr", seen, weights[eye.receptor_type])
                continue
            found, error = views.renderer._render_outputs(
                piece, groups[k], number, tell, errors is not None, here
            )
            type_in_group = eye.receptor_type - k * _MOST_TYPES
            which = np.flatnonzero((type_in_group >= 0) & (type_in_group < len(groups[k])))
            at = views.view_of_receptor[which], type_in_group[which]
            into[:, which] = found[:, at[0], at[1]]
            if errors is not None and error is not None:
                errors[start : start + chunk, which] = error[:, at[0], at[1]]
    moving.note()
    return responses if errors is None else (responses, errors)
