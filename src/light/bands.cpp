// Means over bands: weighted sums over their samples.
#include "light/bands.h"

#include <algorithm>

namespace omma {

double spectrum_at(const Spectrum& spectrum, double wavelength_nm) {
  const std::vector<double>& knots = spectrum.wavelength_nm;
  const auto above = std::upper_bound(knots.begin(), knots.end(), wavelength_nm);
  if (above == knots.begin()) return spectrum.value.front();
  if (above == knots.end()) return spectrum.value.back();
  const auto k = static_cast<std::size_t>(above - knots.begin());
  const double t = (wavelength_nm - knots[k - 1]) / (knots[k] - knots[k - 1]);
  return spectrum.value[k - 1] * (1 - t) + spectrum.value[k] * t;
}

std::vector<double> band_means(const Bands& bands, const std::function<double(double)>& value) {
  const std::size_t samples = bands.wavelength_nm.size();
  std::vector<double> at_sample(samples), means(bands.count());
  std::transform(bands.wavelength_nm.begin(), bands.wavelength_nm.end(), at_sample.begin(), value);
  for (std::size_t b = 0; b < means.size(); ++b)
    for (std::size_t s = 0; s < samples; ++s)
      means[b] += bands.weight[b * samples + s] * at_sample[s];
  return means;
}

std::vector<double> band_means(const Bands& bands, const Spectrum& spectrum) {
  return band_means(bands, [&](double wavelength_nm) {
    const bool inside = !spectrum.empty() && wavelength_nm >= spectrum.wavelength_nm.front() &&
                        wavelength_nm <= spectrum.wavelength_nm.back();
    return inside ? spectrum_at(spectrum, wavelength_nm) : 0.0;
  });
}

}  // namespace omma
