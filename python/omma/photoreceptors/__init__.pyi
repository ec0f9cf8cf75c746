from .impulse_response import ImpulseResponse

__all__ = [
    "ImpulseResponse",
]
