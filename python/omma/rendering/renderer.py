"""The renderer: a world, an eye and settings, and a table of what can be rendered of them.

What each method does stands in the module that it comes from; all make a `Call` of their arguments,
which goes to omma._core.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Background, Error, Eye, Scene
from omma.base.arguments import checked, expect, or_its_eye
from omma.base.notebook import html_table
from omma.base.progress import Progress
from omma.base.renamed import renamed_arguments
from omma.rendering.call import FrameCount
from omma.rendering.color_gradients import background_vjp, color_jacobian
from omma.rendering.dataset import dataset
from omma.rendering.frames import render, render_rays, render_stokes
from omma.rendering.gradients import jacobian, jvp, vjp
from omma.rendering.image_gradients import image_vjp
from omma.rendering.iterate import render_iter
from omma.rendering.pickling import parts_of
from omma.rendering.receptor_frames import render_receptors
from omma.rendering.receptor_views import ReceptorViews
from omma.rendering.settings import (
    Options,
    Sampling,
    Settings,
    Shared,
    changes_options,
    settings_as_record,
    takes_options,
)
from omma.rendering.truth import ground_truth
from omma.scene.world import World

if TYPE_CHECKING:
    from typing_extensions import Unpack


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
        backend, devices: what traces the rays of a scene, see `World`; a world has its own.
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
        devices: Sequence[int] = (),
        progress: Progress | None = None,
        **options: Unpack[Options],
    ) -> None:
        if not isinstance(scene, World):
            expect(scene, Scene, "scene", "omma.load_scene gives one")
        elif backend:
            raise Error("backend: the world that is given has its own")
        elif len(devices) > 0:
            raise Error("devices: the world that is given has its own")
        eye = _one_eye(eye)
        if background is not None:
            expect(background, Background, "background", "omma.Background.constant gives one")
        self._settings = Settings(sampling, **options)
        for_engine = self._settings.engine_settings(threads)
        self._build_times: dict[str, float] = {"scene_s": 0.0, "acceleration_s": 0.0}
        if isinstance(scene, Scene):
            scene = World(
                scene, background=background, threads=threads, backend=backend, devices=devices,
                progress=progress,
            )  # fmt: skip
            self._build_times = scene.build_times
        elif background is not None:
            scene = scene.with_background(background)
        self._world = scene
        self._engine = _core.Renderer(scene._engine, eye, for_engine)
        self._frames = FrameCount()
        self._asked_threads = threads
        self._receptors: tuple[ReceptorViews, Renderer] | None = None

    @renamed_arguments(kernel="angular_sensitivity")
    @checked
    @changes_options
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
        other._frames = FrameCount()
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
        other._frames = FrameCount()
        other._build_times = {"scene_s": 0.0, "acceleration_s": 0.0}
        other._receptors = None
        return other

    render = render
    render_receptors = render_receptors
    render_stokes = render_stokes
    render_rays = render_rays
    render_iter = render_iter
    ground_truth = ground_truth
    jacobian = jacobian
    jvp = jvp
    vjp = vjp
    color_jacobian = color_jacobian
    background_vjp = background_vjp
    image_vjp = image_vjp
    dataset = dataset

    def _receptor_views(self) -> tuple[ReceptorViews, Renderer]:
        """Where receptors look, and who renders that; made once."""
        if self._receptors is None:
            found = ReceptorViews(self.eye)
            seen_by = self if found.views is None else self.with_eye(found.views)
            self._receptors = found, seen_by
        return self._receptors

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
        return self._receptor_views()[1]._engine.rays_per_frame

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
        rows = {"world": repr(self.world), "eye": repr(self.eye)}
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
            f"({or_its_eye(eye, 'omma.Eye', 'omma.load_eye gives one')})"
        )
    return _core.merge_eyes(eye)
