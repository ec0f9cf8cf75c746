"""The eye that a scene's own camera names, where nobody gives another."""

from __future__ import annotations

import numpy as np

from omma._core import Camera, Error, Eye, Scene
from omma.base.files import metres_per_unit
from omma.picture.cameras import camera_eye

# Of single precision, in which files have their transforms.
_SAME_SCALE = 1e-5


def own_eye(
    scene: Scene, camera: str | None = None, unit: str | None = None
) -> tuple[Eye, Camera, str]:
    """The eye of that camera, or of the first that names one; the camera; and the unit with which
    its file gives this very eye, as ``--unit`` takes it: the camera's scale is in it.

    Raises:
        omma.Error: no camera names an eye, the camera stretches it one way more than another, or
            the eye is missing or broken.
    """
    node = scene.camera(camera) if camera is not None else None
    if node is None:
        node = next((one for one in scene.cameras if one.compound_structure), None)
    if node is None or not node.compound_structure:
        which = "no camera" if node is None else f"not the camera '{node.name}'"
        raise Error(
            f"eye: expected an eye file (--eye), as {which} of {scene.path or 'the scene'} names "
            "one"
        )
    scales = np.linalg.norm(node.world_from_camera[:3, :3], axis=0)
    if not np.allclose(scales, scales.mean(), rtol=_SAME_SCALE):
        raise Error(
            f"eye: the camera '{node.name}' stretches its eye by {scales.tolist()}, which the page "
            "cannot show; say the eye file (--eye)"
        )
    metres = metres_per_unit("m" if unit is None else unit)
    if abs(scales.mean() - 1) < _SAME_SCALE:
        return camera_eye(scene, node, metres), node, "m" if unit is None else unit
    metres *= float(scales.mean())
    return camera_eye(scene, node, metres), node, repr(metres)
