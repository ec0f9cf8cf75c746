"""Light in bands as the colours that people see it in."""

from __future__ import annotations

import weakref

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, expect
from omma.light import Light, watts_from_photons
from omma.scene.spectrum_colours import colour_matching
from omma.scene.world import World

Floats = NDArray[np.float64]

# Linear sRGB of CIE 1931 XYZ (IEC 61966-2-1).
_RGB_FROM_XYZ = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)


@checked
def bands_to_rgb(radiance: ArrayLike, light: Light) -> NDArray[np.float32]:
    """Spectral radiance as linear sRGB, as the CIE's standard observer of 1931 sees it.

    A white matt surface on level ground has luminance 1 in that light, and the colour of the light
    itself: nobody's adaptation is assumed. Colours that no screen has come out below 0. The colour
    matching functions are the fits of Wyman, Sloan and Shirley (JCGT 2(2), 2013).

    Args:
        radiance: (..., B), in the light's bands and unit, as a world that is lit by it is seen.
        light: what lights the world.

    Example:
        >>> light = omma.light.overcast_sky(40)
        >>> white = sum(light.irradiance()) / np.pi
        >>> float(omma.picture.bands_to_rgb(white, light) @ [0.2126, 0.7152, 0.0722]).__round__(3)
        1.0

    Raises:
        omma.Error: another number of bands, or a light that gives the ground nothing to see by.
    """
    expect(light, Light, "light", "omma.light.clear_sky makes one")
    seen = array_of(radiance, "radiance")
    if seen.shape[-1:] != (len(light.bands),):
        raise Error(f"radiance: expected shape (..., {len(light.bands)}), found {seen.shape}")
    return np.asarray(seen @ _rgb_from_bands(light).T, np.float32)


# Of the light that was asked for last: its flux on the ground takes longer than a frame.
_last: tuple[weakref.ref[Light], Floats] | None = None


def _rgb_from_bands(light: Light) -> Floats:
    """What makes linear sRGB of radiance in a light's bands, (3, B)."""
    global _last
    kept = _last
    if kept is None or kept[0]() is not light:
        kept = (weakref.ref(light), _make_rgb_from_bands(light))
        _last = kept
    return kept[1]


def _make_rgb_from_bands(light: Light) -> Floats:
    bands = light.bands

    def seen_of_one(nm: NDArray[np.float64]) -> NDArray[np.float64]:
        # What the observer sees, (K, 3), of one photon or watt of each wavelength.
        power = watts_from_photons(1.0, nm) if light.unit == "photons" else np.ones_like(nm)
        return np.asarray((colour_matching(nm) * power).T)

    xyz_from_band = bands.mean(seen_of_one).T * bands.widths_nm
    white = float(xyz_from_band[1] @ sum(light.irradiance())) / np.pi
    if not white > 0:
        raise Error("light: expected one that lights the ground from 400 to 700 nm, found none")
    return np.asarray(_RGB_FROM_XYZ @ xyz_from_band / white)


def colours_of(world: World, responses: NDArray[np.float32]) -> NDArray[np.float32]:
    """What was seen in a world, (..., band), in colours for a picture: as they are, or where the
    world is lit as people see them."""
    return responses if world.light is None else bands_to_rgb(responses, world.light)
