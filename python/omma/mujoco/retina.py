"""A retina for FlyGym 2: its call, its shape and its ommatidia, with an eye's optics.

FlyGym makes a picture with a MuJoCo camera at each eye, bends it as a fisheye lens does and takes
the mean of the pixels of each hexagon of a map. Here every ommatidium looks along the mean
direction of its hexagon, with a round Gaussian acceptance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, positive, within
from omma.base.optional import needs
from omma.mujoco.models import checked_data, checked_model
from omma.mujoco.moving import update
from omma.mujoco.poses import camera
from omma.mujoco.scenes import world_from_model
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed

# What FlyGym 2.1 has in its vision.yaml.
_FOVY_DEG, _DISTORTION, _ZOOM = 157.0, 3.8, 2.72
# Geoms that FlyGym hides from the eyes are in groups 1 and 2: marks of sensors, and the fly's head.
_SEEN_GROUPS = (0,)
# What a readout takes: green where an ommatidium is yellow, blue where it is pale.
_CHANNEL_OF = (1, 2)


@checked
def fly_eye(
    ommatidia_id_map: ArrayLike,
    *,
    fovy_deg: float = _FOVY_DEG,
    distortion: float = _DISTORTION,
    zoom: float = _ZOOM,
    acceptance_angle_deg: float | None = None,
) -> Eye:
    """One eye of FlyGym's in the frame of its camera, an ommatidium for each hexagon of its map.

    Args:
        ommatidia_id_map: (H, W) whole numbers, which pixel of the bent picture is whose: 1 to N, 0
            nobody's.
        fovy_deg: vertical field of view of the camera.
        distortion, zoom: of the fisheye lens: a point r from the middle of the bent picture, in
            half sizes, is at r / zoom / (1 - distortion (r / zoom)²) in the camera's.
        acceptance_angle_deg: full width at half maximum. None: each ommatidium's mean angle to its
            neighbours.

    Raises:
        omma.Error: a map with numbers left out, or a number out of its range.
    """
    ids = array_of(ommatidia_id_map, "ommatidia_id_map", (None, None), np.int64)
    count = int(ids.max(initial=0))
    pixels = np.bincount(ids[ids > 0], minlength=count + 1)[1:]
    if count < 1 or ids.min() < 0 or not pixels.all():
        raise Error("ommatidia_id_map: expected each of 1 to N at least once, and 0 elsewhere")
    half = np.tan(np.radians(within(fovy_deg, "fovy_deg", 1, 179)) / 2)
    rows, columns = ids.shape
    row, column = np.nonzero(ids)
    scale = positive(zoom, "zoom")
    down = (2 * row - rows) / rows / scale
    right = (2 * column - columns) / columns / scale
    shrink = 1 - within(distortion, "distortion", 0, 1e6) * (down**2 + right**2)
    if shrink.min() <= 0:
        raise Error("distortion: expected one at which all of the map is before the lens")
    direction = np.stack(
        [half * columns / rows * right / shrink, -half * down / shrink, -np.ones(len(row))], -1
    )
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    axis = np.stack(
        [np.bincount(ids[row, column] - 1, direction[:, k], count) for k in range(3)], -1
    )
    eye = Eye(np.zeros((count, 3)), axis, 0.0)
    if acceptance_angle_deg is None:
        return eye.replace(acceptance_angle_rad=eye.interommatidial_angle_rad())
    width = positive(acceptance_angle_deg, "acceptance_angle_deg")
    return eye.replace(acceptance_angle_rad=np.radians(width))


class FlyRetina:
    """What FlyGym's flies see, by rays: `get_ommatidia_readouts` instead of the simulation's.

    The world is the model's, unlit, its numbers taken as light (``colors="linear"``): a readout is
    the mean colour of what an ommatidium sees, 0 to 1, without MuJoCo's lights and shades. Geoms in
    FlyGym's groups of hidden parts are left out.

    Args:
        simulation: a FlyGym 2 Simulation whose flies have vision.
        samples: rays for each ommatidium.
        acceptance_angle_deg: as of `fly_eye`.
        hidden: names of more geoms that are not seen.
        options: as of `omma.World`: ``threads``, ``backend``, ...

    Raises:
        omma.Error: no such simulation, or what `world_from_model` and `fly_eye` raise.
    """

    @checked
    def __init__(
        self,
        simulation: Any,
        *,
        samples: int = 16,
        acceptance_angle_deg: float | None = None,
        hidden: Sequence[str] = (),
        **options: Any,
    ) -> None:
        for name in ("mj_model", "mj_data", "world"):
            if not hasattr(simulation, name):
                raise Error(
                    "simulation: expected one of FlyGym 2, which has mj_model, mj_data and world, "
                    f"found {type(simulation).__name__}"
                )
        retina = getattr(simulation, "retina", None) or _flygym_retina()
        self.model = checked_model(simulation.mj_model)
        self._simulation = simulation
        self.cameras = {
            name: [one.name for one in fly.eyecameraname_to_mjcfcamera.values()]
            for name, fly in simulation.world.fly_lookup.items()
        }
        self.pale = np.asarray(retina.pale_type_mask).astype(bool)
        self.eye = fly_eye(
            retina.ommatidia_id_map,
            distortion=float(retina.distortion_coefficient),
            zoom=float(retina.zoom),
            fovy_deg=self._fovy_deg(),
            acceptance_angle_deg=acceptance_angle_deg,
        )
        if len(self.pale) != len(self.eye):
            raise Error(
                f"simulation: expected a type for each of {len(self.eye)} ommatidia, "
                f"found {len(self.pale)}"
            )
        data = checked_data(simulation.mj_data, self.model)
        self.world = world_from_model(
            self.model, data, groups=_SEEN_GROUPS, hidden=hidden, colors="linear", **options
        )
        self.renderer = Renderer(self.world, self.eye, Fixed(samples))

    def get_ommatidia_readouts(self, fly_name: str) -> NDArray[np.float32]:
        """What both eyes of a fly see now: (2, N, 2), left and right; yellow, pale.

        Each ommatidium is of one type and leaves the other's number 0.

        Args:
            fly_name: as in the simulation.

        Raises:
            omma.Error: no such fly, or one without eyes.
        """
        names = self.cameras.get(fly_name)
        if not names:
            known = ", ".join(name for name, eyes in self.cameras.items() if eyes) or "none"
            raise Error(f"fly_name: expected a fly with vision ({known}), found {fly_name!r}")
        data = self._simulation.mj_data
        update(self.world, data)
        poses = np.stack([camera(data, name).world_from_camera for name in names])
        return readouts(self.renderer.render(poses), self.pale)

    def install(self) -> FlyRetina:
        """Answer in the simulation's place: its own `get_ommatidia_readouts` is this one from now
        on, so that code for FlyGym sees by rays as it is. Its pictures (``get_raw_vision``) stay.

        One line does it, ``omma.mujoco.FlyRetina(simulation).install()``.
        """
        self._simulation.get_ommatidia_readouts = self.get_ommatidia_readouts
        return self

    def remove(self) -> None:
        """Undo `install`, if it was: the simulation sees by its pictures again."""
        mine = vars(self._simulation).get("get_ommatidia_readouts")
        if getattr(mine, "__self__", None) is self:
            del self._simulation.get_ommatidia_readouts

    def _fovy_deg(self) -> float:
        """That of the first eye's camera; all have the same."""
        for names in self.cameras.values():
            for name in names:
                return float(self.model.camera(name).fovy[0])
        raise Error("simulation: expected a fly with vision, found none: call fly.add_vision()")


def readouts(responses: NDArray[np.float32], pale: NDArray[np.bool_]) -> NDArray[np.float32]:
    """FlyGym's (P, N, 2) of linear RGB (P, N, 3) and which ommatidia are pale (N,)."""
    found = np.zeros((*responses.shape[:2], 2), np.float32)
    for index, channel in enumerate(_CHANNEL_OF):
        mine = pale == bool(index)
        found[:, mine, index] = responses[:, mine, channel]
    return found


def _flygym_retina() -> Any:
    return needs("flygym.vision.retina", "", "FlyRetina needs FlyGym 2").Retina()
