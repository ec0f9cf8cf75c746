// The functions of omma/acceptance.h.
#include "omma/acceptance.h"

#include <cmath>

#include "kernel/hash.h"
#include "sampling/acceptance_warp.h"

namespace omma {

bool is_round(const Acceptance& a) {
  if (a.kernel == Kernel::gaussian)
    return a.minor_width_rad == 0 || a.minor_width_rad == a.width_rad;
  return a.kernel != Kernel::table || a.table->up_rad.empty();
}

double eval_acceptance(const Acceptance& acceptance, double theta_rad, double azimuth_rad) {
  const Sensitivity sensitivity = make_sensitivity(acceptance);
  return eval_sensitivity(view(sensitivity), theta_rad, azimuth_rad);
}

std::vector<Vec3> sample_acceptance(const Acceptance& acceptance, int count, std::uint64_t seed) {
  const AcceptanceWarp warp = make_acceptance_warp(acceptance);
  std::vector<Vec3> directions;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t hash = hash_combine(mix_bits(seed), static_cast<std::uint64_t>(i));
    const double x = normal_quantile(unit_interval(hash));
    const double y = normal_quantile(unit_interval(mix_bits(hash + 1)));
    directions.push_back(to_float(sample_acceptance(view(warp), x, y)));
  }
  return directions;
}

double acceptance_pdf(const Acceptance& acceptance, double theta_rad, double azimuth_rad) {
  const AcceptanceWarp warp = make_acceptance_warp(acceptance);
  return acceptance_pdf(view(warp), theta_rad, azimuth_rad);
}

}  // namespace omma
