// Spectra, and the bands of wavelengths that light is rendered in.
#pragma once

#include <cstddef>
#include <vector>

namespace omma {

// Values at wavelengths, linear between.
struct Spectrum {
  std::vector<double> wavelength_nm;  // [knot], ascending
  std::vector<double> value;          // [knot]

  bool empty() const { return wavelength_nm.empty(); }
  bool operator==(const Spectrum&) const = default;
};

// A band is a weighted mean over wavelengths: of neighbouring ones, or as a receptor weighs them.
struct Bands {
  std::vector<double> wavelength_nm;  // [sample], ascending
  std::vector<double> weight;         // [band][sample], at least 0, adding up to 1 in each band
  // [sample], how much there is about each wavelength that its weight stands for: spectra count by
  // their means over it. Empty: the wavelengths alone.
  std::vector<double> cell_nm = {};

  std::size_t count() const {
    return wavelength_nm.empty() ? 0 : weight.size() / wavelength_nm.size();
  }
  bool operator==(const Bands&) const = default;
};

}  // namespace omma
