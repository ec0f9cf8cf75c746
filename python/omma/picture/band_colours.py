"""Light in bands as the colours that people see it in."""

from __future__ import annotations

import weakref

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Scene
from omma.base.arguments import array_of, checked, expect
from omma.base.arrays import Floats
from omma.light import Light
from omma.scene.white import emitted_luminance, white_luminance, xyz_from_bands
from omma.scene.world import World

# Linear sRGB of CIE 1931 XYZ (IEC 61966-2-1).
_RGB_FROM_XYZ = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)


@checked
def bands_to_rgb(
    radiance: ArrayLike, light: Light, scene: Scene | None = None
) -> NDArray[np.float32]:
    """Spectral radiance as linear sRGB, as the CIE's standard observer of 1931 sees it.

    A white matt surface on level ground has luminance 1 in that light, and the colour of the light
    itself: nobody's adaptation is assumed. Colours that no screen has come out below 0. The colour
    matching functions are the fits of Wyman, Sloan and Shirley (JCGT 2(2), 2013).
    `omma.picture.display` makes of a picture what `omma.save_png` takes.

    Args:
        radiance: (..., B), in the light's bands and unit, as a world that is lit by it is seen.
        light: what lights the world.
        scene: with lamps of its own. Where ``light`` gives the ground nothing, a white sheet that
            faces each lamp half the scene's size away has luminance 1; without lamps the brightest
            surface that shines.

    Example:
        >>> light = omma.light.overcast_sky(40)
        >>> white = sum(light.irradiance()) / np.pi
        >>> float(omma.picture.bands_to_rgb(white, light) @ [0.2126, 0.7152, 0.0722]).__round__(3)
        1.0

    Raises:
        omma.Error: another number of bands, or nothing to see by.
    """
    expect(light, Light, "light", "omma.light.clear_sky makes one")
    if scene is not None:
        return _product(radiance, light, _make_rgb_from_bands(light, scene, 1.0))
    global _last
    kept = _last
    if kept is None or kept[0]() is not light:
        kept = (weakref.ref(light), _make_rgb_from_bands(light, None, 1.0))
        _last = kept
    return _product(radiance, light, kept[1])


def colours_of(world: World, responses: ArrayLike) -> NDArray[np.float32]:
    """What was seen in a world, (..., band), in colours for a picture: as they are, or where the
    world is lit as people see them."""
    light = world.light
    if light is None:
        return np.asarray(responses, np.float32)
    if world not in _of_world:
        _of_world[world] = _make_rgb_from_bands(light, world.scene, world.emission_cd_m2)
    return _product(responses, light, _of_world[world])


# What makes linear sRGB of radiance in bands, (3, B): light's flux on the ground takes longer than
# a frame.
_of_world: weakref.WeakKeyDictionary[World, Floats] = weakref.WeakKeyDictionary()
_last: tuple[weakref.ref[Light], Floats] | None = None  # of the light that was asked for last


def _product(radiance: ArrayLike, light: Light, rgb_from_bands: Floats) -> NDArray[np.float32]:
    seen = array_of(radiance, "radiance", (..., len(light.bands)))
    return np.asarray(seen @ rgb_from_bands.T, np.float32)


def _make_rgb_from_bands(light: Light, scene: Scene | None, emission_cd_m2: float) -> Floats:
    white = white_luminance(light)
    if not white > 0 and scene is not None:
        white = white_luminance(light, scene) or emitted_luminance(scene, emission_cd_m2)[0]
    if not white > 0:
        raise Error("light: expected one that lights the ground from 400 to 700 nm, found none")
    return np.asarray(_RGB_FROM_XYZ @ xyz_from_bands(light) / white)
