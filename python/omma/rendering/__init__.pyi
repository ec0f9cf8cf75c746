from .report import SamplingReport

__all__ = [
    "SamplingReport",
]
