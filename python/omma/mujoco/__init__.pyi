from .fly_eyes import fly_eye
from .moving import moving_things, update
from .pictures import PictureRetina
from .poses import camera, head_pose
from .retina import FlyRetina
from .scenes import scene_from_model, world_from_model

__all__ = [
    "FlyRetina",
    "PictureRetina",
    "camera",
    "fly_eye",
    "head_pose",
    "moving_things",
    "scene_from_model",
    "update",
    "world_from_model",
]
