// Means over bands, and candelas in absolute units.
#include "light/bands.h"

#include <algorithm>

#include "model/spectrum_check.h"
#include "omma/receptor.h"

namespace omma {
namespace {

// lm per W at 555 nm, where V is 1: the SI's definition of the candela.
constexpr double most_lumens_per_watt = 683;

// CIE 1924, as in CIE 018:2019, table 1: at 380, 390, ... 780 nm.
constexpr double first_efficiency_nm = 380, efficiency_step_nm = 10;
constexpr std::array<double, 41> efficiency = {
    0.000039, 0.00012, 0.000396, 0.00121, 0.004,   0.0116,   0.023,    0.038,    0.06,
    0.09098,  0.13902, 0.20802,  0.323,   0.503,   0.71,     0.862,    0.954,    0.99495,
    0.995,    0.952,   0.87,     0.757,   0.631,   0.503,    0.381,    0.265,    0.175,
    0.107,    0.061,   0.032,    0.017,   0.00821, 0.004102, 0.002091, 0.001047, 0.00052,
    0.000249, 0.00012, 0.00006,  0.00003, 0.000015};

// Photons s^-1 nm^-1 from 400 to 700 nm that are a lumen.
double photons_per_lumen_nm() {
  double lumens = 0;  // of one photon per nm and second; trapezoidal rule at 1 nm
  for (int nm = static_cast<int>(visible_from_nm); nm <= static_cast<int>(visible_to_nm); ++nm) {
    const bool is_end =
        nm == static_cast<int>(visible_from_nm) || nm == static_cast<int>(visible_to_nm);
    lumens += (is_end ? 0.5 : 1.0) * luminous_efficiency(nm) / (photons_per_joule_nm * nm);
  }
  return 1 / (most_lumens_per_watt * lumens);
}

}  // namespace

double eval_spectrum(const Spectrum& spectrum, double wavelength_nm) {
  return mean_spectrum(spectrum, wavelength_nm, 0, Beyond::nothing);
}

double unit_per_watt(LightUnit unit, double wavelength_nm) {
  return unit == LightUnit::photons ? photons_per_joule_nm * wavelength_nm : 1;
}

std::vector<double> band_mean(const Bands& bands, const Spectrum& spectrum) {
  return band_mean_of_cells(bands, [&](double nm, double width_nm) {
    return mean_spectrum(spectrum, nm, width_nm, Beyond::nothing);
  });
}

std::vector<double> band_mean_of_watts(const Bands& bands, LightUnit unit,
                                       const Spectrum& watts_per_nm) {
  return band_mean_of_cells(bands, [&](double nm, double width_nm) {
    return unit_per_watt(unit, nm) * mean_spectrum(watts_per_nm, nm, width_nm, Beyond::nothing);
  });
}

double luminous_efficiency(double wavelength_nm) {
  const double at = (wavelength_nm - first_efficiency_nm) / efficiency_step_nm;
  constexpr auto last = static_cast<double>(efficiency.size() - 1);
  if (!(at >= 0 && at <= last)) return 0;
  const auto k = static_cast<std::size_t>(std::min(at, last - 1));
  const double t = at - static_cast<double>(k);
  return efficiency[k] * (1 - t) + efficiency[k + 1] * t;
}

std::vector<std::array<double, 3>> primaries_per_lumen(const Bands& bands, LightUnit unit) {
  const double photons = photons_per_lumen_nm();
  std::vector<std::array<double, 3>> made(bands.count());
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<double> means = band_mean(bands, [&](double nm) {
      return photons * primary_spectra(nm)[c] / (photons_per_joule_nm * nm) *
             unit_per_watt(unit, nm);
    });
    for (std::size_t b = 0; b < made.size(); ++b) made[b][c] = means[b];
  }
  return made;
}

std::vector<std::vector<double>> white_per_lumen(
    const Bands& bands, LightUnit unit, const std::vector<std::array<double, 2>>& parts_nm) {
  const double photons = photons_per_lumen_nm();
  std::vector<std::vector<double>> made(bands.count());
  for (const auto& [from_nm, to_nm] : parts_nm) {
    const std::vector<double> means =
        band_mean_of_cells(bands, [&, from = from_nm, to = to_nm](double nm, double width_nm) {
          const double lower = std::max(nm - width_nm / 2, from);
          const double upper = std::min(nm + width_nm / 2, to);
          const double part = width_nm > 0 ? std::max(upper - lower, 0.0) / width_nm
                                           : (nm >= from && nm < to ? 1.0 : 0.0);
          return part * photons / (photons_per_joule_nm * nm) * unit_per_watt(unit, nm);
        });
    for (std::size_t b = 0; b < made.size(); ++b) made[b].push_back(means[b]);
  }
  return made;
}

}  // namespace omma
