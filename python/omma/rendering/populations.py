"""Many different eyes in one world, rendered in one call: those of a generation that evolves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye, Scene
from omma.base.arguments import array_of, checked, expect
from omma.base.arrays import new_floats
from omma.base.notebook import html_table
from omma.base.progress import Progress
from omma.rendering.call import Frames, Responses, render_eyes
from omma.rendering.population_receptors import Filled, receptors_of, views_of
from omma.rendering.receptor_views import ReceptorViews
from omma.rendering.settings import (
    Fixed,
    Options,
    Sampling,
    Settings,
    frame_number,
    settings_as_record,
    takes_options,
)
from omma.scene.world import World
from omma.scene.world_moves import camera_now

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Population:
    """E eyes in one world, ready to render; each may have another number of ommatidia.

    Each eye sees what it would alone, with the same rays, to the bit, as long as all of them
    together have at most 64 different acceptance angles. Where there are more, directions of
    nearby widths come of one table, sensitivities are off by 1e-4 at most, and an eye may have
    other rays than alone, which change its responses within their standard errors. Making one
    takes less than rendering it.

    Args:
        world: what there is to see; or a scene, of which one is made.
        eyes: E eyes; or one, whose ommatidia are those of all, one eye behind the other.
        sampling: `omma.Fixed`: as many rays for every ommatidium.
        sizes: (E,), with one eye: how many ommatidia each has.
        options: as of `Renderer`, but for an impulse response.
        threads: 0 takes one per hardware thread.

    Example:
        >>> eyes = [omma.eye.generate_eye(n) for n in (20, 30)]
        >>> population = omma.Population(omma.World(omma.scene.box()), eyes, omma.Fixed(8))
        >>> [one.shape for one in population.render(np.eye(4))]
        [(1, 20, 3), (1, 30, 3)]

    Pickled, it is its world, its eyes and its settings, as a renderer is.

    Raises:
        omma.Error: no eyes, eyes of different receptors, sizes that are not those of the
            ommatidia, an argument out of its range.
        TypeError: an argument is of another type.
    """

    @checked
    @takes_options
    def __init__(
        self,
        world: World | Scene,
        eyes: Eye | Sequence[Eye],
        sampling: Sampling = Settings.sampling,
        *,
        sizes: ArrayLike | None = None,
        threads: int = 0,
        **options: Unpack[Options],
    ) -> None:
        expect(sampling, Fixed, "sampling", "the ommatidia of a population have equally many rays")
        self._settings = Settings(sampling, **options)
        if self._settings.impulse_response is not None:
            raise Error("impulse_response: expected frames that do not last for a population")
        self._world = World(world, threads=threads) if isinstance(world, Scene) else world
        self._threads = threads
        self._take(eyes, sizes, self._world._engine)

    @checked
    def with_eyes(self, eyes: Eye | Sequence[Eye], *, sizes: ArrayLike | None = None) -> Population:
        """Other eyes in the same world with the same settings, as the next generation: what both
        need is taken from here.

        Raises:
            omma.Error: as making one does.
        """
        other = object.__new__(Population)
        vars(other).update(vars(self))
        other._take(eyes, sizes, self._engine)
        return other

    def _take(
        self,
        eyes: Eye | Sequence[Eye],
        sizes: ArrayLike | None,
        known: _core.World | _core.Renderer,
    ) -> None:
        merged, counts = _merged(eyes, sizes)
        settings = self._settings.engine_settings(self._threads, counts.tolist())
        self._engine = _core.Renderer(known, merged, settings)
        self._sizes: NDArray[np.int64] = counts
        self._receptors: tuple[ReceptorViews, Population] | None = None

    def _receptor_views(self) -> tuple[ReceptorViews, Population]:
        """Where receptors look, and who renders that; made once."""
        if self._receptors is None:
            found, sizes = views_of(self.eye, self._sizes)
            seen_by = self
            if found.views is not None:
                seen_by = self.with_eyes(found.views, sizes=sizes)
            self._receptors = found, seen_by
        return self._receptors

    @property
    def world(self) -> World:
        """What there is to see."""
        return self._world

    @property
    def sizes(self) -> NDArray[np.int64]:
        """(E,), ommatidia of each eye."""
        sizes: NDArray[np.int64] = self._sizes.copy()
        return sizes

    @property
    def eye(self) -> Eye:
        """All of them, one eye behind the other."""
        return self._engine.eye

    @property
    def bands(self) -> int:
        """Numbers that a response has: those of the world."""
        return self._engine.bands

    @checked
    def render(
        self,
        poses: ArrayLike | str,
        *,
        standard_error: bool = False,
        first_pose: int | None = None,
        progress: Progress | None = None,
    ) -> list[Responses] | tuple[list[Responses], list[Responses]]:
        """Responses of each eye, (P, N, C) of its N ommatidia, all of them parts of one array.

        Args:
            poses: ``world_from_head`` (4, 4), m, or the name of a camera of the scene, of all,
                where it is since the last `World.at`; (E, 4, 4), of each; or (P, E, 4, 4), P of
                each.
            standard_error: also the standard errors, in the same form.
            first_pose: as of `Renderer.render`.
            progress: called with the finished share (0 to 1); what it raises ends the work.

        Raises:
            omma.Error: poses of another shape, or as `Renderer.render`.
        """
        heads, first = self._poses(poses), frame_number(first_pose)
        return _of_each(self._filled(heads, standard_error, first, progress), self._sizes)

    @checked
    def render_receptors(
        self,
        poses: ArrayLike | str,
        *,
        matrix: ArrayLike | None = None,
        ultraviolet: ArrayLike | None = None,
        standard_error: bool = False,
        first_pose: int | None = None,
        progress: Progress | None = None,
    ) -> list[Responses] | tuple[list[Responses], list[Responses]]:
        """What the receptors of each eye answer, (P, R) of its R, as `Renderer.render_receptors`
        gives it of each alone.

        Args:
            poses, standard_error, first_pose, progress: as of `render`.
            matrix, ultraviolet: as of `Renderer.render_receptors`, for all eyes.

        Raises:
            omma.Error: poses of another shape, or as `Renderer.render_receptors`.
        """
        heads, first = self._poses(poses), frame_number(first_pose)
        _, seen_by = self._receptor_views()
        found = receptors_of(
            self,
            lambda told, mixed: seen_by._filled(heads, standard_error, first, told, mixed),
            matrix,
            ultraviolet,
            standard_error,
            progress,
        )
        ends = np.append(0, np.cumsum(self._sizes))
        return _of_each(found, np.diff(self.eye.first_receptor[ends]))

    def _filled(
        self,
        heads: NDArray[np.float64],
        standard_error: bool,
        first_frame: int | None,
        progress: Progress | None,
        output_from_band: NDArray[np.float64] | None = None,
    ) -> Filled:
        """Responses (P, N, C) and their errors, of the bands or of mixtures of them."""
        outputs = self.bands if output_from_band is None else len(output_from_band)
        size = (len(heads), len(self.eye), outputs)
        frames = Frames(new_floats(size), new_floats(size) if standard_error else None)
        flat = np.ascontiguousarray(heads.reshape(-1, 4, 4))
        render_eyes(self._engine, flat, frames, first_frame, progress, output_from_band)
        return frames.responses, frames.standard_error

    def _poses(self, poses: ArrayLike | str) -> NDArray[np.float64]:
        """(P, E, 4, 4)."""
        if isinstance(poses, str):
            poses = camera_now(self._world, poses).world_from_camera
        given, eyes = array_of(poses, "poses"), len(self._sizes)
        if given.shape == (4, 4):
            given = np.broadcast_to(given, (eyes, 4, 4))
        if given.ndim == 3:
            given = given[None]
        if given.ndim != 4 or given.shape[1:] != (eyes, 4, 4):
            raise Error(
                f"poses: expected shape (4, 4), ({eyes}, 4, 4) or (P, {eyes}, 4, 4), found "
                f"{np.shape(poses)}"
            )
        return given

    def __reduce__(self) -> tuple[Callable[..., Population], tuple[Any, ...]]:
        return _again, (self._world, self.eye, self._sizes, self._settings, self._threads)

    def __repr__(self) -> str:
        return (
            f"<omma.Population {len(self._sizes):,} eyes of {len(self.eye):,} ommatidia, "
            f"{self._settings.sampling}, {self._engine.backend}>"
        )

    def _repr_html_(self) -> str:
        sizes = np.sort(self._sizes)[[0, -1]]
        rows = {
            "world": repr(self.world),
            "eyes": f"{len(self._sizes):,}",
            "ommatidia": f"{len(self.eye):,}, {sizes[0]:,} to {sizes[1]:,} of each eye",
        }
        options = {name: str(one) for name, one in settings_as_record(self._settings).items()}
        return html_table("omma.Population", rows | options)


def _of_each(
    found: Filled, sizes: NDArray[np.int64]
) -> list[Responses] | tuple[list[Responses], list[Responses]]:
    """Responses (P, R, ...), and errors where there are any, as those of eyes of so many (E,)."""
    ends = np.cumsum(sizes)[:-1]
    responses, errors = found
    split = np.split(responses, ends, axis=1)
    return split if errors is None else (split, np.split(errors, ends, axis=1))


def _again(
    world: World, eye: Eye, sizes: NDArray[np.int64], settings: Settings, threads: int
) -> Population:
    return Population(
        world, eye, settings.sampling, sizes=sizes, threads=threads, **settings.options()
    )


def _merged(eyes: Eye | Sequence[Eye], sizes: ArrayLike | None) -> tuple[Eye, NDArray[np.int64]]:
    if isinstance(eyes, Eye):
        if sizes is None:
            raise Error("sizes: expected how many ommatidia each eye has, beside one eye for all")
        counts = array_of(sizes, "sizes", (None,), np.int64)
        if len(counts) == 0 or (counts < 1).any() or counts.sum() != len(eyes):
            raise Error(
                f"sizes: expected numbers above 0 of {len(eyes):,} ommatidia in all, found "
                f"{counts.sum():,}"
            )
        return eyes, counts
    if sizes is not None:
        raise Error("sizes: only with one eye that has the ommatidia of all")
    if not isinstance(eyes, (list, tuple)):
        raise TypeError(f"eyes: expected omma.Eye or a list of them, found {type(eyes).__name__}")
    if not eyes:
        raise Error("eyes: expected one or more, found none")
    for e, eye in enumerate(eyes):
        expect(eye, Eye, f"eyes[{e}]", "omma.load_eye gives one")
        if eye.receptor_types != eyes[0].receptor_types:
            raise Error(f"eyes[{e}]: expected the receptor types of eyes[0], found others")
    return _core.merge_eyes(eyes), np.array([len(eye) for eye in eyes])
