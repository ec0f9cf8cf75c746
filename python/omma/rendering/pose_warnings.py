"""What is told of poses before or after a render."""

from __future__ import annotations

from omma import _core
from omma.base.poses import Matrices
from omma.base.warn import warn_caller


def warn_of_poses(engine: _core.Renderer | _core.World, poses: Matrices) -> None:
    """Tell the caller of the package what single precision loses at these poses, and which of them
    nobody means."""
    sentence = engine.precision_warning(poses)
    if sentence:
        warn_caller(sentence, RuntimeWarning)
    sentence = engine.pose_slip(poses)
    if sentence:
        warn_caller(sentence, UserWarning)
