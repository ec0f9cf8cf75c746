"""Bars and edges that go around the head."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omma._core import Scene
from omma.base.arguments import checked, within
from omma.base.arrays import Floats
from omma.base.values import value_class
from omma.scene.paint import painted_scene
from omma.stimuli.checks import angle_deg, check_fields, radiance_of
from omma.stimuli.shapes import longitude_latitude_deg, sphere_patch
from omma.stimuli.turning import Turning


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Bar(Turning):
    """A bar before an even background that goes around the head: part of a sphere between two
    meridians and two parallels about the poles that lie across its direction of motion.

    Args:
        width_deg: longitude that it covers, in its direction of motion.
        height_deg: latitude that it covers, half of it on either side of straight ahead; 180 is
            from pole to pole.
        speed_deg_s: of its longitude; below 0 it goes the other way.
        azimuth_deg: longitude of its middle at time 0; 0 is ahead.
        direction_deg: where it goes as seen ahead: 0 is to the right, 90 upwards.
        bar: its radiance.
        background: radiance around it.
        name: of the thing that moves.

    Raises:
        omma.Error: a parameter out of its range.
    """

    width_deg: float = 10.0
    height_deg: float = 180.0
    speed_deg_s: float = 60.0
    azimuth_deg: float = 0.0
    direction_deg: float = 0.0
    bar: float = 0.0
    background: float = 0.5
    name: str = "bar"

    def __post_init__(self) -> None:
        check_fields(self, width_deg=(0.01, 359.9), height_deg=(0.01, 180.0), bar=radiance_of)

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        longitude, latitude = longitude_latitude_deg(
            directions, float(self._drift_deg(time_s)), self.direction_deg
        )
        on_bar = np.abs(longitude) <= self.width_deg / 2
        on_bar &= np.abs(latitude) <= self.height_deg / 2
        return np.where(on_bar, self.bar, self.background)

    def _drift_deg(self, time_s: Floats | float) -> Floats:
        return np.asarray(self.azimuth_deg + super()._drift_deg(time_s))

    def _scene(self) -> Scene:
        half_width, half_height = self.width_deg / 2, self.height_deg / 2
        surface, _ = sphere_patch((-half_width, half_width), (-half_height, half_height))
        return painted_scene([("bar", surface, (self.bar,) * 3)], self.name, (0, 0, 0))


@checked
def edge(
    speed_deg_s: float = 60.0,
    azimuth_deg: float = 0.0,
    *,
    direction_deg: float = 0.0,
    behind: float = 0.0,
    ahead: float = 0.5,
    name: str = "edge",
) -> Bar:
    """An edge that goes around the head, a bar of 180°: what lies ahead of it takes the radiance
    that is behind it. The other side of the bar follows half a turn later.

    Args:
        speed_deg_s: above 0.
        azimuth_deg: longitude of the edge at time 0; 0 is ahead.
        direction_deg: where it goes as seen ahead: 0 is to the right, 90 upwards.
        behind, ahead: radiance; an OFF edge, which darkens, where ``behind`` is the lesser one.
        name: of the thing that moves.

    Raises:
        omma.Error: a parameter out of its range.
    """
    speed = within(speed_deg_s, "speed_deg_s", 0.0, 1e6)
    middle = angle_deg(azimuth_deg, "azimuth_deg") - 90
    return Bar(
        180.0,
        180.0,
        speed,
        middle,
        direction_deg,
        radiance_of(behind, "behind"),
        radiance_of(ahead, "ahead"),
        name,
    )
