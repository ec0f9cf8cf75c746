"""Methods of `omma.Renderer`: responses, Stokes vectors and single rays of frames."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, overload

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import checked, output_array
from omma.base.card_arrays import on_host, returned_of, share_memory
from omma.base.progress import Progress
from omma.rendering.call import Call, Poses, Prepared, Responses
from omma.rendering.moves import MovesOptions, renderer_method
from omma.rendering.report import SamplingReport, report_of
from omma.rendering.settings import ToError, fixed_samples

if TYPE_CHECKING:
    from typing_extensions import Unpack


@overload
def render(
    self: Prepared,
    poses: Poses,
    *,
    standard_error: Literal[False] = False,
    report: Literal[False] = False,
    out: Responses | None = None,
    error_out: None = None,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> Responses: ...


@overload
def render(
    self: Prepared,
    poses: Poses,
    *,
    standard_error: Literal[True],
    report: Literal[False] = False,
    out: Responses | None = None,
    error_out: Responses | None = None,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> tuple[Responses, Responses]: ...


@overload
def render(
    self: Prepared,
    poses: Poses,
    *,
    standard_error: Literal[False] = False,
    report: Literal[True],
    out: Responses | None = None,
    error_out: Responses | None = None,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> tuple[Responses, SamplingReport]: ...


@checked
@renderer_method
def render(
    self: Prepared,
    poses: Poses,
    *,
    standard_error: bool = False,
    report: bool = False,
    out: Responses | None = None,
    error_out: Responses | None = None,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> Responses | tuple[Responses, Responses] | tuple[Responses, SamplingReport]:
    """Responses (P, N, C): float32, linear, never clipped; always three axes.

    The engine writes straight into the array that is returned. Other Python threads run
    meanwhile, and Ctrl-C stops the work within a second.

    Args:
        poses: ``world_from_head``, (P, 4, 4) or (4, 4), m; or a tuple of positions (P, 3), m,
            and quaternions (P, 4) in the order x, y, z, w; or the name of a camera in the
            scene, whose whole transform is the pose, its scale too: with ``times_s`` one for
            each time, where animations have it then (`World.camera_at`), else where it is since
            the last `World.at`. Arrays of other libraries come by DLPack, float64 without a
            copy (docs/closed-loops.md).
        standard_error: return (responses, errors), errors the standard error of each response.
            It comes from 8 independent scrambles, so 8 times the rays are traced and the
            response is their mean; with `ToError` it is estimated from the rays as they
            are. Where all rays miss something it is too small:
            `omma.study.confidence_interval` gives bounds that heed the neighbours.
        report: return (responses, report) with `ToError`: rays spent, estimated
            standard errors, and who did not reach the error, see `SamplingReport`.
        out: a C-contiguous float32 (P, N, C) array of the caller's to write into, NumPy's or
            by DLPack another library's on the CPU; it is what is returned, as NumPy's. Or one
            on a graphics card, which is returned as it is (docs/closed-loops.md).
        error_out: the same for the errors.
        first_pose: with noise="new_every_frame", the number of the first pose's frame, so that
            a sequence rendered in pieces, in whatever order, equals one rendered at once. None:
            frames are counted on from call to call, from 0. With frozen noise it makes no
            difference.
        progress: called with the finished share (0 to 1) a few times a second. What it raises
            ends the render and is raised here.
        instances, transforms: what moves from pose to pose: names or indices of K things, as
            `World.set_transforms` takes them, and where they are at each pose,
            ``world_from_node`` (P, K, 4, 4), m. Afterwards they are back where they were; the
            bits are those of moving and rendering one pose after the other.
        times_s: (P,), s: at each pose all that the scene's animations move is where it is at
            that time, as `World.at` says, and back afterwards. Things that ``instances`` names
            go where ``transforms`` says.
        animation: with ``times_s``, as of `World.at`.
        past: with an impulse response, (poses, times) before the first frame, or with
            ``instances`` (poses, times, transforms), so that a path that is rendered in pieces
            gives what it does at once; before the first of all everything stood still.
        unseen: for each pose None, or the things (a name, an index or several) that its eye
            does not see, as the animal's own body; at most 31 different groups in one call.
            Light meets them all the same: their shadows and mirror images are seen.
        unseen_by_light: True: light does not meet them either, as if they were not there; but
            what was baked, and a shadow map of the sun, have them as they were then.

    Raises:
        omma.Error: a wrong shape, a pose that is not finite or not invertible or at which rays
            would start 1e18 m or more from the scene, no such camera.
        TypeError: ``out`` is no float32 array.
        KeyboardInterrupt: Ctrl-C; ``out`` is then incomplete.

    Warns:
        UserWarning: a pose mirrors or stretches the head, or lies where it would if it were in
            millimetres; with an impulse response frames more than a second apart.
        RuntimeWarning: single precision holds rays and surfaces at one of the poses less than
            a millimetre exactly, as in scenes of tens of kilometres, or by more than 1e-4 of
            the size of a scene that is far away; it says how exactly. Scenes far from the
            world's origin are traced from an origin of their own and lose nothing.
    """
    target = self.settings.sampling
    if report and not isinstance(target, ToError):
        raise Error(f"report: is for renders to an error (omma.ToError), found {target}")
    if report and standard_error:
        raise Error("report: has the standard errors; not together with standard_error")
    with_errors = standard_error or report
    if error_out is not None and not with_errors:
        raise Error("error_out: given, but standard_error is False")
    call = Call.of(self, poses, moves, first_pose, progress)
    shape = (*call.size, self.bands)
    responses = output_array(out, shape, "out")
    errors = output_array(error_out, shape, "error_out") if with_errors else None
    if errors is not None and out is not None and share_memory(errors, responses):
        raise Error("error_out: shares memory with out")
    rays = np.empty(call.size, np.int32) if report else None
    call.render_into(responses, errors, rays)
    returned: Responses = returned_of(responses)
    if errors is None:
        return returned
    if rays is not None and isinstance(target, ToError):
        return returned, report_of(target, on_host(responses), on_host(errors), rays)
    return returned, returned_of(errors)


@overload
def render_stokes(
    self: Prepared,
    poses: Poses,
    *,
    standard_error: Literal[False] = False,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> Responses: ...


@overload
def render_stokes(
    self: Prepared,
    poses: Poses,
    *,
    standard_error: Literal[True],
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> tuple[Responses, Responses]: ...


@checked
@renderer_method
def render_stokes(
    self: Prepared,
    poses: Poses,
    *,
    standard_error: bool = False,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> Responses | tuple[Responses, Responses]:
    """Stokes vectors (P, N, 3, B): I, Q, U of each band, in a polarised world.

    With the angle ψ of the electric vector from the ommatidium's up vector towards its right,
    and the degree of polarisation p, Q = p I cos 2ψ and U = p I sin 2ψ (docs/light.md). The
    mean over the field of view, with each ray's axes turned with it from the ommatidium's.

    Args:
        poses, standard_error, first_pose, progress: as in `render`.
        instances, transforms, times_s, animation: as in `render`.

    Raises:
        omma.Error: the world is not polarised, or what `render` raises.
    """
    call = Call.of(self, poses, moves, first_pose, progress)
    frames = call.render(
        call.new_frames(3 * self.bands, standard_error=standard_error), stokes=True
    )
    by_component = (*call.size, 3, self.bands)
    responses = frames.responses.reshape(by_component)
    if frames.standard_error is None:
        return responses
    return responses, frames.standard_error.reshape(by_component)


@checked
@renderer_method
def render_rays(
    self: Prepared,
    poses: Poses,
    *,
    first_pose: int | None = None,
    progress: Progress | None = None,
    **moves: Unpack[MovesOptions],
) -> NDArray[np.float32]:
    """The radiance that each single ray brings: float32 (P, N, samples, C), linear.

    Their mean over the samples is what `render` gives, with the same rays. Other arguments and
    errors are those of `render`; this needs ``samples`` times its memory, and a fixed number.
    """
    call = Call.of(self, poses, moves, first_pose, progress)
    samples = fixed_samples(self.settings.sampling, "render_rays")
    rays = np.empty((*call.size, samples, self.bands), np.float32)
    beside = call.new_beside() if self.world.light is not None else None
    call.render(call.new_frames(), ray_radiance=rays, beside_rays=beside)
    if beside is not None:
        rays += beside[:, :, :1]  # in each ray alike, so that their mean is the response
    return rays
