"""Drifting gratings, sine and square, on a drum, a sphere and a plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Scene
from omma.base.arguments import array_of, checked, whole, within
from omma.base.arrays import Floats
from omma.base.values import value_class
from omma.scene.paint import Surface, painted_scene
from omma.scene.solids import tube
from omma.stimuli.checks import angular_speed, check_fields, chosen_from, length_m
from omma.stimuli.gaussian import field_directions
from omma.stimuli.jumps import Motion, half_turn_s, turning, whole_counts
from omma.stimuli.shapes import drifted, grey, longitude_latitude_deg, right_and_up, sphere_patch
from omma.stimuli.stimulus import Stimulus
from omma.stimuli.turning import Turning

Waveform = Literal["sine", "square"]

# Pixels of a period of a sine: between them it is interpolated, to 2e-5 of its amplitude.
_PIXELS = 512
# Flat sides of a drum: longitudes are then right to 1e-7 degrees.
_SIDES = 360


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class DrumGrating(Stimulus):
    """Vertical stripes on an upright drum around the head that turns: mean x (1 + contrast x wave).

    Args:
        wavelength_deg: λ, azimuth of a period, 360° over a whole number.
        temporal_frequency_hz: f, periods a second past any azimuth; the drum turns by f λ a second.
        waveform: "sine", or "square", bright over half of each period.
        contrast: (most - least) / (most + least), Michelson's, 0 to 1.
        mean: radiance; 0 only without a contrast.
        direction: where it drifts as seen ahead, "right" or "left".
        phase_deg: of the wave ahead at time 0, where 0 is a sine's zero on its way up to the right.
        radius_m, height_m: of the drum. It covers elevations up to atan(height / 2 radius).
        background: radiance above and below it.
        name: of the thing that turns.

    Example:
        >>> grating = omma.stimuli.DrumGrating(wavelength_deg=20, temporal_frequency_hz=2)
        >>> ahead = [[0, 0, -1]]
        >>> grating.expected(ahead, np.radians(5), [0, 0.125, 0.25]).round(3).ravel().tolist()
        [0.5, 0.1, 0.5]

    Raises:
        omma.Error: a parameter out of its range.
    """

    wavelength_deg: float = 20.0
    temporal_frequency_hz: float = 1.0
    waveform: Waveform = "sine"
    contrast: float = 1.0
    mean: float = 0.5
    direction: Literal["right", "left"] = "right"
    phase_deg: float = 0.0
    radius_m: float = 1.0
    height_m: float = 4.0
    background: float = 0.5
    name: str = "drum"

    def __post_init__(self) -> None:
        check_fields(
            self,
            wavelength_deg=_of_whole_periods,
            direction=chosen_from("right", "left"),
            radius_m=length_m,
            height_m=length_m,
        )

    def _transforms(self, times_s: Floats) -> Floats:
        return drifted(self._drift_deg(times_s), 0.0)[:, None]

    def _velocities(self, times_s: Floats) -> Motion:
        return turning(np.full(len(times_s), self._speed_deg_s), 0.0)

    @property
    def _longest_step_s(self) -> float:
        return half_turn_s(self._speed_deg_s)

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        vectors = directions
        azimuth, elevation = longitude_latitude_deg(vectors, 0.0, 0.0)
        phase = (azimuth - self._drift_deg(time_s)) / self.wavelength_deg
        return np.where(self._inside(elevation), wave(self, phase), self.background)

    def _inside(self, elevation_deg: Floats) -> NDArray[np.bool_]:
        most = np.degrees(np.arctan2(self.height_m / 2, self.radius_m))
        return np.asarray(np.abs(elevation_deg) <= most)

    @property
    def _speed_deg_s(self) -> float:
        sign = 1 if self.direction == "right" else -1
        return sign * self.wavelength_deg * self.temporal_frequency_hz

    def _drift_deg(self, time_s: Floats | float) -> Floats:
        sign = 1 if self.direction == "right" else -1
        return sign * _turned_deg(self, time_s)

    def _expected(self, axes: Floats, acceptance_rad: Floats, times_s: Floats) -> Floats:
        if self.waveform == "square":
            return super()._expected(axes, acceptance_rad, times_s)

        def periods_at(directions: Floats) -> tuple[Floats, NDArray[np.bool_]]:
            azimuth, elevation = longitude_latitude_deg(directions, 0.0, 0.0)
            return azimuth / self.wavelength_deg, self._inside(elevation)

        drift = self._drift_deg(times_s) / self.wavelength_deg
        return _sine_means(self, axes, acceptance_rad, drift, periods_at)

    def _scene(self) -> Scene:
        positions, triangles, coordinates = tube(self.radius_m, self.height_m, _SIDES, inward=True)
        periods = (coordinates[:, 0] - 0.5) * 360 / self.wavelength_deg
        return _striped((positions, triangles, coordinates), periods, self)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class SphereGrating(Turning):
    """A grating all around the head, along the meridians of a sphere whose poles lie across its
    direction of motion: mean x (1 + contrast x wave of longitude).

    On the great circle through straight ahead in the direction of motion it is a grating of one
    dimension; away from it its stripes are narrower, by the cosine of the latitude.

    Args:
        wavelength_deg: λ, longitude of a period, 360° over a whole number.
        temporal_frequency_hz: f, periods a second.
        waveform, contrast, mean, phase_deg: as of `DrumGrating`.
        direction_deg: where it drifts as seen ahead: 0 is to the right, 90 upwards.
        background: radiance behind it, which nobody sees.
        name: of the thing that turns.

    Raises:
        omma.Error: a parameter out of its range.
    """

    wavelength_deg: float = 20.0
    temporal_frequency_hz: float = 1.0
    waveform: Waveform = "sine"
    contrast: float = 1.0
    mean: float = 0.5
    direction_deg: float = 0.0
    phase_deg: float = 0.0
    background: float = 0.5
    name: str = "sphere"

    def __post_init__(self) -> None:
        check_fields(self, wavelength_deg=_of_whole_periods)

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        longitude, _ = longitude_latitude_deg(directions, 0.0, self.direction_deg)
        return wave(self, (longitude - self._drift_deg(time_s)) / self.wavelength_deg)

    @property
    def _turning_deg_s(self) -> float:
        return self.wavelength_deg * self.temporal_frequency_hz

    def _drift_deg(self, time_s: Floats | float) -> Floats:
        return _turned_deg(self, time_s)

    def _expected(self, axes: Floats, acceptance_rad: Floats, times_s: Floats) -> Floats:
        if self.waveform == "square":
            return super()._expected(axes, acceptance_rad, times_s)

        def periods_at(directions: Floats) -> tuple[Floats, NDArray[np.bool_]]:
            longitude, latitude = longitude_latitude_deg(directions, 0.0, self.direction_deg)
            return longitude / self.wavelength_deg, np.ones(len(latitude), bool)

        drift = self._drift_deg(times_s) / self.wavelength_deg
        return _sine_means(self, axes, acceptance_rad, drift, periods_at)

    def _scene(self) -> Scene:
        surface, azimuth_elevation = sphere_patch((-180.0, 180.0), (-90.0, 90.0))
        return _striped(surface, azimuth_elevation[:, 0] / self.wavelength_deg, self)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class PlaneGrating(Stimulus):
    """A grating on a flat rectangle: a screen ahead, a wall beside, the ground or a ceiling.

    Args:
        wavelength_m: λ, of a period.
        temporal_frequency_hz: f, periods a second; the grating goes by f λ metres a second.
        waveform, contrast, mean, phase_deg: as of `DrumGrating`, the phase at the plane's middle.
        direction_deg: where it drifts as seen in front of it: 0 is to the right, 90 upwards. Where
            its middle lies more than 45° above or below the horizon, of a ceiling and the ground, 0
            is to the right of who looks ahead, +x, and 90 ahead, -z along the plane.
        center_m: (3,), its middle; the plane looks at the origin from there.
        size_m: (2,), along directions 0 and 90. It moves by up to a period, with its edges, and
            then jumps back by one, which is no motion for `play` and `velocities`.
        background: radiance beside it.
        name: of the thing that moves.

    Raises:
        omma.Error: a parameter out of its range.
    """

    wavelength_m: float = 0.5
    temporal_frequency_hz: float = 1.0
    waveform: Waveform = "sine"
    contrast: float = 1.0
    mean: float = 0.5
    direction_deg: float = 0.0
    phase_deg: float = 0.0
    center_m: tuple[float, float, float] = (0.0, 0.0, -1.0)
    size_m: tuple[float, float] = (20.0, 20.0)
    background: float = 0.5
    name: str = "plane"

    def __post_init__(self) -> None:
        check_fields(self, wavelength_m=length_m, center_m=_middle, size_m=_size)
        if max(self.size_m) > 1e5 * self.wavelength_m:
            raise Error(f"size_m: expected at most 100,000 periods, found {max(self.size_m):g} m")

    def _transforms(self, times_s: Floats) -> Floats:
        along, _, _ = self._frame()
        transforms = np.broadcast_to(np.eye(4), (len(times_s), 4, 4)).copy()
        shift = self._shift_m(times_s)
        transforms[:, :3, 3] = np.array(self.center_m) + shift[:, None] * along
        return np.asarray(transforms[:, None])

    def _velocities(self, times_s: Floats) -> Motion:
        along, _, _ = self._frame()
        speed = self.wavelength_m * self.temporal_frequency_hz
        linear = np.broadcast_to(speed * along, (len(times_s), 1, 3)).copy()
        return linear, np.zeros_like(linear)

    def _jumps_s(self, first_s: float, last_s: float) -> Floats:
        return whole_counts(0.0, self.temporal_frequency_hz, first_s, last_s)

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        along, right, up = self._frame()
        center = np.array(self.center_m)
        distance = np.linalg.norm(center)
        ahead = directions @ (center / distance)
        with np.errstate(divide="ignore", invalid="ignore"):
            points = np.where(ahead > 0, distance / ahead, np.nan)[..., None] * directions - center
        shift = self._shift_m(time_s)
        within_x = np.abs((points - shift * along) @ right) <= self.size_m[0] / 2
        within_y = np.abs((points - shift * along) @ up) <= self.size_m[1] / 2
        phase = (points @ along - shift) / self.wavelength_m
        return np.where(within_x & within_y, wave(self, np.nan_to_num(phase)), self.background)

    def _frame(self) -> tuple[Floats, Floats, Floats]:
        """Directions: where it drifts; where drifts of 0 and 90 degrees go."""
        right, up = right_and_up(np.array(self.center_m))
        angle = np.radians(self.direction_deg)
        along = np.cos(angle) * right + np.sin(angle) * up
        return np.asarray(along), right, up

    def _shift_m(self, time_s: Floats | float) -> Floats:
        periods = np.mod(self.temporal_frequency_hz * np.asarray(time_s), 1.0)
        return np.asarray(self.wavelength_m * periods)

    def _scene(self) -> Scene:
        along, right, up = self._frame()
        signs = np.array([[-1, 1], [-1, -1], [1, -1], [1, 1]])
        half = np.array(self.size_m) / 2
        corners = (signs * half) @ np.stack([right, up])
        # Counterclockwise as seen in front, which is from the origin.
        order = 1 if np.cross(right, up) @ self.center_m < 0 else -1
        surface = corners, np.array([[0, 1, 2], [0, 2, 3]])[:, ::order], np.zeros((4, 2))
        return _striped(surface, corners @ along / self.wavelength_m, self)


Grating = DrumGrating | SphereGrating | PlaneGrating


@checked
def optomotor_drum(
    stripes: int = 18,
    speed_deg_s: float = 60.0,
    *,
    contrast: float = 1.0,
    mean: float = 0.5,
    height_deg: float = 60.0,
    name: str = "drum",
) -> DrumGrating:
    """The drum of optomotor experiments: black and white stripes, all alike, that turn.

    Args:
        stripes: bright ones, each as wide as the dark one beside it.
        speed_deg_s: of the drum, to the right where above 0.
        contrast, mean: as of `DrumGrating`.
        height_deg: elevation of the upper edge, above 0 and under 90; the drum reaches as far down.
        name: of the thing that turns.

    Example:
        >>> omma.stimuli.optomotor_drum(36, -45.0).temporal_frequency_hz
        4.5

    Raises:
        omma.Error: a parameter out of its range.
    """
    count = whole(stripes, "stripes", 1, 1800)
    speed = angular_speed(speed_deg_s, "speed_deg_s")
    highest = within(height_deg, "height_deg", 0.1, 89.0)
    return DrumGrating(
        360 / count,
        abs(speed) * count / 360,
        "square",
        contrast,
        mean,
        "left" if speed < 0 else "right",
        height_m=2 * float(np.tan(np.radians(highest))),
        name=name,
    )


def wave(grating: Grating, periods: Floats) -> Floats:
    """Radiance so many periods from where the wave is at its phase."""
    angle = 2 * np.pi * periods + np.radians(grating.phase_deg)
    if grating.waveform == "sine":
        shape = np.sin(angle)
    else:
        shape = np.where(np.mod(angle, 2 * np.pi) < np.pi, 1.0, -1.0)
    return np.asarray(grating.mean * (1 + grating.contrast * shape))


def _sine_means(
    grating: DrumGrating | SphereGrating,
    axes: Floats,
    acceptance_rad: Floats,
    drift: Floats,
    periods_at: Callable[[Floats], tuple[Floats, NDArray[np.bool_]]],
) -> Floats:
    """Means (T, N) of a sine over fields of view, when it has drifted by so many periods (T,).

    ``periods_at``: of directions, how many periods from its phase each is, and whether it is on it.
    One sum for all times, as a drift only turns its phase.
    """
    angle = -2 * np.pi * drift + np.radians(grating.phase_deg)
    means = np.empty((len(drift), len(axes)))
    for n, (axis, width) in enumerate(zip(axes, acceptance_rad, strict=True)):
        periods, is_on = periods_at(field_directions(axis, float(width)))
        turned = np.exp(2j * np.pi * periods[is_on]).sum() / len(periods)
        amplitude = np.imag(turned * np.exp(1j * angle))
        means[:, n] = grating.mean * (is_on.mean() + grating.contrast * amplitude)
        means[:, n] += (1 - is_on.mean()) * grating.background
    return means


def _striped(surface: Surface, periods: Floats, grating: Grating) -> Scene:
    """A surface with the wave on it, whose vertices lie so many periods (V,) from phase 0."""
    positions, triangles, _ = surface
    u = periods + grating.phase_deg / 360
    if grating.waveform == "sine":
        row = np.sin(2 * np.pi * (np.arange(_PIXELS) + 0.5) / _PIXELS)
    else:
        row = np.array([1.0, -1.0])
    picture = grey(grating.mean * (1 + grating.contrast * row))
    coordinates = np.stack([u, np.full_like(u, 0.5)], -1)
    return painted_scene(
        [("waveform", (positions, triangles, coordinates), picture)],
        grating.name,
        (0, 0, 0),
        wrap_u="repeat",
        sharp=grating.waveform == "square",
    )


def _middle(value: ArrayLike, name: str) -> tuple[float, ...]:
    center = array_of(value, name, (3,))
    if not 1e-3 <= np.linalg.norm(center) <= 1e6:
        raise Error(f"{name}: expected 0.001 to 1e6 m from the origin, found {center.tolist()}")
    return tuple(center.tolist())


def _size(value: ArrayLike, name: str) -> tuple[float, ...]:
    return tuple(length_m(one, name) for one in array_of(value, name, (2,)))


def _of_whole_periods(value: float, name: str) -> float:
    wavelength = within(value, name, 0.2, 360.0)
    count = round(360 / wavelength)
    if abs(360 / wavelength - count) > 1e-6 * count:
        raise Error(
            f"{name}: expected 360 over a whole number, found {wavelength:g}; next to it "
            f"are {360 / (count + 1):g}, {360 / count:g}"
        )
    return 360 / count


def _turned_deg(grating: DrumGrating | SphereGrating, time_s: Floats | float) -> Floats:
    """By how much it has turned since time 0, without whole turns."""
    # Not without whole periods: between frames that would be a turn back.
    periods_around = round(360 / grating.wavelength_deg)
    periods = np.mod(grating.temporal_frequency_hz * np.asarray(time_s), periods_around)
    return np.asarray(grating.wavelength_deg * periods)
