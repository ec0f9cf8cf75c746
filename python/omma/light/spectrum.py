"""Values at wavelengths, under the name by which they are public."""

from omma._core import Spectrum as Spectrum
