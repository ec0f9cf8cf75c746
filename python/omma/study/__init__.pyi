from .confidence import confidence_interval
from .plots import save_alias_curves, save_minimum_samples, save_speed_test, save_variance_map
from .search import Box, Cylinder, MinimumSamples, minimum_samples
from .speed_test import SpeedTest, measure_speed
from .variance import (
    Method,
    alias_curve,
    icosahedral_eye,
    rays_per_ommatidium,
    response_variances,
    solid_angles_sr,
    variance_map,
)

__all__ = [
    "Box",
    "Cylinder",
    "Method",
    "MinimumSamples",
    "SpeedTest",
    "alias_curve",
    "confidence_interval",
    "icosahedral_eye",
    "measure_speed",
    "minimum_samples",
    "rays_per_ommatidium",
    "response_variances",
    "save_alias_curves",
    "save_minimum_samples",
    "save_speed_test",
    "save_variance_map",
    "solid_angles_sr",
    "variance_map",
]
