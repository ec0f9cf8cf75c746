from .report import SamplingReport
from .settings import Settings

__all__ = [
    "SamplingReport",
    "Settings",
]
