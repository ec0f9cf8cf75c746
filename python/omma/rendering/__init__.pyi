from .read_back import load_responses
from .report import SamplingReport

__all__ = [
    "SamplingReport",
    "load_responses",
]
