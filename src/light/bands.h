// Means over bands of wavelengths: what light and surfaces are in each of them.
#pragma once

#include <functional>
#include <vector>

#include "omma/spectrum.h"

namespace omma {

// The value at a wavelength, linear between knots, that of the nearest knot beyond them. There is
// at least one.
double spectrum_at(const Spectrum& spectrum, double wavelength_nm);

// The mean of a function of the wavelength, nm, over each band: [band].
std::vector<double> band_means(const Bands& bands, const std::function<double(double)>& value);

// Of a spectrum, which is 0 beyond its knots.
std::vector<double> band_means(const Bands& bands, const Spectrum& spectrum);

}  // namespace omma
