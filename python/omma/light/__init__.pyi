from .air import with_air
from .bands import Bands, band_from_rgb, primary_spectra
from .cie_skies import cie_relative_luminance, cie_sky
from .cloud_shadow import CloudShadow
from .clouds import cloud_transmittance, clouded, cloudy_sky
from .dark_skies import night_sky, night_sky_at
from .discs import Disc
from .lights import Light
from .measured import measured_sky
from .nights import natural_sky, natural_sky_at
from .panoramas import panorama, panorama_bands
from .skies import clear_sky, clear_sky_at, lamps, moonlit_sky, overcast_sky, uniform_sky
from .spectrum import Spectrum
from .spectrum_files import load_spectra
from .star_light import stars
from .sun_position import MoonPosition, SunPosition, moon_position, sun_position
from .sun_times import dawn, dusk, solar_noon, sunrise, sunset
from .units import photons_from_watts, watts_from_photons
from .water import under_water

__all__ = [
    "Bands",
    "CloudShadow",
    "Disc",
    "Light",
    "MoonPosition",
    "Spectrum",
    "SunPosition",
    "band_from_rgb",
    "cie_relative_luminance",
    "cie_sky",
    "clear_sky",
    "clear_sky_at",
    "cloud_transmittance",
    "clouded",
    "cloudy_sky",
    "dawn",
    "dusk",
    "lamps",
    "load_spectra",
    "measured_sky",
    "moon_position",
    "moonlit_sky",
    "natural_sky",
    "natural_sky_at",
    "night_sky",
    "night_sky_at",
    "overcast_sky",
    "panorama",
    "panorama_bands",
    "photons_from_watts",
    "primary_spectra",
    "solar_noon",
    "stars",
    "sun_position",
    "sunrise",
    "sunset",
    "under_water",
    "uniform_sky",
    "watts_from_photons",
    "with_air",
]
