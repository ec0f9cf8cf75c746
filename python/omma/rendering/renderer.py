"""The renderer: arguments checked and turned into arrays here, the work done in omma._core."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Background, Error, Eye, Scene
from omma.base.arguments import checked, expect, output_array, whole
from omma.base.notebook import html_table, without_folder
from omma.base.poses import Matrices, as_poses
from omma.base.renamed import renamed_arguments
from omma.rendering.dataset import make_dataset
from omma.rendering.iterate import render_pieces
from omma.rendering.moves import Moves, MovesOptions, takes_moves
from omma.rendering.pickling import parts_of
from omma.rendering.pose_warnings import warn_of_poses
from omma.rendering.receptor_views import ReceptorViews, render_receptors
from omma.rendering.report import SamplingReport, report_of
from omma.rendering.settings import (
    Options,
    Sampling,
    Settings,
    Shared,
    ToError,
    fixed_samples,
    frame_number,
    settings_as_record,
    takes_options,
)
from omma.rendering.truth import GroundTruth, render_truth
from omma.scene.world import World

if TYPE_CHECKING:
    import xarray
    from typing_extensions import Unpack

Responses = NDArray[np.float32]
Poses = ArrayLike | tuple[ArrayLike, ArrayLike] | str
Progress = Callable[[float], object]

# render_iter's buffer: big enough to keep all threads busy, small enough to forget about.
_CHUNK_BYTES = 32 << 20


class Renderer:
    """A world and an eye, ready to render: acceleration structure and direction tables are built.

    The response of ommatidium i in band b at a pose is the mean of the radiance around it, with
    its angular sensitivity as weight; a surround of radiance 1 gives 1. Bands are linear RGB,
    unless the world has others.

    Args:
        scene: what there is to see: a `World`, which is shared with whoever sees it too, or a
            scene, of which a world is made.
        eye: who sees it; a list of eyes is merged as `merge_eyes` does.
        sampling: `omma.Fixed`, as many rays for every ommatidium; `omma.ToError`, as many as each
            needs for an error; or `omma.Shared`, rays that neighbours share.
        options: seed, angular_sensitivity, points, footprints, noise and impulse_response, as
            `omma.rendering.Settings` has them: that says what each does.
        threads: 0 takes one per hardware thread.
        background: instead of the scene's or the world's own.
        backend: what traces the rays of a scene, see `World`; a world has its own.
        progress: called with the finished share (0 to 1) of the acceleration structure a few times
            a second, where one is made. What it raises ends the building and is raised here; so
            does Ctrl-C.

    Pickled, a renderer is its world, its eye and its settings, and is built again where it is
    unpickled: to the same bits, with noise="new_every_frame" from frame 0 on, and with the threads
    of that machine where none were asked for. Renderers that are pickled together go on to share
    their world. A copy (`copy.copy`) shares it too; a deep copy does not.

    In a process made by fork from one that had used a renderer, those made before the fork go on to
    work, on one thread; new ones of a scene are refused (docs/performance.md). Other start methods
    have no such limits.

    Example:
        >>> eye = omma.eye.generate_eye(50)
        >>> white = omma.Background.constant((1, 1, 1))
        >>> renderer = omma.Renderer(omma.Scene(), eye, omma.Fixed(4), background=white)
        >>> renderer.render(np.eye(4)).shape
        (1, 50, 3)
        >>> renderer.with_eye(eye, omma.ToError(0.01)).settings.sampling
        ToError(error=0.01, least=None, most=None, relative_error=None)

    Raises:
        omma.Error: an argument is out of its range.
        TypeError: an argument is of another type.
    """

    @renamed_arguments(kernel="angular_sensitivity")
    @checked
    @takes_options
    def __init__(
        self,
        scene: Scene | World,
        eye: Eye | Sequence[Eye | tuple[Eye, ArrayLike]],
        sampling: Sampling = Settings.sampling,
        *,
        threads: int = 0,
        background: Background | None = None,
        backend: str = "",
        progress: Progress | None = None,
        **options: Unpack[Options],
    ) -> None:
        if not isinstance(scene, World):
            expect(scene, Scene, "scene", "omma.load_scene gives one")
        elif backend:
            raise Error("backend: the world that is given has its own")
        eye = _one_eye(eye)
        if background is not None:
            expect(background, Background, "background", "omma.Background.constant gives one")
        self._settings = Settings(sampling, **options)
        for_engine = self._settings.engine_settings(threads)
        self._build_times: dict[str, float] = {"scene_s": 0.0, "acceleration_s": 0.0}
        if isinstance(scene, Scene):
            scene = World(
                scene, background=background, threads=threads, backend=backend, progress=progress
            )
            self._build_times = scene.build_times
        elif background is not None:
            scene = scene.with_background(background)
        self._world = scene
        self._engine = _core.Renderer(scene._engine, eye, for_engine)
        self._asked_threads = threads
        self._receptors: ReceptorViews | None = None

    @renamed_arguments(kernel="angular_sensitivity")
    @checked
    def with_eye(
        self,
        eye: Eye | Sequence[Eye | tuple[Eye, ArrayLike]],
        sampling: Sampling | None = None,
        **options: Unpack[Options],
    ) -> Renderer:
        """Another renderer of the same world, for another eye or with other settings.

        It shares the acceleration structure, so that it is made in milliseconds. What is not given
        stays as it is here; either renderer lives on without the other.

        Raises:
            omma.Error: an argument is out of its range.
            TypeError: an argument is of another type.
        """
        chosen = self._settings.sampling if sampling is None else sampling
        other = object.__new__(Renderer)
        vars(other).update(vars(self))
        other._settings = replace(self._settings, sampling=chosen, **options)
        for_engine = other._settings.engine_settings(self.threads)
        other._engine = _core.Renderer(self._engine, _one_eye(eye), for_engine)
        other._build_times = {"scene_s": 0.0, "acceleration_s": 0.0}
        other._receptors = None
        return other

    @checked
    def with_world(self, world: World) -> Renderer:
        """The same eye with the same settings in another world, as before another background.

        Made in milliseconds, as the eye's tables are shared.

        Raises:
            omma.Error: what the settings ask for cannot be had there, as shared rays in a polarised
                world.
        """
        other = object.__new__(Renderer)
        vars(other).update(vars(self))
        other._world = world
        other._engine = _core.Renderer(self._engine, world._engine)
        other._build_times = {"scene_s": 0.0, "acceleration_s": 0.0}
        other._receptors = None
        return other

    @overload
    def render(
        self,
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
        self,
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
        self,
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
    @takes_moves
    def render(
        self,
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
                scene, whose whole transform is the pose, its scale too. Arrays of other libraries
                come by DLPack, float64 without a copy (docs/closed-loops.md).
            standard_error: return (responses, errors), errors the standard error of each response.
                It comes from 8 independent scrambles, so 8 times the rays are traced and the
                response is their mean; with `ToError` it is estimated from the rays as they
                are. Where all rays miss something it is too small: `confidence_interval` gives
                bounds that heed the neighbours.
            report: return (responses, report) with `ToError`: rays spent, estimated
                standard errors, and who did not reach the error, see `SamplingReport`.
            out: a C-contiguous float32 (P, N, C) array of the caller's to write into, NumPy's or
                by DLPack another library's on the CPU; it is what is returned, as NumPy's.
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
                millimetres.
            RuntimeWarning: single precision holds rays and surfaces at one of the poses less than
                a millimetre exactly, as in scenes of tens of kilometres, or by more than 1e-4 of
                the size of a scene that is far away; it says how exactly. Scenes far from the
                world's origin are traced from an origin of their own and lose nothing.
        """
        matrices = self._matrices(poses)
        shape = (len(matrices), len(self.eye), self.bands)
        target = self.settings.sampling
        if report and not isinstance(target, ToError):
            raise Error(f"report: is for renders to an error (omma.ToError), found {target}")
        if report and standard_error:
            raise Error("report: has the standard errors; not together with standard_error")
        with_errors = standard_error or report
        if error_out is not None and not with_errors:
            raise Error("error_out: given, but standard_error is False")
        responses = output_array(out, shape, "out")
        errors = output_array(error_out, shape, "error_out") if with_errors else None
        if errors is not None and out is not None and np.shares_memory(errors, responses):
            raise Error("error_out: shares memory with out")
        rays = np.empty(shape[:2], np.int32) if report else None
        first = frame_number(first_pose)
        moving = self._moves(matrices, moves)
        self._engine.render(
            matrices,
            responses,
            errors,
            rays,
            None,
            first,
            None,
            False,
            moving.for_engine(),
            progress,
        )
        moving.note()
        warn_of_poses(self._engine, matrices)
        if errors is not None and rays is not None and isinstance(target, ToError):
            return responses, report_of(target, responses, errors, rays)
        return responses if errors is None else (responses, errors)

    @overload
    def render_receptors(
        self,
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
        self,
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
    @takes_moves
    def render_receptors(
        self,
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
        """
        return render_receptors(
            self,
            self._receptor_views(),
            poses,
            matrix,
            ultraviolet,
            standard_error,
            out,
            first_pose,
            progress,
            moves,
        )

    @overload
    def render_stokes(
        self,
        poses: Poses,
        *,
        standard_error: Literal[False] = False,
        first_pose: int | None = None,
        progress: Progress | None = None,
        **moves: Unpack[MovesOptions],
    ) -> Responses: ...

    @overload
    def render_stokes(
        self,
        poses: Poses,
        *,
        standard_error: Literal[True],
        first_pose: int | None = None,
        progress: Progress | None = None,
        **moves: Unpack[MovesOptions],
    ) -> tuple[Responses, Responses]: ...

    @checked
    @takes_moves
    def render_stokes(
        self,
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
        matrices = self._matrices(poses)
        shape = (len(matrices), len(self.eye), 3 * self.bands)
        found = np.empty(shape, np.float32)
        errors = np.empty(shape, np.float32) if standard_error else None
        first = frame_number(first_pose)
        moving = self._moves(matrices, moves)
        self._engine.render(
            matrices, found, errors, None, None, first, None, True, moving.for_engine(), progress
        )
        moving.note()
        warn_of_poses(self._engine, matrices)
        by_component = (*shape[:2], 3, self.bands)
        return (
            found.reshape(by_component)
            if errors is None
            else (found.reshape(by_component), errors.reshape(by_component))
        )

    def _render_outputs(
        self,
        matrices: Matrices,
        output_from_band: NDArray[np.float64],
        first_pose: int | None,
        progress: Progress | None,
        standard_error: bool = True,
        moving: Moves | None = None,
    ) -> tuple[Responses, Responses | None]:
        """Mixtures of the bands, [output, component x band], and their standard errors: (P, N,
        outputs)."""
        shape = (len(matrices), len(self.eye), len(output_from_band))
        found = np.empty(shape, np.float32)
        errors = np.empty(shape, np.float32) if standard_error else None
        weights = np.ascontiguousarray(output_from_band)
        moves = None if moving is None else moving.for_engine()
        self._engine.render(
            matrices, found, errors, None, None, first_pose, weights, False, moves, progress
        )
        return found, errors

    def _receptor_views(self) -> ReceptorViews:
        if self._receptors is None:
            self._receptors = ReceptorViews(self)
        return self._receptors

    @checked
    @takes_moves
    def render_rays(
        self,
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
        matrices = self._matrices(poses)
        shape = (len(matrices), len(self.eye), self.bands)
        samples = fixed_samples(self.settings.sampling, "render_rays")
        rays = np.empty((*shape[:2], samples, shape[2]), np.float32)
        first = frame_number(first_pose)
        responses = np.empty(shape, np.float32)
        moving = self._moves(matrices, moves)
        self._engine.render(
            matrices, responses, None, None, rays, first, None, False, moving.for_engine(), progress
        )
        moving.note()
        warn_of_poses(self._engine, matrices)
        return rays

    @overload
    def render_iter(
        self,
        poses: Poses | Iterable[ArrayLike],
        *,
        standard_error: Literal[False] = False,
        chunk: int | None = None,
        first_pose: int | None = None,
        **moves: Unpack[MovesOptions],
    ) -> Iterator[Responses]: ...

    @overload
    def render_iter(
        self,
        poses: Poses | Iterable[ArrayLike],
        *,
        standard_error: Literal[True],
        chunk: int | None = None,
        first_pose: int | None = None,
        **moves: Unpack[MovesOptions],
    ) -> Iterator[tuple[Responses, Responses]]: ...

    @checked
    @takes_moves
    def render_iter(
        self,
        poses: Poses | Iterable[ArrayLike],
        *,
        standard_error: bool = False,
        chunk: int | None = None,
        first_pose: int | None = None,
        **moves: Unpack[MovesOptions],
    ) -> Iterator[Responses] | Iterator[tuple[Responses, Responses]]:
        """Responses (N, C) of one pose after the other, for more poses than memory holds.

        Equal, bit for bit, to what `render` gives for all poses at once. Poses are taken from
        ``poses`` as they are needed, ``chunk`` at a time.

        Args:
            poses: as in `render`, or any iterable of (4, 4) matrices, a generator too.
            standard_error: yield pairs (responses, errors).
            chunk: poses rendered at once; None takes as many as fit into 32 MB. What was yielded
                stays valid, and keeps the memory of its chunk alive.
            first_pose: as in `render`.
            instances, transforms, times_s, animation, past, unseen, unseen_by_light: as in
                `render`, for all poses, which are then an array.

        Raises:
            omma.Error: as `render`, when the pose is reached.
        """
        count = self._chunk() if chunk is None else whole(chunk, "chunk", 1, 1 << 31)
        first = frame_number(first_pose)
        return render_pieces(self, poses, moves, count, standard_error, first)

    @checked
    @takes_moves
    def ground_truth(
        self,
        poses: Poses,
        *,
        shares: Sequence[str | int] = (),
        head_velocity: tuple[ArrayLike, ArrayLike] | None = None,
        velocities: Mapping[str | int, tuple[ArrayLike, ArrayLike]] | None = None,
        standard_error: bool = False,
        first_pose: int | None = None,
        progress: Progress | None = None,
        **moves: Unpack[MovesOptions],
    ) -> GroundTruth:
        """Responses, and beside them how far, where and what each ommatidium sees.

        Means over the very rays of `render`, whose bits the responses have: distances, positions,
        normals, shares of instances and optic flow; `GroundTruth` says what each is
        (docs/ground-truth.md). Not with `Shared`.

        Args:
            poses, standard_error, first_pose, progress: as in `render`. With `ToError` there
                are always standard errors.
            shares: whose shares of the field to tell: names, each of all that are called so, or
                indices in `World.instances`.
            head_velocity: the head's linear velocity, m/s, and angular velocity, rad/s, in the
                world's frame, each (3,) or (P, 3): of its origin, and right-handed about it.
                `omma.velocities_from_poses` finds them from a path. With it or ``velocities`` there
                is optic flow.
            velocities: of what moves by itself, {name or index in `World.instances`: (linear,
                angular)}: of the origin of the node's frame where it is now, as ``head_velocity``.
                With ``times_s``, what ``instances`` and animations move has the velocity at which
                it does so, unless it is told here.
            instances, transforms, times_s, animation, unseen, unseen_by_light: as of `render`.

        Raises:
            omma.Error: what `render` raises, no such instance or one twice, a velocity of another
                shape or above 1e9, rays that are shared; things moved by a single transform, or one
                whose times do not grow, of which no velocity is told.
        """
        return render_truth(
            self,
            poses,
            shares=shares,
            head_velocity=head_velocity,
            velocities=velocities,
            standard_error=standard_error,
            first_pose=first_pose,
            progress=progress,
            moves=moves,
        )

    @checked
    @takes_moves
    def dataset(
        self,
        poses: Poses,
        *,
        receptors: bool = False,
        ultraviolet: ArrayLike | None = None,
        standard_error: bool = False,
        time_s: ArrayLike | None = None,
        truth: GroundTruth | None = None,
        first_pose: int | None = None,
        progress: Progress | None = None,
        **moves: Unpack[MovesOptions],
    ) -> xarray.Dataset:
        """Responses as an `xarray.Dataset`, which says what its numbers are.

        Dimensions: ``pose`` (or ``time``), then ``ommatidium`` and ``band``, or ``receptor``.
        Coordinates: position (m) and quaternion (x, y, z, w) of the head, azimuth and elevation
        (degrees, in the head), acceptance angle, eye; of receptors also type, peak wavelength (nm)
        and ommatidium.
        Variables: ``response``, ``standard_error`` where asked for, ``rays`` with `ToError`.
        Attributes: Omma's version, backend, settings, hashes (SHA-256) of the eye and of the
        scene's files as they are now.

        Args:
            poses, standard_error, first_pose, progress: as of `render`. With `ToError` there
                are always standard errors.
            receptors: what receptors answer, as `render_receptors` says, instead of bands.
            ultraviolet: as of `render_receptors`.
            time_s: (P,), when each pose is, s: the first dimension is then ``time``. None:
                ``times_s``, where these are given.
            truth: what `ground_truth` gave for these poses. Its responses are taken, nothing is
                rendered; each of its arrays is a variable, with ``axis`` (x, y, z), ``direction``
                (right, up) or ``instance`` behind ``ommatidium``.
            instances, transforms, times_s, animation: as of `render`.

        Raises:
            omma.Error: what `render` and `render_receptors` raise; no xarray (``omma[data]``).
        """
        return make_dataset(
            self,
            poses,
            receptors=receptors,
            ultraviolet=ultraviolet,
            standard_error=standard_error,
            time_s=time_s,
            truth=truth,
            first_pose=first_pose,
            progress=progress,
            moves=moves,
        )

    def _moves(self, matrices: Matrices, moves: MovesOptions) -> Moves:
        return Moves(self._world, matrices, moves, self._settings.impulse_response)

    def _matrices(self, poses: Poses) -> Matrices:
        if isinstance(poses, str):
            return as_poses(self.scene.camera(poses).world_from_camera)
        return as_poses(poses)

    def _chunk(self) -> int:
        pose_bytes = max(1, len(self.eye)) * self.bands * 4
        return max(1, min(4096, _CHUNK_BYTES // pose_bytes))

    @property
    def world(self) -> World:
        """What there is to see, and to move."""
        return self._world

    @property
    def scene(self) -> Scene:
        """Of the world."""
        return self._world.scene

    @property
    def eye(self) -> Eye:
        """Who sees it; all eyes of the head as one."""
        return self._engine.eye

    @property
    def settings(self) -> Settings:
        """How it takes its rays."""
        return self._settings

    @property
    def shared_ommatidia(self) -> NDArray[np.bool_]:
        """Which ommatidia share rays with their neighbours, (N,) bool: with `Shared` those
        whose fields overlap enough to make it worth while, else none."""
        return self._engine.shared_ommatidia.astype(bool)

    @property
    def rays_per_frame(self) -> int:
        """Rays traced for a pose without a standard error; with `ToError`, at least."""
        return self._engine.rays_per_frame

    @property
    def rays_per_receptor_frame(self) -> int:
        """Rays traced for a pose by `render_receptors`, as `rays_per_frame` counts them."""
        return self._receptor_views().renderer._engine.rays_per_frame

    @property
    def bands(self) -> int:
        """Numbers that a response has: those of the world."""
        return self._engine.bands

    @property
    def threads(self) -> int:
        """Threads that a render uses."""
        return self._engine.threads

    @property
    def backend(self) -> str:
        """What traces the rays, with its version."""
        return self._engine.backend

    @property
    def build_times(self) -> dict[str, float]:
        """Seconds spent when the renderer was made: scene_s, acceleration_s, directions_s; the
        first two are 0 where its world was there already."""
        return self._engine.build_times | self._build_times

    def __repr__(self) -> str:
        rays = str(self.settings.sampling)
        if isinstance(self.settings.sampling, Shared):
            rays += f" by {np.count_nonzero(self.shared_ommatidia)}"
        return (
            f"<omma.Renderer {len(self.eye)} ommatidia, {rays}, "
            f"{self.settings.angular_sensitivity}, {self.backend}, {self.threads} threads>"
        )

    def _repr_html_(self) -> str:
        rows = {
            "world": without_folder(repr(self.world), self.world.scene.path),
            "eye": without_folder(repr(self.eye), self.eye.path),
        }
        options = {name: str(value) for name, value in settings_as_record(self.settings).items()}
        return html_table("omma.Renderer", rows | options | {"threads": str(self.threads)})

    def __reduce__(self) -> tuple[Callable[..., Renderer], tuple[Any, ...]]:
        return parts_of(self, self._asked_threads)


def _one_eye(eye: Eye | Sequence[Eye | tuple[Eye, ArrayLike]]) -> Eye:
    if isinstance(eye, Eye):
        return eye
    if not isinstance(eye, (list, tuple)):
        raise TypeError(
            f"eye: expected omma.Eye or a list of them, found {type(eye).__name__} "
            "(omma.load_eye gives one)"
        )
    return _core.merge_eyes(eye)
