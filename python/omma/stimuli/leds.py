"""A cylinder of LED panels around the head, as arenas for tethered flies have it.

After Reiser & Dickinson 2008, J Neurosci Methods 167:127. What is known of their panels is from the
documentation of the system by its authors ("Panels System", Generation 2, Modular LED Displays,
reiserlab.github.io): 8 x 8 LEDs, a refresh of 4 kHz that is shared among the time slices of grey
levels, 12 panels around. That panels are 32 mm wide is said of Generation 3, which took over their
boards.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Image, Instance, Material, Mesh, Scene, Texture
from omma.base.arguments import within
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.base.poses import Matrices
from omma.base.progress import Progress
from omma.base.values import value_class
from omma.scene.solids import tube
from omma.stimuli.checks import check_fields, whole_from
from omma.stimuli.held import ROUNDING, Held
from omma.stimuli.jumps import Motion, whole_counts
from omma.stimuli.leds_told import (
    RangeShown,
    jumps_at_seam,
    tell_of_frames,
    tell_of_levels,
    tell_of_pixels,
    tell_of_seam,
)
from omma.stimuli.shapes import grey
from omma.stimuli.stimulus import Renderer, Stimulus, as_times

# LEDs of a panel, across and up.
_LEDS = 8
_PANEL_M = 0.032
# Of a panel whose LEDs are on or off, Hz; grey levels share it.
_SCAN_HZ = 4000.0
_MOST_FRAMES = 20_000
# Pixels of all frames, a byte each.
_MOST_PIXELS = 1 << 28


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class LedArena(Stimulus):
    """Another stimulus as an arena of LEDs shows it: in pixels, in few grey levels, and held from
    one refresh to the next.

    Flat panels of 8 x 8 LEDs stand in a ring, a joint of two ahead where their number is even. Each
    pixel has the radiance of the stimulus in the direction of its middle, rounded to the nearest of
    2^bits levels from 0 to ``brightest``. As in the arenas the frames are prepared, one for each
    refresh of ``duration_s``, and come again after it; each that differs is a drum of its own,
    all but one of which are out of sight.

    With an impulse response `play` adds up the frames that it sees, each as it stands times the
    integral of the response over the time for which it was there: exactly, however few the rays.

    A pixel lights all of its square all the time: neither the gaps between LEDs nor the time slices
    in which rows and grey levels are lit are shown. Light that panels throw on each other is not.

    Args:
        shown: the stimulus.
        duration_s: after which frames come again, a period of it for example.
        bits: of grey levels, 1 to 8.
        refresh_hz: frames a second. None: that of the panels, 4000 / (2^bits - 1), 571 of 8 levels.
            A controller that sends new patterns to 48 panels manages 72 to 463.
        panels_around, panels_up: in the ring, and one above the other.
        brightest: radiance of an LED that is on.
        background: radiance above and below the panels.
        name: of the frames: they are called "leds 0", "leds 1" and so on.

    Example:
        >>> grating = omma.stimuli.DrumGrating(wavelength_deg=30, temporal_frequency_hz=2)
        >>> arena = omma.stimuli.LedArena(grating, duration_s=0.5, refresh_hz=100)
        >>> arena.pixels(0.1).shape
        (32, 96)

    Raises:
        omma.Error: a parameter out of its range, more than 20,000 frames or 268 million pixels in
                them all.
        TypeError: what is shown is no stimulus, or another arena.
    """

    shown: Stimulus
    duration_s: float = 1.0
    bits: int = 3
    refresh_hz: float | None = None
    panels_around: int = 12
    panels_up: int = 4
    brightest: float = 1.0
    background: float = 0.0
    name: str = "leds"

    def __post_init__(self) -> None:
        check_fields(
            self,
            shown=_other_than_an_arena,
            duration_s=(1e-6, 1e6),
            bits=whole_from(1, 8),
            refresh_hz=self._checked_refresh,
            panels_around=whole_from(3, 1000),
            panels_up=whole_from(1, 1000),
            brightest=(1e-6, 1e6),
        )
        if self.frame_count > _MOST_FRAMES:
            raise Error(
                f"duration_s: expected at most {_MOST_FRAMES:,} frames, found "
                f"{self.duration_s:g} s of {self.refresh_hz:g} Hz"
            )
        pixels = self.panels_around * self.panels_up * _LEDS**2
        if self.frame_count * pixels > _MOST_PIXELS:
            raise Error(
                f"panels_up: expected at most {_MOST_PIXELS:,} pixels in all frames, found "
                f"{self.frame_count:,} frames of {pixels:,}"
            )
        assert self.refresh_hz is not None
        tell_of_frames(self.shown, self.duration_s, self.refresh_hz, self.frame_count)
        tell_of_pixels(self.shown, self.panels_around * _LEDS)

    def _checked_refresh(self, value: float | None, name: str) -> float:
        refresh = _SCAN_HZ / (2**self.bits - 1) if value is None else value
        return within(refresh, name, 1e-3, 1e6)

    @property
    def frame_count(self) -> int:
        """Frames until they come again."""
        assert self.refresh_hz is not None
        return max(round(self.duration_s * self.refresh_hz), 1)

    @property
    def distance_m(self) -> float:
        """From the middle of the head to the middle of each panel."""
        return float(_PANEL_M / 2 / np.tan(np.pi / self.panels_around))

    @property
    def height_m(self) -> float:
        """Of the panels together."""
        return self.panels_up * _PANEL_M

    @property
    def names(self) -> list[str]:
        """Of the frames that differ."""
        return [f"{self.name} {number}" for number in range(len(self._different[0]))]

    def pixels(self, time_s: float) -> Floats:
        """Radiance of the pixels (rows, columns) at a time, s: row 0 at the top, the first column
        behind, the middle ones ahead."""
        frames, of_frame = self._different
        return self._radiance_of(frames[of_frame[self._frame(as_times([time_s]))[0]]])

    def _transforms(self, times_s: Floats) -> Floats:
        self._tell_of_seam(times_s)
        _, of_frame = self._different
        return self._showing(of_frame[self._frame(times_s)])

    def _tell_of_seam(self, times_s: Floats) -> None:
        rounds = self._refreshes(times_s) // self.frame_count
        if len(rounds) and np.ptp(rounds) and self._jumps_at_seam:
            tell_of_seam(self.frame_count)

    def _showing(self, frames: NDArray[np.int64]) -> Floats:
        """Where things are (M, K, 4, 4) when it shows these (M,) of the frames that differ."""
        # Out of sight is tiny and far below.
        away = np.diag([1e-6, 1e-6, 1e-6, 1.0])
        away[1, 3] = -10.0
        transforms = np.broadcast_to(away, (len(frames), len(self.names), 4, 4)).copy()
        transforms[np.arange(len(frames)), frames] = np.eye(4)
        return np.asarray(transforms)

    def _velocities(self, times_s: Floats) -> Motion:
        # What is shown stands still, and what moves is out of sight.
        none = np.zeros((len(times_s), len(self.names), 3))
        return none, none.copy()

    def _render_lasting(
        self,
        renderer: Renderer,
        times_s: Floats,
        matrices: Matrices,
        instances: list[int],
        progress: Progress | None,
    ) -> NDArray[np.float32]:
        settings, (_, of_frame) = renderer.settings, self._different
        assert settings.impulse_response is not None
        assert self.refresh_hz is not None
        before = times_s[:1] - settings.impulse_response.duration_s
        self._tell_of_seam(np.append(before, times_s))
        held = Held(
            times_s,
            matrices,
            settings.impulse_response,
            self.refresh_hz,
            lambda counts: of_frame[np.mod(counts, self.frame_count)],
            self._showing,
            settings.noise == "frozen",
        )
        return held.render(renderer.render, instances, progress)

    def _jumps_s(self, first_s: float, last_s: float) -> Floats:
        assert self.refresh_hz is not None
        times = whole_counts(ROUNDING, self.refresh_hz, first_s, last_s)
        _, of_frame = self._different
        after = np.rint(times * self.refresh_hz + ROUNDING).astype(np.int64)
        before, after = (of_frame[np.mod(k, self.frame_count)] for k in (after - 1, after))
        return np.asarray(times[before != after])

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        x, y, z = np.moveaxis(directions, -1, 0)
        sides = (np.arctan2(x, -z) / (2 * np.pi) + 0.5) * self.panels_around
        panel = np.clip(np.floor(sides).astype(int), 0, self.panels_around - 1)
        angle = (sides - panel - 0.5) * 2 * np.pi / self.panels_around
        along = 0.5 + self.distance_m * np.tan(angle) / _PANEL_M
        with np.errstate(divide="ignore"):
            height = self.distance_m / np.cos(angle) * y / np.hypot(x, z)
        picture = self.pixels(time_s)
        rows, columns = picture.shape
        column = panel * _LEDS + np.clip(np.floor(along * _LEDS).astype(int), 0, _LEDS - 1)
        inside = np.abs(height) < self.height_m / 2
        down = np.where(inside, 0.5 - height / self.height_m, 0.0)
        row = np.clip(np.floor(down * rows).astype(int), 0, rows - 1)
        return np.where(inside, picture[row, column % columns], self.background)

    def _frame(self, times_s: Floats) -> NDArray[np.int64]:
        """Number of the frame that is shown, (T,)."""
        return np.mod(self._refreshes(times_s), self.frame_count)

    def _refreshes(self, times_s: Floats) -> NDArray[np.int64]:
        """How many there have been since time 0, (T,)."""
        assert self.refresh_hz is not None
        return np.floor(times_s * self.refresh_hz + ROUNDING).astype(np.int64)

    @cached_property
    def _different(self) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
        """Levels of the frames that differ, (D, rows, columns), and which each is, (frames,)."""
        assert self.refresh_hz is not None
        towards = self._pixel_directions()
        most = 2**self.bits - 1
        range_shown = RangeShown()
        levels = np.empty((self.frame_count, *towards.shape[:2]), np.uint8)
        for number in range(self.frame_count):
            radiance = self.shown.radiance(towards, number / self.refresh_hz)
            range_shown.add(radiance)
            # Halves go up: of two levels a grey background is the bright one.
            levels[number] = np.clip(np.floor(radiance / self.brightest * most + 0.5), 0, most)
        tell_of_levels(range_shown, self.brightest, self.bits)
        frames, of_frame = np.unique(levels, axis=0, return_inverse=True)
        return frames, np.asarray(of_frame.reshape(-1), np.int64)

    @cached_property
    def _jumps_at_seam(self) -> bool:
        return jumps_at_seam(self.shown, *self._different)

    def _radiance_of(self, levels: NDArray[np.uint8]) -> Floats:
        return np.asarray(levels * (self.brightest / (2**self.bits - 1)))

    def _pixel_directions(self) -> Floats:
        """Directions to the middles of pixels, (rows, columns, 3)."""
        pitch = _PANEL_M / _LEDS
        panel, led = np.divmod(np.arange(self.panels_around * _LEDS), _LEDS)
        middle = 2 * np.pi * ((panel + 0.5) / self.panels_around - 0.5)
        along = (led + 0.5) * pitch - _PANEL_M / 2
        x = self.distance_m * np.sin(middle) + along * np.cos(middle)
        z = -self.distance_m * np.cos(middle) + along * np.sin(middle)
        y = self.height_m / 2 - (np.arange(self.panels_up * _LEDS) + 0.5) * pitch
        points = np.stack(np.broadcast_arrays(x, y[:, None], z), -1)
        return normalized(points)

    def _scene(self) -> Scene:
        corner = self.distance_m / np.cos(np.pi / self.panels_around)
        ring = tube(float(corner), self.height_m, self.panels_around, inward=True)
        positions, triangles, coordinates = ring
        frames, names = self._different[0], self.names
        count = range(len(frames))
        return Scene(
            meshes=[
                Mesh(positions, triangles, name=name, texture_coordinates=coordinates, material=one)
                for one, name in enumerate(names)
            ],
            instances=[Instance(one, name=name) for one, name in enumerate(names)],
            materials=[Material(name, base_color_texture=one) for one, name in enumerate(names)],
            images=[Image(grey(self._radiance_of(levels))) for levels in frames],
            textures=[Texture(one, "clamp_to_edge", "clamp_to_edge", "nearest") for one in count],
        )


def _other_than_an_arena(value: Stimulus, name: str) -> Stimulus:
    if not isinstance(value, Stimulus) or isinstance(value, LedArena):
        found = f"{type(value).__name__} {value!r:.40}"
        raise TypeError(f"{name}: expected a stimulus other than an arena, found {found}")
    return value
