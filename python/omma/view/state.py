"""What the page shows, without the page: settings in, responses with their errors out.

All that touches the engine is here and in `picked`; nothing here knows of viser, so that tests need
no browser.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Camera, Error, Eye, error_scrambles
from omma.base.arguments import expect, positive, whole, within
from omma.base.arrays import Floats32
from omma.base.progress import Progress
from omma.base.values import value_class
from omma.eye.change import set_acceptance
from omma.picture.cameras import render_camera
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed, Options
from omma.scene.world import World
from omma.view.poses import HeadPose

if TYPE_CHECKING:
    from typing_extensions import Unpack


MOST_SAMPLES = 256
WIDEST_FACTOR = 10.0
_LONGEST_S = 1e9
# Standard errors come from 8 scrambles; beyond so many rays of each a picture changes no more.
_FINEST = 64
_KEPT_RENDERERS = 12


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Look:
    """What responses depend on, as it is set on the page.

    samples: rays of each ommatidium, in the first frame. acceptance_factor: times each acceptance
    angle Δρ; 1 leaves acceptances as they are, all else makes round Gaussians of them, as
    ``omma eye acceptance --factor`` does. time_s: of the scene's animations, s; None: as the file
    has it. receptors: whether the eye's receptors are asked for.
    """

    pose: HeadPose = field(default_factory=HeadPose)
    samples: int = 4
    acceptance_factor: float = 1.0
    time_s: float | None = None
    receptors: bool = False

    def __post_init__(self) -> None:
        expect(self.pose, HeadPose, "pose", "omma.view.HeadPose makes one")
        object.__setattr__(self, "samples", whole(self.samples, "samples", 1, MOST_SAMPLES))
        factor = positive(self.acceptance_factor, "acceptance_factor")
        if not 1 / WIDEST_FACTOR <= factor <= WIDEST_FACTOR:
            raise Error(
                f"acceptance_factor: expected {1 / WIDEST_FACTOR:g} to {WIDEST_FACTOR:g}, "
                f"found {factor:g}"
            )
        object.__setattr__(self, "acceptance_factor", factor)
        if self.time_s is not None:
            time_s = within(self.time_s, "time_s", -_LONGEST_S, _LONGEST_S)
            object.__setattr__(self, "time_s", time_s)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Seen:
    """What the animal sees, and how it was rendered.

    samples, standard_error: as ``omma render --samples N --standard-error`` takes them, which gives
    these very numbers.
    """

    look: Look
    samples: int
    standard_error: bool
    responses: Floats32 | None
    """(N, C), linear, as `Renderer.render` gives them; None where receptors were asked for."""
    errors: Floats32 | None
    """(N, C), their standard errors."""
    receptors: Floats32 | None
    """(R,), as `Renderer.render_receptors` gives them."""
    receptor_errors: Floats32 | None
    seconds: float

    @property
    def rays(self) -> int:
        """Of each ommatidium, in all."""
        return self.samples * (error_scrambles if self.standard_error else 1)


def finer(seen: Seen) -> tuple[int, bool] | None:
    """Samples and whether with errors of the next, finer frame of what holds still; None after the
    last: first the same rays eight times over, which has an error, then twice as many and so on."""
    if not seen.standard_error:
        return seen.samples, True
    return (2 * seen.samples, True) if 2 * seen.samples <= _FINEST else None


class Looker:
    """A world and an eye, ready to be looked through; one thread at a time.

    Args:
        world: what there is to see.
        eye: who sees it.
        ultraviolet: of receptors, as `Renderer.render_receptors` takes it.
        animation: what the time is of, as `World.at` takes it.
        threads, options: as of `Renderer`; noise has to be frozen, as frames have no numbers here.

    Raises:
        omma.Error: noise that is not frozen, or what `Renderer` raises.
    """

    def __init__(
        self,
        world: World,
        eye: Eye,
        *,
        ultraviolet: ArrayLike | None = None,
        animation: str | int | None = None,
        threads: int = 0,
        **options: Unpack[Options],
    ) -> None:
        expect(world, World, "world", "omma.World(omma.load_scene(...)) makes one")
        expect(eye, Eye, "eye", "omma.load_eye gives one")
        if options.get("noise", "frozen") != "frozen":
            raise Error("noise: expected frozen where an eye is looked through")
        self.world, self.eye = world, eye
        self.ultraviolet, self.animation = ultraviolet, animation
        self.options, self.threads = options, threads
        self._first = Renderer(world, eye, Fixed(1), threads=threads, **options)
        self._eyes: dict[float, Eye] = {1.0: eye}
        self._renderers: dict[tuple[int, float], Renderer] = {}
        self._time_s: float | None = None

    def eye_of(self, look: Look) -> Eye:
        """The eye with the acceptance angles that are set."""
        factor = look.acceptance_factor
        if factor not in self._eyes:
            plain = self._eyes[1.0]
            self._eyes = {1.0: plain, factor: set_acceptance(plain, factor=factor)}
        return self._eyes[factor]

    def renderer(self, look: Look, samples: int) -> Renderer:
        """The renderer of these settings; the last few are kept."""
        key = (samples, look.acceptance_factor)
        found = self._renderers.pop(key, None)
        if found is None:
            found = self._first.with_eye(self.eye_of(look), Fixed(samples))
            while len(self._renderers) >= _KEPT_RENDERERS:
                self._renderers.pop(next(iter(self._renderers)))
        self._renderers[key] = found
        return found

    def go_to_time(self, time_s: float | None) -> bool:
        """Put what the scene's animations move where it is then; whether anything was to be put."""
        if time_s is None or time_s == self._time_s:
            return False
        self.world.at(time_s, self.animation)
        self._time_s = time_s
        return True

    def see(
        self,
        look: Look,
        samples: int | None = None,
        standard_error: bool = False,
        progress: Progress | None = None,
    ) -> Seen:
        """What is seen with these settings.

        Raises:
            omma.Error: what `Renderer.render` and `World.at` raise.
        """
        rays = look.samples if samples is None else samples
        self.go_to_time(look.time_s)
        renderer = self.renderer(look, rays)
        start = time.perf_counter()
        poses = look.pose.world_from_head
        found: list[Floats32 | None] = [None] * 4
        at = 2 if look.receptors else 0
        if look.receptors and standard_error:
            found[2:] = renderer.render_receptors(
                poses, ultraviolet=self.ultraviolet, standard_error=True, progress=progress
            )
        elif look.receptors:
            found[2] = renderer.render_receptors(
                poses, ultraviolet=self.ultraviolet, progress=progress
            )
        elif standard_error:
            found[:2] = renderer.render(poses, standard_error=True, progress=progress)
        else:
            found[0] = renderer.render(poses, progress=progress)
        one = [None if each is None else each[0] for each in found]
        assert one[at] is not None
        seconds = time.perf_counter() - start
        return Seen(look, rays, standard_error, one[0], one[1], one[2], one[3], seconds)

    def picture(
        self,
        look: Look,
        width: int,
        height: int,
        samples: int = 1,
        yfov_deg: float = 75.0,
        progress: Progress | None = None,
    ) -> Floats32:
        """A plain camera's picture from where the head is: (height, width, C), linear."""
        self.go_to_time(look.time_s)
        camera = Camera(
            type="perspective",
            world_from_camera=look.pose.world_from_head,
            yfov_rad=np.radians(yfov_deg),
            aspect_ratio=width / height,
        )
        return render_camera(
            self.world, camera, width=width, height=height, samples=samples, progress=progress
        )

    @property
    def duration_s(self) -> float:
        """Of the longest of the scene's animations; 0 where there is none."""
        return max((one.duration_s for one in self.world.scene.animations), default=0.0)
