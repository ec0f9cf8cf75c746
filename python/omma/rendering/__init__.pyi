from .agents import render_agents
from .card_array import CardArray
from .read_back import load_responses
from .report import SamplingReport
from .settings import Settings
from .truth import GroundTruth
from .ultraviolet import UltravioletDependence, ultraviolet_dependence

__all__ = [
    "CardArray",
    "GroundTruth",
    "SamplingReport",
    "Settings",
    "UltravioletDependence",
    "load_responses",
    "render_agents",
    "ultraviolet_dependence",
]
