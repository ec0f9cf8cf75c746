"""What all stimuli share: the world that shows one, its motion, and what must be answered to it."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Background, Error, Scene
from omma.base.arguments import Shape, array_of, checked, expect
from omma.base.arrays import Floats
from omma.base.poses import Matrices
from omma.base.progress import Progress
from omma.base.slips import warn_of_slip
from omma.base.values import in_full
from omma.photoreceptors import ImpulseResponse
from omma.scene.world import World
from omma.stimuli.gaussian import gaussian_means
from omma.stimuli.jumps import Motion, Path, even_steps, motion_of
from omma.stimuli.shown import check_shown, is_shown


class Settings(Protocol):
    """Of a renderer."""

    @property
    def impulse_response(self) -> ImpulseResponse | None: ...
    @property
    def noise(self) -> str: ...


@runtime_checkable
class Renderer(Protocol):
    """What `Stimulus.play` needs of an `omma.Renderer`."""

    @property
    def world(self) -> World: ...
    @property
    def settings(self) -> Settings: ...
    def render(self, poses: NDArray[np.float64], **options: Any) -> NDArray[np.float32]: ...


class Stimulus:
    """What all stimuli can do; each is a frozen value with parameters of its own.

    The head is at the origin of the world, at the identity pose: it looks along -Z, +X is its
    right, +Y up; azimuths grow to the right, elevations upwards. Radiance is linear and the same in
    red, green and blue; in a world with a light it is a reflectance instead. Things are surfaces
    that move by their names, so that `omma.scene.merge_scenes` can put a stimulus into another
    scene.

    """

    __repr__ = in_full

    # Fields of each: what it is called, and the radiance where nothing of it is.
    name: str
    background: float

    @property
    def names(self) -> list[str]:
        """Of the K things that move, as `World.set_transforms` takes them."""
        return [self.name]

    @checked
    def transforms(self, times_s: ArrayLike) -> Floats:
        """Where its things are: ``world_from_node`` (T, K, 4, 4), m, at times (T,), s; (K, 4, 4) at
        one time.

        Some of `PlaneGrating`, `Starfield` and `LedArena` jump from one time to the next. For how
        things move see `velocities`; `play` knows which are jumps.

        Raises:
            omma.Error: a wrong shape, or a time that is not finite.
        """
        times = one_or_more_times(times_s)
        return np.asarray(
            self._transforms(times.ravel()).reshape(*times.shape, len(self.names), 4, 4)
        )

    @checked
    def velocities(self, times_s: ArrayLike) -> dict[str, tuple[Floats, Floats]]:
        """How its things move, as `Renderer.ground_truth` takes it: {name: (linear (T, 3), m/s, and
        angular (T, 3), rad/s)} in the world, at times (T,), s; (3,) each at one time.

        Of what is seen: where a thing jumps, as a `PlaneGrating` does by a period, that does not
        count.

        Example:
            >>> drum = omma.stimuli.DrumGrating(wavelength_deg=30, temporal_frequency_hz=5)
            >>> np.degrees(drum.velocities([0.0])["drum"][1]).round(6).tolist()
            [[0.0, -150.0, 0.0]]

        Raises:
            omma.Error: a wrong shape, or a time that is not finite.
        """
        times = one_or_more_times(times_s)
        linear, angular = (
            one.reshape(*times.shape, len(self.names), 3) for one in self._velocities(times.ravel())
        )
        return {name: (linear[..., k, :], angular[..., k, :]) for k, name in enumerate(self.names)}

    @checked
    def radiance(self, directions: ArrayLike, time_s: float) -> Floats:
        """What is seen from the origin in directions (..., 3) of the world: (...).

        Raises:
            omma.Error: a wrong shape, vectors that are not of length 1, a time that is not finite.
        """
        return self._radiance(_as_directions(directions), _one_time(time_s))

    def _transforms(self, times_s: Floats) -> Floats:
        raise NotImplementedError

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        raise NotImplementedError

    def _velocities(self, times_s: Floats) -> Motion:
        """Of each thing, (T, K, 3): where nothing jumps those of its transforms."""
        return motion_of(self._transforms, times_s, self._ends_s)

    @property
    def _ends_s(self) -> tuple[float, float]:
        """When what moves begins to and when it stops, s."""
        return -np.inf, np.inf

    def _jumps_s(self, first_s: float, last_s: float) -> Floats:
        """When anything jumps after the first and not after the last time, growing, s."""
        return np.empty(0)

    def _bends_s(self, first_s: float, last_s: float) -> Floats:
        """When anything turns to another way between the first and the last time, growing, s: from
        each to the next things go straight and turn evenly."""
        return np.empty(0)

    @property
    def _longest_step_s(self) -> float:
        """Between frames, from which on it would seem to turn the other way."""
        return np.inf

    @property
    def _even_for_s(self) -> float:
        """How long things that do not bend are well taken to go straight and turn evenly."""
        return self._longest_step_s / 2

    def _scene(self) -> Scene:
        """Its things, wherever they are."""
        raise NotImplementedError

    def scene(self) -> Scene:
        """Its things, as they are at time 0, before its background."""
        made = self._scene()
        transforms = dict(zip(self.names, self._transforms(np.zeros(1))[0], strict=True))
        return made.replace(
            instances=[one.replace(world_from_mesh=transforms[one.name]) for one in made.instances],
            background=Background.constant([self.background] * 3),
        )

    def world(self, **options: Any) -> World:
        """A world that shows it, at time 0, ready to be moved.

        Args:
            options: of `omma.World`: threads, band_from_rgb, light and others.

        Raises:
            omma.Error: an option is out of its range.
        """
        world = World(self.scene(), **options)
        is_shown(self, world)
        self.move(world, 0.0)
        return world

    @checked
    def move(self, world: World, time_s: float) -> None:
        """Put its things in a world, its own or any that has them, to where they are at a time, s.

        Raises:
            omma.Error: the world lacks them or has those of another stimulus, or is being rendered.
        """
        expect(world, World, "world", "Stimulus.world gives one")
        transforms = self._transforms(np.array([_one_time(time_s)]))[0]
        world.set_transforms(self._indices(world), transforms)

    def _indices(self, world: World) -> list[int]:
        """Which of a world's things are its own."""
        numbers: dict[str, list[int]] = {}
        for number, one in enumerate(world.instances):
            numbers.setdefault(one.name, []).append(number)
        found = [numbers.get(name, []) for name in self.names]
        # The world says what is wrong with a name that nothing has, or several things.
        indices = [
            one[0] if len(one) == 1 else world.index(name)
            for name, one in zip(self.names, found, strict=True)
        ]
        check_shown(self, world)
        return indices

    @checked
    def expected(self, axes: ArrayLike, acceptance_rad: ArrayLike, times_s: ArrayLike) -> Floats:
        """What ommatidia with a Gaussian angular sensitivity at the origin answer: (T, N), or (N,)
        at one time.

        In each band, where its weights of red, green and blue sum to 1. Computed from formulas,
        not rendered: docs/scenes.md says how, and how exactly.

        Args:
            axes: (N, 3), where they look in the world; of any length.
            acceptance_rad: (N,) or one for all, Δρ, full width at half maximum; 0 is a single ray.
            times_s: (T,), or one time, s.

        Raises:
            omma.Error: a wrong shape, an axis of length 0, an acceptance angle below 0 or above π.

        Warns:
            UserWarning: acceptance angles above 60° or below 0.02°, mostly degrees.
        """
        vectors = array_of(axes, "axes", (None, 3))
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        if not (np.isfinite(length) & (length > 0)).all():
            raise Error("axes: expected directions, found one of length 0 or not finite")
        widths = array_of(acceptance_rad, "acceptance_rad")
        if widths.shape not in ((), (1,), (len(vectors),)):
            raise Error(f"acceptance_rad: expected shape ({len(vectors)},), found {widths.shape}")
        if not ((widths >= 0) & (widths <= np.pi)).all():
            raise Error("acceptance_rad: expected angles from 0 to π")
        warn_of_slip("acceptance angle", widths[widths > 0], "acceptance_rad")
        all_widths = np.broadcast_to(widths, (len(vectors),))
        times = one_or_more_times(times_s)
        found = self._expected(vectors / length, all_widths, times.ravel())
        return np.asarray(found.reshape(*times.shape, len(vectors)))

    def _expected(self, axes: Floats, acceptance_rad: Floats, times_s: Floats) -> Floats:
        return gaussian_means(self._radiance, axes, acceptance_rad, times_s)

    @checked
    def play(
        self,
        renderer: Renderer,
        times_s: ArrayLike,
        *,
        poses: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> NDArray[np.float32]:
        """Responses (T, N, B) to the stimulus at each time: float32 [time, ommatidium, band].

        As `render` with ``instances`` and ``transforms``: afterwards the renderer's world is as it
        was. Ctrl-C stops it. With an impulse response things move within a frame, and before the
        first, as the stimulus says; the head goes straight and turns evenly from each time to the
        next, and stood still before the first.

        Args:
            renderer: an `omma.Renderer` of `world()`, or of any world with the stimulus' things:
                not of the world of another stimulus, as contrasts, wavelengths and shapes are part
                of the world.
            times_s: (T,), s.
            poses: ``world_from_head``, (4, 4), or (T, 4, 4), one for each time, m. None: the
                identity.
            progress: called with the finished share (0 to 1) a few times a second. What it raises
                ends the play and is raised here.

        Example:
            >>> disc = omma.stimuli.LoomingDisc(l_over_v_s=0.05, collision_s=0.5)
            >>> eye = omma.eye.generate_eye(50)
            >>> renderer = omma.Renderer(disc.world(), eye, omma.Fixed(16))
            >>> disc.play(renderer, np.linspace(0, 0.4, 5)).shape
            (5, 50, 3)

        Raises:
            omma.Error: a wrong shape, a pose or a time that is not finite, a world without the
                stimulus or with another one; with an impulse response times that do not grow or
                between which it turns by half a turn or more, or more jumps than can be followed.
        """
        times = as_times(times_s)
        shapes: list[Shape] = [(4, 4), (len(times), 4, 4)]
        matrices = array_of(np.eye(4) if poses is None else poses, "poses", shapes)
        matrices = np.ascontiguousarray(np.broadcast_to(matrices, (len(times), 4, 4)))
        instances = self._indices(renderer.world)
        h = renderer.settings.impulse_response
        if h is None:
            return renderer.render(
                matrices,
                instances=instances,
                transforms=self._transforms(times),
                progress=progress,
            )
        steps = np.diff(times)
        if not (steps > 0).all():
            raise Error("times_s: expected times that grow, found others")
        if steps.size and steps.max() >= self._longest_step_s:
            raise Error(
                f"times_s: expected steps below {self._longest_step_s:.4g} s, in which {self.name} "
                "turns by half a turn and would seem to turn the other way, found "
                f"{steps.max():.4g} s"
            )
        return self._render_lasting(renderer, times, matrices, instances, progress)

    def _render_lasting(
        self,
        renderer: Renderer,
        times_s: Floats,
        matrices: Matrices,
        instances: list[int],
        progress: Progress | None,
    ) -> NDArray[np.float32]:
        """Responses (T, N, B) at growing times by a renderer with an impulse response."""
        h = renderer.settings.impulse_response
        assert h is not None
        path = self._path(times_s, matrices, h.duration_s)
        return path.render(renderer.render, instances, progress)

    def _path(self, times_s: Floats, matrices: Matrices, duration_s: float) -> Path:
        """The way of a head and of its things through frames that last so long, s."""
        first, last = (times_s[0], times_s[-1]) if len(times_s) else (0.0, 0.0)
        start = float(first - duration_s)
        jumps = self._jumps_s(start, last)
        before = even_steps(self._even_for_s, start, first)
        bends = np.union1d(before, self._bends_s(start, last))
        return Path(times_s, matrices, start, jumps, bends, self._transforms, len(self.names))


def as_times(times_s: ArrayLike) -> Floats:
    """Times (T,), s, checked."""
    return one_or_more_times(array_of(times_s, "times_s", (None,)))


def one_or_more_times(times_s: ArrayLike) -> Floats:
    """Times (T,) or one time (), s, checked."""
    times = array_of(times_s, "times_s", [(None,), ()])
    if not (np.isfinite(times) & (np.abs(times) < 1e9)).all():
        raise Error("times_s: expected seconds between -1e9 and 1e9, found others")
    return times


def _as_directions(directions: ArrayLike) -> Floats:
    """Directions (..., 3) of length 1, checked."""
    vectors = array_of(directions, "directions", (..., 3))
    if not (np.abs(np.linalg.norm(vectors, axis=-1) - 1) < 1e-6).all():
        raise Error("directions: expected vectors of length 1, found others")
    return vectors


def _one_time(time_s: float) -> float:
    return float(as_times([float(time_s)])[0])
