// Checks of spectra, and their values.
#include "model/spectrum_check.h"

#include <algorithm>

#include "model/text.h"
#include "omma/error.h"

namespace omma {
namespace {

constexpr double shortest_nm = 100, longest_nm = 5000;
constexpr std::size_t most_knots = 10000;

}  // namespace

void check_spectrum(const Spectrum& spectrum, const std::string& place, double most) {
  const std::size_t knots = spectrum.wavelength_nm.size();
  if (spectrum.value.size() != knots)
    throw Error(place + "value: expected one for each of " + std::to_string(knots) +
                " wavelengths, found " + std::to_string(spectrum.value.size()));
  if (knots == 0) return;
  if (knots < 2 || knots > most_knots)
    throw Error(place + "wavelength_nm: expected 2 to " + std::to_string(most_knots) +
                " wavelengths, found " + std::to_string(knots));
  for (std::size_t k = 0; k < knots; ++k) {
    const double wavelength = spectrum.wavelength_nm[k], value = spectrum.value[k];
    if (!(wavelength >= shortest_nm && wavelength <= longest_nm))
      throw Error(place + "wavelength_nm: expected 100 to 5000, found " + short_text(wavelength));
    if (k > 0 && !(wavelength > spectrum.wavelength_nm[k - 1]))
      throw Error(place + "wavelength_nm: expected wavelengths that grow, found " +
                  short_text(spectrum.wavelength_nm[k - 1]) + " and then " +
                  short_text(wavelength));
    if (!(value >= 0 && value <= most))
      throw Error(place + "value: expected " +
                  (most == 1 ? "0 to 1" : "numbers that are finite and not negative") + ", found " +
                  short_text(value) + " at " + short_text(wavelength) + " nm");
  }
}

double held_spectrum(const Spectrum& spectrum, double wavelength_nm) {
  const std::vector<double>& knots = spectrum.wavelength_nm;
  const auto above = std::upper_bound(knots.begin(), knots.end(), wavelength_nm);
  if (above == knots.begin()) return spectrum.value.front();
  if (above == knots.end()) return spectrum.value.back();
  const auto k = static_cast<std::size_t>(above - knots.begin());
  const double t = (wavelength_nm - knots[k - 1]) / (knots[k] - knots[k - 1]);
  return spectrum.value[k - 1] * (1 - t) + spectrum.value[k] * t;
}

double mean_spectrum(const Spectrum& spectrum, double wavelength_nm, double width_nm,
                     Beyond beyond) {
  const std::vector<double>& knots = spectrum.wavelength_nm;
  if (knots.empty()) return 0;
  const bool is_held = beyond == Beyond::nearest_knot;
  const double front = knots.front(), back = knots.back();
  if (!(width_nm > 0))
    return is_held || (wavelength_nm >= front && wavelength_nm <= back)
               ? held_spectrum(spectrum, wavelength_nm)
               : 0;
  const double low = wavelength_nm - width_nm / 2, high = wavelength_nm + width_nm / 2;
  const double first = std::clamp(low, front, back), last = std::clamp(high, front, back);
  double from = first, value = held_spectrum(spectrum, first), sum = 0;
  const auto add = [&](double to, double next) {
    sum += 0.5 * (value + next) * (to - from);
    from = to;
    value = next;
  };
  for (auto knot = std::upper_bound(knots.begin(), knots.end(), first);
       knot != knots.end() && *knot < last; ++knot)
    add(*knot, spectrum.value[static_cast<std::size_t>(knot - knots.begin())]);
  add(last, held_spectrum(spectrum, last));
  if (is_held)
    sum += spectrum.value.front() * (std::min(high, front) - std::min(low, front)) +
           spectrum.value.back() * (std::max(high, back) - std::max(low, back));
  return sum / width_nm;
}

}  // namespace omma
