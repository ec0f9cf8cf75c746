// The functions of omma/acceptance.h but for the check and the modulation transfer.
#include "omma/acceptance.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "optics/acceptance_warp.h"
#include "optics/lens_rhabdom.h"
#include "physics/sampling/hash.h"
#include "physics/sampling/normal_quantile.h"
#include "threads/cancel.h"

namespace omma {
namespace {

// The outermost x at which the profile of a lens is half its maximum.
double half_maximum_x(const LensProfile& profile) {
  const double* p = profile.knots.data() + 2 * (profile_knots - 2);
  int i = profile_knots - 2;
  for (; i > 0 && p[0] < 0.5; p -= 2) --i;
  double low = 0, high = 1;
  for (int step = 0; step < 50; ++step) {
    const double t = 0.5 * (low + high);
    (hermite(p[0], p[1], p[2], p[3], t) < 0.5 ? high : low) = t;
  }
  return (i + low) * profile_step;
}

// The same of a measured profile, over the polar angle.
double half_maximum_rad(const SensitivityTable& table) {
  const std::vector<double>& s = table.sensitivity;
  std::size_t i = s.size() - 1;
  while (i > 0 && s[i] < 0.5) --i;
  if (i + 1 == s.size()) return table.right_rad[i];
  const double t = (s[i] - 0.5) / (s[i] - s[i + 1]);
  return table.right_rad[i] * (1 - t) + table.right_rad[i + 1] * t;
}

// Full width at half maximum of a two-dimensional table along a line through the axis, by the
// outermost crossings.
double line_width_rad(const SensitivityView& s, double azimuth_rad) {
  constexpr int steps = 4096;
  const double end = std::min(pi, std::hypot(std::max(-s.right_rad[0], s.right_rad[s.columns - 1]),
                                             std::max(-s.up_rad[0], s.up_rad[s.rows - 1])));
  const auto at = [&](int i) {
    const double theta = end * (2.0 * i / steps - 1);
    return eval_table(s, std::fabs(theta), theta < 0 ? azimuth_rad + pi : azimuth_rad);
  };
  double largest = 0;
  for (int i = 0; i <= steps; ++i) largest = std::max(largest, at(i));
  if (largest == 0) return 0;
  // Linear between two of the steps.
  const auto crossing = [&](int first, int direction) {
    int i = first;
    while (at(i) < 0.5 * largest) i += direction;
    if (i == first) return static_cast<double>(i);
    const double inside = at(i), outside = at(i - direction);
    return i - direction * (inside - 0.5 * largest) / (inside - outside);
  };
  return 2 * end / steps * (crossing(steps, -1) - crossing(0, 1));
}

// Diameter of the disc with the area in which S is at least half its maximum, which is 1.
double area_width_rad(const SensitivityView& s) {
  constexpr int steps = 512;
  const double width = s.right_rad[s.columns - 1] - s.right_rad[0];
  const double height = s.up_rad[s.rows - 1] - s.up_rad[0];
  int inside = 0;
  for (int j = 0; j < steps; ++j)
    for (int i = 0; i < steps; ++i) {
      const double right = s.right_rad[0] + width * (i + 0.5) / steps;
      const double up = s.up_rad[0] + height * (j + 0.5) / steps;
      if (eval_table(s, std::hypot(right, up), std::atan2(right, up)) >= 0.5) ++inside;
    }
  return 2 * std::sqrt(inside * width * height / (pi * steps * steps));
}

}  // namespace

bool Acceptance::operator==(const Acceptance& b) const {
  const auto fields = [](const Acceptance& a) {
    return std::tie(a.kernel, a.width_rad, a.minor_width_rad, a.major_angle_rad, a.facet_diameter_m,
                    a.wavelength_nm, a.model, a.focal_length_m, a.rhabdom_diameter_m,
                    a.rhabdom_index, a.surround_index);
  };
  if (fields(*this) != fields(b)) return false;
  return table == b.table || (table != nullptr && b.table != nullptr && *table == *b.table);
}

bool is_round(const Acceptance& a) {
  if (a.kernel == Kernel::gaussian)
    return a.minor_width_rad == 0 || a.minor_width_rad == a.width_rad;
  return a.kernel != Kernel::table || a.table->up_rad.empty();
}

double width_rad(const Sensitivity& sensitivity, double azimuth_rad) {
  const Acceptance& a = sensitivity.acceptance;
  switch (a.kernel) {
    case Kernel::gaussian:
      if (!is_round(a))
        return 1 / std::hypot(std::cos(azimuth_rad - a.major_angle_rad) / a.width_rad,
                              std::sin(azimuth_rad - a.major_angle_rad) / a.minor_width_rad);
      return a.width_rad;
    case Kernel::pillbox:
    case Kernel::compoundray:
      return a.width_rad;
    case Kernel::airy:
    case Kernel::lens_rhabdom: {
      const double sine =
          half_maximum_x(*sensitivity.profile) * a.wavelength_nm * 1e-9 / (pi * a.facet_diameter_m);
      return 2 * std::asin(std::min(sine, 1.0));
    }
    case Kernel::table:
      return is_round(a) ? 2 * half_maximum_rad(*a.table)
                         : line_width_rad(view(sensitivity), azimuth_rad);
  }
  return 0;
}

double mean_width_rad(const Sensitivity& sensitivity) {
  const Acceptance& a = sensitivity.acceptance;
  if (is_round(a)) return width_rad(sensitivity, 0);
  if (a.kernel == Kernel::gaussian) return std::sqrt(a.width_rad * a.minor_width_rad);
  return area_width_rad(view(sensitivity));
}

double acceptance_width_rad(const Acceptance& acceptance, double azimuth_rad) {
  return width_rad(make_sensitivity(acceptance), azimuth_rad);
}

double mean_acceptance_width_rad(const Acceptance& acceptance) {
  return mean_width_rad(make_sensitivity(acceptance));
}

void eval_acceptance(const Acceptance& acceptance, std::span<const double> theta_rad,
                     std::span<const double> azimuth_rad, std::span<double> sensitivity) {
  const Sensitivity made = make_sensitivity(acceptance);
  const SensitivityView s = view(made);
  for (std::size_t i = 0; i < theta_rad.size(); ++i) {
    check_cancelled();
    sensitivity[i] = eval_sensitivity(s, theta_rad[i], azimuth_rad[i]);
  }
}

void acceptance_pdf(const Acceptance& acceptance, std::span<const double> theta_rad,
                    std::span<const double> azimuth_rad, std::span<double> per_sr) {
  const AcceptanceWarp warp = make_acceptance_warp(acceptance);
  const AcceptanceWarpView v = view(warp);
  for (std::size_t i = 0; i < theta_rad.size(); ++i) {
    check_cancelled();
    per_sr[i] = acceptance_pdf(v, theta_rad[i], azimuth_rad[i]);
  }
}

std::vector<Vec3> sample_acceptance(const Acceptance& acceptance, int count, std::uint64_t seed) {
  const AcceptanceWarp warp = make_acceptance_warp(acceptance);
  const AcceptanceWarpView v = view(warp);
  std::vector<Vec3> directions;
  directions.reserve(static_cast<std::size_t>(std::max(count, 0)));
  for (int i = 0; i < count; ++i) {
    check_cancelled();
    const std::uint64_t hash = hash_combine(mix_bits(seed), static_cast<std::uint64_t>(i));
    directions.push_back(
        to_float(sample_acceptance(v, normal_quantile(unit_interval(hash_combine(hash, 0))),
                                   normal_quantile(unit_interval(hash_combine(hash, 1))))));
  }
  return directions;
}

}  // namespace omma
