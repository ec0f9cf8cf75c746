// Widest footprints of tables by their modulation transfer, those of other acceptances by a rule.
#include "optics/footprint_width.h"

#include <algorithm>
#include <cmath>

#include "physics/surface/footprint.h"

namespace omma {
namespace {

// The bound of physics/surface/footprint.h, of a table along one azimuth: frequencies go on until a
// footprint of a hundredth of the width would matter, in steps of a tenth of a cycle over the
// width.
double widest_along(const Acceptance& acceptance, double azimuth_rad, double width_rad) {
  constexpr int count = 80;
  std::vector<double> cycles, azimuth(count, azimuth_rad), transfer(count);
  for (int i = 0; i < count; ++i) cycles.push_back(0.1 * (i + 1) / width_rad);
  acceptance_mtf(acceptance, cycles, azimuth, transfer);
  double low = 0, high = width_rad;
  for (int step = 0; step < 30; ++step) {
    const double t = 0.5 * (low + high);
    double change = 0;
    for (std::size_t i = 0; i < count; ++i)
      change = std::max(
          change, std::fabs(transfer[i]) * -std::expm1(-std::pow(2 * pi * cycles[i] * t, 2) / 8));
    (change < 0.008 ? low : high) = t;
  }
  return low;
}

// Widest footprint over the width of a kernel that has a rule.
double widest_ratio(const Acceptance& a, double width_rad) {
  const bool lens = a.kernel == Kernel::lens_rhabdom;
  return widest_footprint(a.kernel,
                          lens ? width_rad / (a.wavelength_nm * 1e-9 / a.facet_diameter_m) : 0);
}

}  // namespace

double widest_footprint_rad(const Sensitivity& sensitivity) {
  const Acceptance& a = sensitivity.acceptance;
  if (a.kernel == Kernel::gaussian)
    return (is_round(a) ? a.width_rad : a.minor_width_rad) * widest_ratio(a, 0);
  const double width = mean_width_rad(sensitivity);
  if (a.kernel != Kernel::table) return widest_ratio(a, width) * width;
  if (width == 0) return 0;  // a peak narrower than any step of a table
  double widest = width;
  for (int i = 0; i < (is_round(a) ? 1 : 4); ++i)
    widest = std::min(widest, widest_along(a, i * pi / 4, width));
  return widest;
}

double footprint_width_rad(const Sensitivity& sensitivity, int samples) {
  return footprint_width_rad(widest_footprint_rad(sensitivity), mean_width_rad(sensitivity),
                             samples);
}

}  // namespace omma
