from .again import render_like
from .all_cameras import AllCamerasReport, CameraReport, render_all_cameras
from .reports import RenderReport

__all__ = [
    "AllCamerasReport",
    "CameraReport",
    "RenderReport",
    "render_all_cameras",
    "render_like",
]
