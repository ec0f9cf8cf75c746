"""Where to look from: the cameras and bodies of a model as poses."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Camera
from omma.base.arguments import checked, one_of, whole
from omma.mujoco.models import checked_data, names_of, transforms

# A head on a body that has +X ahead and +Z up, as bodies of animals have: its right is the body's
# -Y, its up +Z, its back -X.
_BODY_FROM_HEAD = np.array([[0.0, 0, -1, 0], [-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


@checked
def camera(data: Any, name_or_index: str | int) -> Camera:
    """A camera of a model where it is now: for `omma.render_camera`, and as a pose for eyes.

    MuJoCo's cameras look as Omma's do, along -Z with +Y up, so that ``world_from_camera`` is the
    pose of a head in a world of the same model.

    Args:
        data: `mujoco.MjData`, with positions computed.
        name_or_index: of the camera; an unnamed one is "camera 2".

    Raises:
        omma.Error: no such camera, or data without positions.
    """
    model = checked_data(data).model
    index = _index(model, "camera", model.ncam, name_or_index)
    return cameras(model, data)[index]


@checked
def head_pose(data: Any, body: str | int) -> NDArray[np.float64]:
    """The pose ``world_from_head`` (4, 4) of a head that looks as a body does: ahead along the
    body's +X with its +Z up, from the body's origin.

    For a head elsewhere on it multiply: ``head_pose(data, "thorax") @ body_head_from_head``.

    Args:
        data: `mujoco.MjData`, with positions computed.
        body: its name or index.

    Raises:
        omma.Error: no such body, or data without positions.
    """
    model = checked_data(data).model
    index = _index(model, "body", model.nbody, body)
    world_from_body = transforms(data.xpos[index : index + 1], data.xmat[index : index + 1])[0]
    return np.asarray(world_from_body @ _BODY_FROM_HEAD)


def cameras(model: Any, data: Any) -> list[Camera]:
    """All cameras of a model, where they are."""
    world_from_camera = transforms(data.cam_xpos, data.cam_xmat)
    near, far = (float(end) * float(model.stat.extent) for end in
                 (model.vis.map.znear, model.vis.map.zfar))  # fmt: skip
    flat = (
        np.asarray(model.cam_projection).astype(int)
        if hasattr(model, "cam_projection")
        else (np.asarray(model.cam_orthographic).astype(int))
    )
    found = []
    for index, name in enumerate(names_of(model, "camera", model.ncam)):
        height = float(model.cam_fovy[index])
        found.append(
            Camera(
                name,
                type="orthographic" if flat[index] else "perspective",
                world_from_camera=world_from_camera[index],
                yfov_rad=1.0 if flat[index] else np.radians(height),
                xmag_m=height / 2 if flat[index] else 1.0,
                ymag_m=height / 2 if flat[index] else 1.0,
                znear_m=near,
                zfar_m=far,
            )
        )
    return found


def _index(model: Any, kind: str, count: int, name_or_index: str | int) -> int:
    if not isinstance(name_or_index, str):
        return whole(name_or_index, kind, 0, count - 1)
    names = names_of(model, kind, count)
    return names.index(one_of(name_or_index, names, kind))
