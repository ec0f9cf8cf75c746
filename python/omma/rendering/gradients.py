"""Methods of `omma.Renderer`: how responses change with the eye and with where the head looks.

The scene does not depend on the eye. With the sensitivity as a density p(ω; θ) over directions,

    r = ∫ p L dω,    ∂r/∂θ = ∫ p (∂ ln p / ∂θ) L dω = E[(L − b) ∂ ln p / ∂θ],

so that the rays that a response is the mean of give its derivative as well, by other weights, edges
and all (the likelihood ratio method: Glynn 1990, doi:10.1145/84537.84552). The control variate b
changes nothing in the mean, as that of ∂ ln p / ∂θ is 0; it is the response by other, independent
rays, which keeps the estimate unbiased. What responses have beside their rays, as the
sun's disc, comes with the moments that its derivatives are made of.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, expect, one_of, whole
from omma.base.arrays import Floats
from omma.base.methods import method_of
from omma.base.progress import Progress, share_of
from omma.base.values import value_class
from omma.rendering.call import Call, Poses, Prepared, Responses, poses_of
from omma.rendering.gaussian_scores import PARAMETERS, Moments, Parameter, scores_of, slopes_of
from omma.rendering.settings import Fixed, fixed_samples

# How derivatives (P, N, C[, 3]) and a change of the parameter make a change of responses.
ALONG: dict[Parameter, str] = {
    "acceptance_angle_rad": "pnc,n->pnc",
    "axis": "pnci,ni->pnc",
    "rotation_rad": "pnci,pi->pnc",
}

# Independent estimates, whose spread is the error, as of standard errors (error_scrambles).
_ESTIMATES = 8
# Of what is kept of rays at once.
_MOST_BYTES = 1 << 28


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Jacobian:
    """Responses at P poses, and their derivatives.

    Attributes:
        responses: (P, N, C), the mean of all rays.
        values: by parameter, (P, N, C) for ``acceptance_angle_rad``, per rad; (P, N, C, 3) for
            ``axis``, in the head's frame, across the axis, and for ``rotation_rad``, in the
            world's. What ommatidium i does depends on its own width and axis alone.
        errors: their standard errors, of the same shapes.
    """

    responses: Responses
    values: dict[Parameter, Floats]
    errors: dict[Parameter, Floats]

    @checked
    def jvp(self, tangents: Mapping[Parameter, ArrayLike]) -> Floats:
        """(P, N, C): how responses change where parameters do by these: (N,) or a number, rad, for
        ``acceptance_angle_rad``; (N, 3) for ``axis``; (P, 3) or (3,), rad, for ``rotation_rad``.

        Raises:
            omma.Error: a parameter that this has no derivatives by, another shape, numbers that
                are not finite.
        """
        poses, ommatidia, _ = self.responses.shape
        change = np.zeros(self.responses.shape)
        for name, tangent in _tangents(tangents, poses, ommatidia).items():
            change += np.einsum(ALONG[name], self._value(name), tangent)
        return change

    @checked
    def vjp(self, cotangent: ArrayLike) -> dict[Parameter, Floats]:
        """By parameter, the gradient of a number of which ``cotangent`` (P, N, C) is the gradient
        by responses: (N,) for ``acceptance_angle_rad``, (N, 3) for ``axis``, (P, 3) for
        ``rotation_rad``.

        Raises:
            omma.Error: another shape, a cotangent that is not finite.
        """
        weights = array_of(cotangent, "cotangent", self.responses.shape, finite=True)
        summed = {"acceptance_angle_rad": "pnc,pnc->n", "axis": "pnc,pnci->ni"}
        return {
            name: np.einsum(summed.get(name, "pnc,pnci->pi"), weights, value)
            for name, value in self.values.items()
        }

    def _value(self, name: Parameter) -> Floats:
        if name not in self.values:
            raise Error(f"{name}: expected one of {', '.join(self.values)}")
        return self.values[name]


def _tangents(
    tangents: Mapping[Parameter, ArrayLike], poses: int, ommatidia: int
) -> dict[Parameter, Floats]:
    """Changes of parameters, each of its whole shape."""
    expect(tangents, Mapping, "tangents", "a dictionary of changes by parameter")
    size: dict[str, tuple[int, ...]] = {
        "acceptance_angle_rad": (ommatidia,),
        "axis": (ommatidia, 3),
        "rotation_rad": (poses, 3),
    }
    found = {}
    for name, value in tangents.items():
        rows = size[one_of(name, PARAMETERS, "tangents")]
        given = array_of(value, name, [rows, rows[1:]], finite=True)  # each row's, or one
        found[name] = np.broadcast_to(given, rows)
    return found


@checked
@method_of("omma.rendering.renderer", "Renderer")
def jacobian(
    self: Prepared,
    poses: Poses,
    *,
    by: Parameter | Sequence[Parameter] = PARAMETERS,
    first_pose: int = 0,
    progress: Progress | None = None,
) -> Jacobian:
    """Responses and their derivatives by the eye's widths and axes and by the head's rotation.

    As many rays as of the renderer's ``Fixed`` are taken, but for what is left over an eighth, in
    eight independent estimates, at least one in each; the same numbers for the same ``first_pose``,
    whatever the noise of the renderer.
    The world may have any edges, and be lit. What textures lose by the footprints of rays is taken
    as it is: it does not count as a change with the width.

    Args:
        poses: as in `render`.
        by: which derivatives: ``acceptance_angle_rad``; ``axis``, of the unit vectors in the
            head's frame; ``rotation_rad``, of a turn of the head about each axis of the world, as
            if about each ommatidium's own place: what it moves by, edges in their distance show,
            and is left out.
        first_pose: another number, up to 2⁶⁰ less the number of poses, takes other rays.
        progress: called with the finished share (0 to 1).

    Example:
        >>> eye = omma.eye.generate_eye(20)
        >>> renderer = omma.Renderer(omma.scene.box(), eye, omma.Fixed(64))
        >>> found = renderer.jacobian(np.eye(4), by="acceptance_angle_rad")
        >>> found.values["acceptance_angle_rad"].shape
        (1, 20, 3)

    Raises:
        omma.Error: rays that are not `Fixed`, ommatidia that are not round Gaussians
            of a width above 0, frames that last, or what `render` raises.
    """
    if not isinstance(by, Iterable):  # a text is one
        known, found = ", ".join(PARAMETERS), f"{type(by).__name__} {by!r:.40}"
        raise TypeError(f"by: expected some of {known}, found {found}")
    names = (by,) if isinstance(by, str) else tuple(by)
    for name in names:
        one_of(name, PARAMETERS, "by")
    samples = expect_differentiable(self)
    matrices = poses_of(self, poses)
    first_pose = expect_first_pose(first_pose, len(matrices))
    of_each = max(1, samples // _ESTIMATES)
    seen_by = self.with_eye(self.eye, Fixed(of_each), noise="new_every_frame")
    size = (len(matrices), len(self.eye), self.bands)
    shapes = {name: size if name == "acceptance_angle_rad" else (*size, 3) for name in names}
    found = Jacobian(
        np.empty(size, np.float32),
        {name: np.empty(shape) for name, shape in shapes.items()},
        {name: np.empty(shape) for name, shape in shapes.items()},
    )
    rays = _ESTIMATES * of_each * len(self.eye)
    at_once = max(1, _MOST_BYTES // (4 * rays * (3 + self.bands)))
    for start in range(0, len(matrices), at_once):
        some = slice(start, min(start + at_once, len(matrices)))
        first = _ESTIMATES * (first_pose + start)
        part = share_of(progress, start / len(matrices), some.stop / len(matrices))
        traced = _trace(seen_by, matrices[some], first, part)
        _weigh(self.eye, matrices[some], traced, found, some)
    return found


@checked
@method_of("omma.rendering.renderer", "Renderer")
def jvp(
    self: Prepared,
    poses: Poses,
    tangents: Mapping[Parameter, ArrayLike],
    *,
    first_pose: int = 0,
    progress: Progress | None = None,
) -> tuple[Responses, Floats]:
    """Responses (P, N, C), and how they change where parameters do: `Jacobian.jvp` of `jacobian`,
    which has the errors.

    Args:
        poses: as in `render`.
        tangents: by parameter, by how much it changes.
        first_pose, progress: as in `jacobian`.

    Raises:
        omma.Error: another parameter or shape, which is told before rays are traced; what
            `jacobian` raises.
    """
    _tangents(tangents, len(poses_of(self, poses)), len(self.eye))
    found = jacobian(self, poses, by=tuple(tangents), first_pose=first_pose, progress=progress)
    return found.responses, found.jvp(tangents)


@checked
@method_of("omma.rendering.renderer", "Renderer")
def vjp(
    self: Prepared,
    poses: Poses,
    cotangent: ArrayLike,
    *,
    by: Parameter | Sequence[Parameter] = PARAMETERS,
    first_pose: int = 0,
    progress: Progress | None = None,
) -> tuple[Responses, dict[Parameter, Floats]]:
    """Responses (P, N, C), and gradients of a number by the parameters: `Jacobian.vjp` of
    `jacobian`, which has the errors.

    Args:
        poses: as in `render`.
        cotangent: (P, N, C), the number's gradient by responses.
        by: which parameters.
        first_pose, progress: as in `jacobian`.

    Raises:
        omma.Error: a cotangent of another shape, which is told before rays are traced; what
            `jacobian` raises.
    """
    shape = (len(poses_of(self, poses)), len(self.eye), self.bands)
    weights = array_of(cotangent, "cotangent", shape, finite=True)
    found = jacobian(self, poses, by=by, first_pose=first_pose, progress=progress)
    return found.responses, found.vjp(weights)


def expect_first_pose(first_pose: int, poses: int) -> int:
    """The number of the first of so many poses, each of which has the frames of its estimates;
    omma.Error where there are none of it."""
    return whole(first_pose, "first_pose", 0, (1 << 63) // _ESTIMATES - max(poses, 1))


def expect_differentiable(renderer: Prepared, *, own_widths: bool = True) -> int:
    """How many rays there are for each ommatidium of a renderer whose responses have derivatives;
    omma.Error says why they have none.

    Args:
        own_widths: False: ommatidia are to become round Gaussians of other widths.
    """
    eye, settings = renderer.eye, renderer.settings
    samples = fixed_samples(settings.sampling, "a Jacobian")
    if settings.impulse_response is not None:
        raise Error("impulse_response: expected frames that do not last")
    own = settings.angular_sensitivity == "own"
    if not own and settings.angular_sensitivity != "gaussian":
        raise Error(
            "angular_sensitivity: expected Gaussians, whose density has derivatives everywhere, "
            f"found {settings.angular_sensitivity}"
        )
    if not own_widths:
        return samples
    round_ones = _are_round_gaussians(eye) if own else np.ones(len(eye), bool)
    wrong = np.flatnonzero(~(round_ones & (eye.acceptance_angle_rad > 0)))
    if len(wrong):
        raise Error(
            f"eye: expected round Gaussians of a width above 0; {len(wrong):,} ommatidia are none, "
            f"the first {wrong[0]}"
        )
    return samples


def _are_round_gaussians(eye: Eye) -> NDArray[np.bool_]:
    """(N,): of their own angular sensitivities."""
    is_round = [
        one.kernel == "gaussian" and one.minor_width_rad in (0, one.width_parameter_rad)
        for one in eye.acceptances
    ]
    found: NDArray[np.bool_] = np.array([*is_round, True])[eye.acceptance_of]  # the last: none
    return found


@dataclass(frozen=True)
class _Traced:
    """What estimates at some poses are made of."""

    light: NDArray[np.float32]
    """(P, estimate, N, sample, C), radiance of rays."""
    directions: NDArray[np.float32]
    """(P, estimate, N, sample, 3), where they look, in the world."""
    beside: Floats
    """(P, estimate, N, 5, C), what is seen beside the rays, and its moments (omma/render.h)."""


def _trace(
    renderer: Prepared, poses: Floats, first_frame: int, progress: Progress | None
) -> _Traced:
    repeated = np.ascontiguousarray(np.repeat(poses, _ESTIMATES, axis=0))
    call = Call.of(renderer, repeated, {}, first_frame, progress)
    rays = (*call.size, fixed_samples(renderer.settings.sampling, "a Jacobian"))
    radiance = np.empty((*rays, renderer.bands), np.float32)
    beside = call.new_beside()
    call.render(call.new_frames(), ray_radiance=radiance, beside_rays=beside)
    directions = np.empty((*rays, 3), np.float32)
    renderer._engine.ray_directions(repeated, first_frame, directions)
    shape = (len(poses), _ESTIMATES)
    return _Traced(
        radiance.reshape(*shape, *radiance.shape[1:]),
        directions.reshape(*shape, *directions.shape[1:]),
        beside.reshape(*shape, *beside.shape[1:]).astype(np.float64),
    )


def _weigh(eye: Eye, poses: Floats, traced: _Traced, found: Jacobian, rows: slice) -> None:
    """Fill those poses of a Jacobian, some ommatidia at a time."""
    samples, bands = traced.light.shape[3:]
    of_each = 8 * len(poses) * _ESTIMATES * samples * (20 + bands)
    at_once = max(1, _MOST_BYTES // of_each)
    for start in range(0, len(eye), at_once):
        some = np.arange(start, min(start + at_once, len(eye)))
        seen = traced.light[:, :, some]
        each = seen.mean(axis=3, dtype=np.float64)  # (P, estimate, N, C)
        others = (each.sum(axis=1, keepdims=True) - each) / (_ESTIMATES - 1)
        above = seen - others[:, :, :, None, :]
        beside = traced.beside[:, :, some]
        found.responses[rows, some] = (each + beside[:, :, :, 0]).mean(axis=1)
        looking = eye.axis[some], eye.acceptance_angle_rad[some]
        moments = Moments(
            beside[:, :, :, 0], beside[:, :, :, 1], np.moveaxis(beside[:, :, :, 2:], 3, -1)
        )
        of_beside = slopes_of(looking, poses, moments, found.values)
        scores = scores_of(looking, poses, traced.directions[:, :, some], found.values)
        for name, score in scores.items():
            estimate = np.einsum("pensc,pens...->penc...", above, score, optimize=True) / samples
            estimate += of_beside[name]
            found.values[name][rows, some] = estimate.mean(axis=1)
            spread = estimate.std(axis=1, ddof=1) / np.sqrt(_ESTIMATES)
            found.errors[name][rows, some] = spread
