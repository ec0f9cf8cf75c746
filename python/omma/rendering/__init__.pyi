from .agents import render_agents
from .read_back import load_responses
from .report import SamplingReport
from .settings import Settings
from .truth import GroundTruth

__all__ = [
    "GroundTruth",
    "SamplingReport",
    "Settings",
    "load_responses",
    "render_agents",
]
