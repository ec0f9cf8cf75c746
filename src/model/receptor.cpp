// Checks of receptor types.
#include "omma/receptor.h"

#include <cmath>

#include "model/text.h"
#include "omma/error.h"

namespace omma {

void validate_receptor_type(const ReceptorType& type, const std::string& where) {
  const std::string place = where + (type.name.empty() ? "" : " ('" + type.name + "')") + ": ";
  const auto expect = [&](bool good, const std::string& what, double found) {
    if (!good) throw Error(place + what + ", found " + short_text(found));
  };
  const bool pigment = type.peak_wavelength_nm != 0, table = !type.wavelength_nm.empty();
  if (pigment && table)
    throw Error(place + "expected a peak wavelength or a table of sensitivities, found both");
  if (pigment)
    // Where the template's authors compared it with pigments.
    expect(type.peak_wavelength_nm >= 300 && type.peak_wavelength_nm <= 800,
           "peak_wavelength_nm: expected 300 to 800 nm", type.peak_wavelength_nm);
  if (type.wavelength_nm.size() != type.sensitivity.size())
    throw Error(place + "expected as many sensitivities as wavelengths (" +
                std::to_string(type.wavelength_nm.size()) + "), found " +
                std::to_string(type.sensitivity.size()));
  if (table && type.wavelength_nm.size() < 2)
    throw Error(place + "expected at least two wavelengths, found one");
  bool any = !table;
  for (std::size_t k = 0; k < type.wavelength_nm.size(); ++k) {
    expect(type.wavelength_nm[k] >= 100 && type.wavelength_nm[k] <= 5000,
           "wavelength_nm: expected 100 to 5000", type.wavelength_nm[k]);
    expect(k == 0 || type.wavelength_nm[k] > type.wavelength_nm[k - 1],
           "wavelength_nm: expected ascending wavelengths", type.wavelength_nm[k]);
    expect(std::isfinite(type.sensitivity[k]) && type.sensitivity[k] >= 0,
           "sensitivity: expected numbers of at least 0", type.sensitivity[k]);
    any = any || type.sensitivity[k] > 0;
  }
  if (!any) throw Error(place + "sensitivity: expected a number above 0, found none");
  expect(std::isfinite(type.microvillus_angle_rad), "microvillus_angle_rad: expected an angle",
         type.microvillus_angle_rad);
  expect(std::isfinite(type.polarisation_sensitivity) && type.polarisation_sensitivity >= 1,
         "polarisation_sensitivity: expected a number of at least 1",
         type.polarisation_sensitivity);
  expect(std::isfinite(type.absorption_per_m) && type.absorption_per_m >= 0,
         "absorption_per_m: expected a number of at least 0", type.absorption_per_m);
  expect(std::isfinite(type.length_m) && type.length_m >= 0,
         "length_m: expected a length of at least 0", type.length_m);
  expect(std::fabs(type.right_rad) <= pi / 2, "right_rad: expected an angle of at most pi/2",
         type.right_rad);
  expect(std::fabs(type.up_rad) <= pi / 2, "up_rad: expected an angle of at most pi/2",
         type.up_rad);
  if (type.acceptance) validate_acceptance(*type.acceptance, place + "acceptance");
}

}  // namespace omma
