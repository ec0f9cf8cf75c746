// Spectra as the bands of a light have them: means over bands, watts as photons, what a candela of
// RGB is.
#pragma once

#include <array>
#include <vector>

#include "omma/light.h"
#include "omma/spectrum.h"

namespace omma {

// Photons in a joule of light at 1 nm, 1 / (h c) with the constants of the SI, per J nm; as many
// times the wavelength at others.
inline constexpr double photons_per_joule_nm = 5.034116567542709e15;

// Linear between knots, 0 outside.
double eval_spectrum(const Spectrum& spectrum, double wavelength_nm);

// How much there is about a sample of bands, nm.
inline double cell_width_nm(const Bands& bands, std::size_t sample) {
  return bands.cell_nm.empty() ? 0 : bands.cell_nm[sample];
}

// What a quantity in watts is in `unit` at a wavelength, as a factor.
double unit_per_watt(LightUnit unit, double wavelength_nm);

// The weighted mean over each band, [band], of value(wavelength_nm, width_nm), which may change
// much within a sample's width.
template <typename Value>
std::vector<double> band_mean_of_cells(const Bands& bands, const Value& value) {
  const std::size_t samples = bands.wavelength_nm.size();
  std::vector<double> at(samples), means(bands.count(), 0.0);
  for (std::size_t i = 0; i < samples; ++i)
    at[i] = value(bands.wavelength_nm[i], cell_width_nm(bands, i));
  for (std::size_t b = 0; b < means.size(); ++b)
    for (std::size_t i = 0; i < samples; ++i) means[b] += bands.weight[b * samples + i] * at[i];
  return means;
}

// Of value(wavelength_nm), which changes little within a sample's width.
template <typename Value>
std::vector<double> band_mean(const Bands& bands, const Value& value) {
  return band_mean_of_cells(bands, [&](double nm, double) { return value(nm); });
}

// Of a spectrum as it is, such as a reflectance; and of one in watts, in `unit`.
std::vector<double> band_mean(const Bands& bands, const Spectrum& spectrum);
std::vector<double> band_mean_of_watts(const Bands& bands, LightUnit unit,
                                       const Spectrum& watts_per_nm);

// Relative luminous efficiency of light for us in daylight, V(wavelength): CIE 1924.
double luminous_efficiency(double wavelength_nm);

// Red, green and blue of linear sRGB in each band, in `unit`, where white (1, 1, 1) is one lumen
// (per whatever it is: a candela, a lux, a candela per square metre) of equal numbers of photons
// from 400 to 700 nm and the primaries have their spectra (omma/receptor.h).
std::vector<std::array<double, 3>> primaries_per_lumen(const Bands& bands, LightUnit unit);

// That white's parts from one wavelength to another, as the same light goes on beyond 400 and 700
// nm too: [band][part].
std::vector<std::vector<double>> white_per_lumen(
    const Bands& bands, LightUnit unit, const std::vector<std::array<double, 2>>& parts_nm);

}  // namespace omma
