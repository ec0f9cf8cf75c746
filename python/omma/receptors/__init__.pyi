from .band_error import BandError, band_error, natural_reflectances
from .catches import photon_catch, polarisation_weights
from .mosaic import OmmatidiumType, assign_receptors, honeybee_ommatidia, up_towards
from .rhabdoms import rhabdom_share
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
from .solid_angles import receptor_solid_angle_sr, solid_angle_sr

__all__ = [
    "BandError",
    "OmmatidiumType",
    "ReceptorType",
    "assign_receptors",
    "band_error",
    "govardovskii",
    "honeybee_ommatidia",
    "microvillus_direction",
    "natural_reflectances",
    "ommatidium_of_receptor",
    "optical_sensitivity",
    "photon_catch",
    "polarisation_weights",
    "receptor_axis",
    "receptor_matrix",
    "receptor_optical_sensitivity",
    "receptor_solid_angle_sr",
    "rhabdom_share",
    "solid_angle_sr",
    "spectral_sensitivity",
    "up_towards",
]
