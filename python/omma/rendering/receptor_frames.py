"""A method of `omma.Renderer`: responses of receptors, mixed of the bands or of Stokes vectors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, Protocol, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, output_array
from omma.base.arrays import Floats, Ints, new_floats
from omma.base.card_arrays import OnCard
from omma.base.progress import Progress, share_of
from omma.receptors.catches import type_polarisation
from omma.rendering.call import Call, Frames, Poses, Prepared, Responses
from omma.rendering.moves import MovesOptions, renderer_method
from omma.rendering.receptor_views import ReceptorViews
from omma.rendering.without_polarisation import tell_without_polarisation
from omma.scene.world import World

if TYPE_CHECKING:
    from typing_extensions import Unpack


# Bytes of radiance held at once while it becomes receptors' responses.
_CHUNK_BYTES = 32 << 20
# Mixtures of bands whose estimates are made in one render.
_MOST_MIXTURES = 64


class Weighed(Protocol):
    """What weights need of `omma.Renderer` or `omma.Population`."""

    @property
    def world(self) -> World: ...
    @property
    def eye(self) -> Eye: ...
    @property
    def bands(self) -> int: ...
    def _receptor_views(self) -> tuple[ReceptorViews, Any]: ...


@overload
def render_receptors(
    self: Prepared,
    poses: Poses,
    *,
    matrix: ArrayLike | None = None,
    ultraviolet: ArrayLike | None = None,
    standard_error: Literal[False] = False,
    out: Responses | None = None,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> Responses: ...


@overload
def render_receptors(
    self: Prepared,
    poses: Poses,
    *,
    matrix: ArrayLike | None = None,
    ultraviolet: ArrayLike | None = None,
    standard_error: Literal[True],
    out: Responses | None = None,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> tuple[Responses, Responses]: ...


@checked
@renderer_method
def render_receptors(
    self: Prepared,
    poses: Poses,
    *,
    matrix: ArrayLike | None = None,
    ultraviolet: ArrayLike | None = None,
    standard_error: bool = False,
    out: Responses | None = None,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> Responses | tuple[Responses, Responses]:
    """What the eye's receptors answer, (P, R): float32, linear, never clipped.

    Receptors come in the order of ``eye.receptor_type``. Those that look where their ommatidium
    looks share its rays, and cost next to nothing; one beside the axis, or with an acceptance
    of its own, costs as much as an ommatidium. RGB becomes responses through a matrix of types
    and channels (docs/receptors.md). RGB says nothing of ultraviolet, so there is none, unless
    ``ultraviolet`` or ``matrix`` says otherwise.

    Args:
        matrix: (T, C), weights of the bands, which are red, green and blue unless the world has
            others, for each of ``eye.receptor_types``; None takes `receptor_matrix`.
        ultraviolet: light below 400 nm: "dark", "as_blue" or a mix of the channels (3,), see
            `receptor_matrix`.
        standard_error: return (responses, errors): those of each receptor's own estimates, as
            in `render`.
        poses, out, first_pose, progress: as in `render`.
        instances, transforms, times_s, animation: as in `render`.

    Raises:
        omma.Error: an eye without receptors, a type without a sensitivity, a wrong shape, no
            matrix in a world whose bands are not RGB.

    Warns:
        UserWarning: receptors tell directions of polarisation, and the light is polarised but the
            world is not (once a session).
    """
    call = Call.of(self, poses, moves, first_pose, progress)
    tell_without_polarisation(self.world, self._receptor_views()[0].most_polarisation)
    target = output_array(out, (len(call.poses), len(self.eye.receptor_type)), "out")
    if not isinstance(target, OnCard):
        return frames_of_receptors(call, matrix, ultraviolet, standard_error, target).returned
    frames = frames_of_receptors(call, matrix, ultraviolet, standard_error)
    target.write(frames.responses)
    return replace(frames, responses=target.value).returned


def frames_of_receptors(
    call: Call,
    matrix: ArrayLike | None,
    ultraviolet: ArrayLike | None,
    standard_error: bool,
    out: Responses | None = None,
) -> Frames:
    """Responses (P, R) of a call; other arguments as of `render_receptors`."""
    eye = call.renderer.eye
    views, renderer = call.renderer._receptor_views()
    weights = weights_of(call.renderer, matrix, ultraviolet)
    shape = (len(call.poses), len(eye.receptor_type))
    responses = new_floats(shape) if out is None else out
    errors = new_floats(shape) if standard_error else None
    seen = replace(call, renderer=renderer)
    if errors is None and not call.renderer.world.polarized:
        # One render of all bands serves all types.
        for piece, which in _pieces(seen, call.renderer.bands):
            radiance = piece.render(piece.new_frames()).responses[:, views.view_of_receptor]
            responses[which] = np.einsum("prb,rb->pr", radiance, weights[eye.receptor_type])
        return Frames(responses)
    # Errors are those of the receptors' own estimates, for some mixtures at a time.
    mixtures = Mixtures(weights, eye.receptor_type)
    for piece, which in _pieces(seen, mixtures.most_at_once):
        for told, group, those, one in mixtures.groups(piece.progress):
            frames = replace(piece, progress=told).render(
                piece.new_frames(len(group), standard_error=standard_error),
                output_from_band=group,
            )
            view = views.view_of_receptor[those]
            responses[which, those] = frames.responses[:, view, one]
            if errors is not None and frames.standard_error is not None:
                errors[which, those] = frames.standard_error[:, view, one]
    return Frames(responses, errors)


class Mixtures:
    """What an eye's receptors make of the bands: mixtures of which no two are alike. An eye may
    have thousands of types, as a fly's that each look their own way, of few sensitivities.

    Args:
        weights: (T, components x bands), of each type; those that no receptor has count too, so
            that the eyes of a population are asked for what each is alone.
        kinds: (R,), the type of each receptor.
    """

    def __init__(self, weights: Floats, kinds: NDArray[np.integer]) -> None:
        _, first, of_type = np.unique(weights, axis=0, return_index=True, return_inverse=True)
        # In the order of the types.
        order = np.argsort(first)
        of_receptor = np.argsort(order)[of_type.reshape(-1)][kinds]
        self.most_at_once = min(len(first), _MOST_MIXTURES)
        self._groups = []
        for start in range(0, len(first), _MOST_MIXTURES):
            group = np.ascontiguousarray(weights[first[order[start : start + _MOST_MIXTURES]]])
            those = np.flatnonzero((of_receptor >= start) & (of_receptor < start + len(group)))
            if len(those):
                self._groups.append((group, those, of_receptor[those] - start))

    def groups(
        self, progress: Progress | None
    ) -> Iterator[tuple[Progress | None, Floats, Ints, Ints]]:
        """Some of them at a time, where there are receptors of them: their share of the progress,
        their weights, which receptors, and which of them each of those has."""
        for k, group in enumerate(self._groups):
            yield share_of(progress, k / len(self._groups), (k + 1) / len(self._groups)), *group


def _pieces(call: Call, outputs: int) -> Iterator[tuple[Call, slice]]:
    """Calls for as many poses as memory is to hold these outputs of, and which poses they are."""
    chunk = max(1, _CHUNK_BYTES // (len(call.renderer.eye) * outputs * 4))
    for start in range(0, len(call.poses), chunk):
        yield call.piece(start, chunk), slice(start, start + chunk)


def weights_of(
    renderer: Weighed, matrix: ArrayLike | None, ultraviolet: ArrayLike | None
) -> Floats:
    """Weights of bands for each type, [type, band]; in a polarised world those of I, Q and U."""
    eye = renderer.eye
    if matrix is None:
        if renderer.world.band_from_rgb is not None:
            raise Error(
                "matrix: expected one [type, band], as this world's bands are not RGB "
                "(receptor_matrix makes it of their edges), found None"
            )
        views, _ = renderer._receptor_views()
        weights = views.matrix(renderer.world.light, ultraviolet)
    elif ultraviolet is not None:
        raise Error("ultraviolet: is for the matrix that is made here; not together with matrix")
    else:
        weights = np.ascontiguousarray(array_of(matrix, "matrix"))
        expected = (len(eye.receptor_types), renderer.bands)
        if weights.shape != expected or not np.all(np.isfinite(weights)):
            raise Error(
                f"matrix: expected numbers [type, band] of shape {expected}, found "
                f"{weights.shape}"
                + ("" if weights.shape != expected else ", not all of them finite")
            )
    return _with_polarisation(eye, weights) if renderer.world.polarized else weights


def _with_polarisation(eye: Eye, weights: Floats) -> Floats:
    """Weights [type, band] as [type, component x band]: how microvilli weight I, Q and U."""
    modulation, angle = type_polarisation(eye)
    components = [
        np.ones(len(angle)),
        modulation * np.cos(2 * angle),
        modulation * np.sin(2 * angle),
    ]
    return np.concatenate([one[:, None] * weights for one in components], axis=1)
