// Checks of spectra.
#include "model/spectrum.h"

#include <cmath>
#include <cstdio>

#include "omma/error.h"

namespace omma {
namespace {

constexpr double shortest_nm = 100, longest_nm = 5000;
constexpr std::size_t most_knots = 10000;

std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

void check_spectrum(const Spectrum& spectrum, const std::string& what, double most) {
  const std::size_t knots = spectrum.wavelength_nm.size();
  if (spectrum.value.size() != knots)
    throw Error(what + ": expected as many values as wavelengths, found " +
                std::to_string(spectrum.value.size()) + " and " + std::to_string(knots));
  if (knots == 0) return;
  if (knots < 2 || knots > most_knots)
    throw Error(what + ": expected 2 to " + std::to_string(most_knots) + " wavelengths, found " +
                std::to_string(knots));
  for (std::size_t k = 0; k < knots; ++k) {
    const double wavelength = spectrum.wavelength_nm[k], value = spectrum.value[k];
    if (!(wavelength >= shortest_nm && wavelength <= longest_nm))
      throw Error(what + ": expected wavelengths from 100 to 5000 nm, found " +
                  short_text(wavelength));
    if (k > 0 && !(wavelength > spectrum.wavelength_nm[k - 1]))
      throw Error(what + ": expected wavelengths that grow, found " +
                  short_text(spectrum.wavelength_nm[k - 1]) + " nm and then " +
                  short_text(wavelength) + " nm");
    if (!(value >= 0 && value <= most)) {
      const bool fraction = most == 1;
      throw Error(what + ": expected values " +
                  (fraction ? "from 0 to 1" : "that are finite and not negative") + ", found " +
                  short_text(value) + " at " + short_text(wavelength) + " nm");
    }
  }
}

}  // namespace omma
