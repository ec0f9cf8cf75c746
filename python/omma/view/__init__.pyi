from .poses import HeadPose
from .state import Look, Seen
from .window import Window, show

__all__ = ["HeadPose", "Look", "Seen", "Window", "show"]
