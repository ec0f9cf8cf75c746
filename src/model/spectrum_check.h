// What must hold of a spectrum before anything trusts it.
#pragma once

#include <limits>
#include <string>

#include "omma/spectrum.h"

namespace omma {

// Wavelengths ascend from 100 nm or more to 5,000 nm or less, two to 10,000 of them, each with a
// value from 0 to `most`; an empty spectrum passes. Throws omma::Error that begins with `place`,
// such as "reflectance: " or "", and the member.
void check_spectrum(const Spectrum& spectrum, const std::string& place,
                    double most = std::numeric_limits<double>::max());

// The value at a wavelength, linear between knots, that of the nearest knot beyond them. There is
// at least one.
double held_spectrum(const Spectrum& spectrum, double wavelength_nm);

// What there is beyond the first and the last knot.
enum class Beyond { nothing, nearest_knot };

// The mean over a width about a wavelength, exact; of no width, the value there.
double mean_spectrum(const Spectrum& spectrum, double wavelength_nm, double width_nm,
                     Beyond beyond);

}  // namespace omma
