"""What tests of detection share: one receptor of each type of a honeybee in given directions,
lights, and closed forms of what one Gaussian ommatidium sees of a disc."""

import math

import numpy as np

import omma

WIDTH_RAD = math.radians(2.6)
DIM, LIGHT, BRIGHT = (omma.light.uniform_sky(radiance) for radiance in (1e13, 1e16, 3e18))


def bee(axes=((0.0, 0.0, -1.0),), width_rad=WIDTH_RAD):
    """Ommatidia of one receptor of each type of a honeybee, at the head's middle."""
    types = omma.species.honeybee_worker().eye.receptor_types
    eye = omma.Eye(np.zeros((len(axes), 3)), axes, width_rad)
    return eye.replace(
        facet_diameter_m=np.full(len(axes), 20e-6),
        receptor_types=types,
        receptors=[range(len(types))] * len(axes),
    )


def catches(eye, reflectance, time_s, light=LIGHT):
    """Photons of each receptor before a wide surface of this grey in the light on level ground."""
    radiance = reflectance * sum(light.irradiance()) / math.pi
    matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
    return omma.receptors.photon_catch(
        eye, (matrix @ radiance)[eye.receptor_type], light, integration_time_s=time_s
    )


def share(distance_m, radius_m, width_rad=WIDTH_RAD):
    """Of a Gaussian's sensitivity on a disc in its middle. In the plane; on the sphere the share
    differs by less than Δρ²/10, 2e-4 of itself."""
    angle = math.atan2(radius_m, distance_m)
    return 1 - 2 ** -((2 * angle / width_rad) ** 2)


def root(function, low, high):
    """Where a falling function is 0."""
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return low
