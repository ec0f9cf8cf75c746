from .agents import render_agents
from .card_array import CardArray
from .gradients import Jacobian
from .jax_responses import jax_responses
from .panoramas import PanoramaView, see_panorama
from .picture_layouts import CubeFaces, Equirectangular, Fisheye
from .read_back import load_responses
from .report import SamplingReport
from .settings import Settings
from .torch_responses import torch_responses
from .truth import GroundTruth
from .ultraviolet import UltravioletDependence, ultraviolet_dependence

__all__ = [
    "CardArray",
    "CubeFaces",
    "Equirectangular",
    "Fisheye",
    "GroundTruth",
    "Jacobian",
    "PanoramaView",
    "SamplingReport",
    "Settings",
    "UltravioletDependence",
    "jax_responses",
    "load_responses",
    "render_agents",
    "see_panorama",
    "torch_responses",
    "ultraviolet_dependence",
]
