"""Skies from pictures: equirectangular panoramas in RGB, lifted by named rules, or in bands."""

from __future__ import annotations

import os
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Image
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Floats
from omma.base.files import PathLike
from omma.base.orientation import load_upright
from omma.base.pixels import check_finite, check_radiance, warn_of_bytes
from omma.base.slips import warn_of_shape
from omma.light.bands import Bands, primary_spectra
from omma.light.lights import Light
from omma.light.sky_map import from_equirectangular
from omma.light.units import Unit, check_unit, watts_from_photons

# RGB says nothing below it.
_LEAST_NM = 400.0
# Where light in watts has the radiance that it is said to have: white is then the same at it in
# both units.
_WHITE_NM = 550.0


@checked
def panorama(
    image: PathLike | ArrayLike,
    *,
    ultraviolet: Literal["dark", "as_blue"] | float | None = None,
    radiance_per_unit: float = 1.0,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """The light of an equirectangular picture in RGB: ahead (-Z) in the middle, row 0 at the top.

    Red, green and blue stand for their `primary_spectra`: white, (1, 1, 1), is equal numbers of
    photons from 400 to 700 nm; in watts, that which has ``radiance_per_unit`` at 550 nm. Above 700
    nm it is dark. Unpolarised.

    Between the middles of pixels it is on straight lines, as `Background.image` of the same picture
    is seen: a sun of one pixel has its radiance in the middle. Of pictures of more than 2,048 x
    1,024 pixels the mean of neighbours is taken before, which blurs by half a pixel.

    Args:
        image: Radiance HDR, OpenEXR, PNG or JPEG, turned as its EXIF says, or an array (height,
            width, 3 or 4): uint8 is sRGB, float linear. Of what has alpha that is left out.
        ultraviolet: what there is below 400 nm, where pictures know nothing: "dark", "as_blue", or
            a share of blue, in photons. Must be said where bands reach below 400 nm.
        radiance_per_unit: of linear white 1, in ``unit``.
        bands: by default 16 of 25 nm from 300 to 700 nm.
        unit: "photons" m⁻² s⁻¹ sr⁻¹ nm⁻¹ or "watts" m⁻² sr⁻¹ nm⁻¹.

    Raises:
        omma.Error: no such image, one that its GPano says is a part of the sphere or not
            equirectangular, values that are negative or not finite, or ultraviolet that nobody has
            given.

    Warns:
        UserWarning: a picture of another shape, floats that look like 8 bits, or a file whose GPano
            says that the camera was turned or tilted; `Light.turned` applies a heading.
    """
    bands = bands or Bands.equal()
    check_unit(unit)
    positive(radiance_per_unit, "radiance_per_unit")
    used = bands.wavelength_nm[np.any(bands.weight > 0, axis=0)]
    reach_nm = float(used[0] if bands.edges_nm is None else min(used[0], bands.edges_nm[0]))
    blue = _share_of_blue(ultraviolet, reach_nm)

    def lifted(nm: Floats) -> Floats:
        spectra = np.asarray(primary_spectra(nm))
        spectra[nm < _LEAST_NM] = (0, 0, blue)
        if unit == "watts":
            spectra = watts_from_photons(spectra, nm[:, None])
            spectra = spectra / watts_from_photons(1.0, _WHITE_NM)
        return spectra

    matrix = bands.mean(lifted) * radiance_per_unit
    picture = _linear_rgb(image)[:, :, None, :]
    warn_of_shape(picture.shape, "image")
    return Light(bands, unit, from_equirectangular(picture), band_from_channel=matrix)


@checked
def panorama_bands(
    radiance: ArrayLike, *, bands: Bands | None = None, unit: Unit = "photons"
) -> Light:
    """The light of an equirectangular picture in bands: ahead (-Z) in the middle, row 0 at the top.

    Between the middles of pixels it is as of `panorama`.

    Args:
        radiance: (height, width, B), in ``unit``; or (height, width, 3, B) of I, Q, U, with the
            reference axis up.
        bands: by default 16 of 25 nm from 300 to 700 nm.
        unit: "photons" m⁻² s⁻¹ sr⁻¹ nm⁻¹ or "watts" m⁻² sr⁻¹ nm⁻¹.

    Raises:
        omma.Error: another number of bands, values that are negative or not finite, or Q and U that
            are more than I.
    """
    bands = bands or Bands.equal()
    picture = array_of(radiance, "radiance")
    if picture.ndim == 3:
        picture = picture[:, :, None]
    if picture.ndim != 4 or 0 in picture.shape or picture.shape[2] not in (1, 3):
        raise Error(
            "radiance: expected shape (height, width, bands) or (height, width, 3, bands), found "
            f"{np.shape(radiance)}"
        )
    if picture.shape[3] != len(bands):
        raise Error(f"radiance: expected {len(bands)} bands, found {picture.shape[3]}")
    for of_stokes in np.moveaxis(picture, 2, 0):
        check_finite(of_stokes, "radiance")
    check_radiance(picture[:, :, 0], "radiance")
    return Light(bands, unit, from_equirectangular(picture))


def _share_of_blue(ultraviolet: str | float | None, shortest_nm: float) -> float:
    if ultraviolet is None:
        if shortest_nm < _LEAST_NM:
            raise Error(
                f"ultraviolet: bands reach down to {shortest_nm:.4g} nm, and a picture in RGB says "
                'nothing below 400 nm: choose "dark", "as_blue" or a share of blue'
            )
        return 0.0
    if isinstance(ultraviolet, str):
        if ultraviolet not in ("dark", "as_blue"):
            raise Error(
                'ultraviolet: expected "dark", "as_blue" or a share of blue, found '
                f"{ultraviolet!r:.40}"
            )
        return float(ultraviolet == "as_blue")
    if not (np.isfinite(ultraviolet) and ultraviolet >= 0):
        raise Error(f"ultraviolet: expected a share of at least 0, found {ultraviolet}")
    return float(ultraviolet)


def _linear_rgb(image: PathLike | ArrayLike) -> Floats:
    """Linear RGB (height, width, 3) of a file or an array."""
    name = "image"
    if isinstance(image, (str, os.PathLike)):
        name = os.fsdecode(image)
        pixels = load_upright(image).pixels[:, :, :3]
    else:
        check_finite(array_of(image, "image", (None, None, None), np.float32), "image")
        pixels = Image(image).pixels[:, :, :3]
    if pixels.dtype == np.uint8:
        share = pixels / 255
        # sRGB's own curve.
        return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    linear = pixels.astype(np.float64)
    check_radiance(linear, name)
    if not isinstance(image, (str, os.PathLike)):
        warn_of_bytes(linear, "image")
    return linear
