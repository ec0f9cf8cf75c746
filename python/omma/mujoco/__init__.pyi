from .moving import update
from .poses import camera, head_pose
from .retina import FlyRetina, fly_eye
from .scenes import scene_from_model, world_from_model

__all__ = [
    "FlyRetina",
    "camera",
    "fly_eye",
    "head_pose",
    "scene_from_model",
    "update",
    "world_from_model",
]
