from .read_back import load_responses
from .report import SamplingReport
from .settings import Settings

__all__ = [
    "SamplingReport",
    "Settings",
    "load_responses",
]
