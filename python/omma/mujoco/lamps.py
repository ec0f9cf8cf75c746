"""MuJoCo's lights as lamps. Its lights have no unit; what they stand for is a rule of ours, told in
docs/mujoco.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import PunctualLight
from omma.base.directions import tangents
from omma.mujoco.models import names_of

# mjtLightType
_SPOT, _DIRECTIONAL, _POINT = 0, 1, 2


def lamps_of(model: Any, data: Any, colors_of: Any, lux: float) -> list[PunctualLight]:
    """The lights that are on, as lamps.

    Args:
        colors_of: a function from the model's colours to linear ones.
        lux: the illuminance of what faces a light of diffuse colour 1.
    """
    found = []
    for index, name in enumerate(names_of(model, "light", model.nlight)):
        kind = int(model.light_type[index])
        color = np.clip(colors_of(np.asarray(model.light_diffuse[index], float)), 0, None)
        if not model.light_active[index] or kind not in _TYPES or not color.any():
            continue
        position = np.asarray(data.light_xpos[index], float)
        more: dict[str, Any] = {}
        intensity = lux
        if kind != _DIRECTIONAL:
            candela = float(model.light_intensity[index])
            intensity = candela or lux * _square_over_fading(model, index, position)
        cutoff = float(model.light_cutoff[index])
        if kind == _SPOT and cutoff < 90:
            more["outer_cone_rad"] = np.radians(cutoff)
            fades = float(model.light_exponent[index]) > 0
            more["inner_cone_rad"] = 0.0 if fades else 0.999 * np.radians(cutoff)
        found.append(
            PunctualLight(
                name,
                type="point" if kind == _SPOT and cutoff >= 90 else _TYPES[kind],
                color=color,
                intensity=intensity,
                world_from_light=_looking(position, np.asarray(data.light_xdir[index], float)),
                **more,
            )
        )
    return found


_TYPES = {_SPOT: "spot", _DIRECTIONAL: "directional", _POINT: "point"}


def _square_over_fading(model: Any, light: int, position: NDArray[np.float64]) -> float:
    """What makes candelas of lux: the illuminance at the model's middle is then MuJoCo's there."""
    distance = float(np.linalg.norm(position - np.asarray(model.stat.center, float)))
    distance = max(distance, 1e-3 * float(model.stat.extent))
    fading = np.asarray(model.light_attenuation[light], float) @ (1, distance, distance**2)
    return distance**2 / max(float(fading), 1e-9)


def _looking(position: NDArray[np.float64], along: NDArray[np.float64]) -> NDArray[np.float64]:
    """``world_from_light``, whose -Z is a direction."""
    back = -along / max(float(np.linalg.norm(along)), 1e-12)
    found = np.eye(4)
    found[:3, :3] = np.stack([*tangents(back), back], 1)
    found[:3, 3] = position
    return found
