from .mosaic import OmmatidiumType, assign_receptors, honeybee_ommatidia, up_towards
from .sensitivity import (
    ReceptorType,
    govardovskii,
    microvillus_direction,
    ommatidium_of_receptor,
    optical_sensitivity,
    receptor_axis,
    receptor_matrix,
    receptor_optical_sensitivity,
    spectral_sensitivity,
)

__all__ = [
    "OmmatidiumType",
    "ReceptorType",
    "assign_receptors",
    "govardovskii",
    "honeybee_ommatidia",
    "microvillus_direction",
    "ommatidium_of_receptor",
    "optical_sensitivity",
    "receptor_axis",
    "receptor_matrix",
    "receptor_optical_sensitivity",
    "spectral_sensitivity",
    "up_towards",
]
