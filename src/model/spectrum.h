// What must hold of a spectrum before anything trusts it.
#pragma once

#include <limits>
#include <string>

#include "omma/spectrum.h"

namespace omma {

// Wavelengths ascend from 100 nm or more to 5,000 nm or less, two to 10,000 of them, each with a
// value from 0 to `most`; an empty spectrum passes. Throws omma::Error that starts with `what`.
void check_spectrum(const Spectrum& spectrum, const std::string& what,
                    double most = std::numeric_limits<double>::max());

}  // namespace omma
