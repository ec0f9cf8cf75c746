// What receptors make of light: visual pigments, and RGB seen through them.
#include <algorithm>
#include <cmath>

#include "omma/error.h"
#include "omma/receptor.h"
#include "receptor/primary_spectra.h"

namespace omma {
namespace {

double table_value(const ReceptorType& type, double wavelength_nm) {
  const std::vector<double>& knots = type.wavelength_nm;
  if (!(wavelength_nm >= knots.front() && wavelength_nm <= knots.back())) return 0;
  const auto above = std::upper_bound(knots.begin(), knots.end(), wavelength_nm);
  if (above == knots.end()) return type.sensitivity.back();
  const auto k = static_cast<std::size_t>(above - knots.begin());
  const double t = (wavelength_nm - knots[k - 1]) / (knots[k] - knots[k - 1]);
  return type.sensitivity[k - 1] * (1 - t) + type.sensitivity[k] * t;
}

}  // namespace

std::array<double, 3> primary_spectra(double wavelength_nm) {
  std::array<double, 3> fractions{};
  if (!(wavelength_nm >= visible_from_nm && wavelength_nm <= visible_to_nm)) return fractions;
  const double at = (wavelength_nm - first_primary_nm) / primary_step_nm;
  const int k = std::min(static_cast<int>(at), primary_knots - 2);
  const double t = at - k;
  for (std::size_t c = 0; c < 3; ++c)
    fractions[c] = primary_table[k][c] * (1 - t) + primary_table[k + 1][c] * t;
  return fractions;
}

double pigment_alpha_band(double peak_wavelength_nm, double wavelength_nm) {
  const double x = peak_wavelength_nm / wavelength_nm;
  const double offset = peak_wavelength_nm - 300;
  const double a = 0.8795 + 0.0459 * std::exp(-offset * offset / 11940);
  return 1 / (std::exp(69.7 * (a - x)) + std::exp(28 * (0.922 - x)) +
              std::exp(-14.9 * (1.104 - x)) + 0.674);
}

double pigment_beta_band(double peak_wavelength_nm, double wavelength_nm) {
  const double peak_nm = 189 + 0.315 * peak_wavelength_nm;
  const double t = (wavelength_nm - peak_nm) / (-40.5 + 0.195 * peak_wavelength_nm);
  return 0.26 * std::exp(-t * t);
}

void eval_spectral_sensitivity(const ReceptorType& type, std::span<const double> wavelength_nm,
                               std::span<double> sensitivity) {
  const bool pigment = type.peak_wavelength_nm != 0;
  if (!pigment && type.wavelength_nm.empty())
    throw Error("receptor type '" + type.name +
                "': expected a peak wavelength or a table of sensitivities, found neither");
  const double depth = type.absorption_per_m * type.length_m;
  for (std::size_t i = 0; i < wavelength_nm.size(); ++i) {
    const double w = wavelength_nm[i];
    if (!pigment) {
      sensitivity[i] = table_value(type, w);
      continue;
    }
    const double absorbance = pigment_alpha_band(type.peak_wavelength_nm, w) +
                              pigment_beta_band(type.peak_wavelength_nm, w);
    sensitivity[i] = depth > 0 ? std::expm1(-depth * absorbance) / std::expm1(-depth) : absorbance;
  }
}

std::array<double, 3> receptor_weights(const ReceptorType& type,
                                       std::array<double, 3> ultraviolet) {
  // The trapezoidal rule at a quarter of a nanometre: knots of tables rarely lie between, and even
  // then the error is under 1e-5.
  constexpr int steps_per_nm = 4;
  constexpr int below = static_cast<int>(visible_from_nm - ultraviolet_from_nm) * steps_per_nm;
  constexpr int count = static_cast<int>(visible_to_nm - ultraviolet_from_nm) * steps_per_nm + 1;
  std::vector<double> wavelength_nm(count), sensitivity(count);
  for (int i = 0; i < count; ++i)
    wavelength_nm[static_cast<std::size_t>(i)] =
        ultraviolet_from_nm + static_cast<double>(i) / steps_per_nm;
  eval_spectral_sensitivity(type, wavelength_nm, sensitivity);
  double hidden = 0;  // what the receptor has below 400 nm
  std::array<double, 3> seen{};
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    // Half a step at the ends, and on either side of 400 nm.
    const bool half = i == 0 || i == below || i == count - 1;
    const double weight = (half ? 0.5 : 1) * sensitivity[k];
    if (i <= below) hidden += weight;
    if (i < below) continue;
    const std::array<double, 3> primaries = primary_spectra(wavelength_nm[k]);
    for (std::size_t c = 0; c < 3; ++c) seen[c] += weight * primaries[c];
  }
  // The primaries add up to 1, so that this is the whole.
  const double whole = hidden + seen[0] + seen[1] + seen[2];
  if (!(whole > 0))
    throw Error("receptor type '" + type.name +
                "': expected a sensitivity between 300 and 700 nm, found none");
  std::array<double, 3> weights;
  for (std::size_t c = 0; c < 3; ++c) weights[c] = (seen[c] + ultraviolet[c] * hidden) / whole;
  return weights;
}

}  // namespace omma
