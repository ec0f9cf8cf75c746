from .files import Camera
from .world import WorldInstance

__all__ = [
    "Camera",
    "WorldInstance",
]
