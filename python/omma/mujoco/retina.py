"""A retina for FlyGym 2: its call, its shape and its ommatidia, with an eye's optics.

FlyGym makes a picture with a MuJoCo camera at each eye, bends it as a fisheye lens does and takes
the mean of the pixels of each hexagon of a map. Here every ommatidium looks along the mean
direction of its hexagon, with a round Gaussian acceptance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import checked
from omma.mujoco.fly_eyes import fly_eye, flygym_retina
from omma.mujoco.models import checked_data, checked_model
from omma.mujoco.moving import update
from omma.mujoco.poses import camera
from omma.mujoco.scenes import world_from_model
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed

# Geoms that FlyGym hides from the eyes are in groups 1 and 2: marks of sensors, and the fly's head.
_SEEN_GROUPS = (0,)
# What a readout takes: green where an ommatidium is yellow, blue where it is pale.
_CHANNEL_OF = (1, 2)


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
        retina = getattr(simulation, "retina", None) or flygym_retina("FlyRetina")
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
