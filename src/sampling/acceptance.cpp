// The functions of omma/acceptance.h.
#include "omma/acceptance.h"

#include <algorithm>
#include <cmath>

#include "kernel/hash.h"
#include "omma/error.h"
#include "sampling/acceptance_warp.h"

namespace omma {
namespace {

void validate_table(const SensitivityTable* table, const std::string& where) {
  if (table == nullptr) throw Error(where + ": expected a table of sensitivities, found none");
  const auto check_angles = [&](const std::vector<double>& angles, const char* name, double least) {
    if (angles.size() < 2)
      throw Error(where + ", " + name + ": expected at least two angles, found " +
                  std::to_string(angles.size()));
    for (std::size_t k = 0; k < angles.size(); ++k)
      if (!(angles[k] >= least && angles[k] <= pi) || (k > 0 && !(angles[k] > angles[k - 1])))
        throw Error(where + ", " + name + ": expected ascending angles from " +
                    std::to_string(least) + " to pi rad, found " + std::to_string(angles[k]));
  };
  const bool radial = table->up_rad.empty();
  check_angles(table->right_rad, radial ? "angle_rad" : "right_rad", radial ? 0 : -pi);
  if (!radial) check_angles(table->up_rad, "up_rad", -pi);
  const std::size_t size = table->right_rad.size() * (radial ? 1 : table->up_rad.size());
  if (table->sensitivity.size() != size)
    throw Error(where + ", sensitivity: expected " + std::to_string(size) + " values, found " +
                std::to_string(table->sensitivity.size()));
  bool any = false;
  for (const double s : table->sensitivity) {
    if (!std::isfinite(s) || s < 0)
      throw Error(where + ", sensitivity: expected numbers of at least 0, found " +
                  std::to_string(s));
    any = any || s > 0;
  }
  if (!any) throw Error(where + ", sensitivity: expected a number above 0, found none");
}

}  // namespace

bool is_round(const Acceptance& a) {
  if (a.kernel == Kernel::gaussian)
    return a.minor_width_rad == 0 || a.minor_width_rad == a.width_rad;
  return a.kernel != Kernel::table || a.table->up_rad.empty();
}

void validate_acceptance(const Acceptance& a, const std::string& where) {
  const auto expect = [&](bool good, const char* parameter, const char* expected, double found) {
    if (!good)
      throw Error(where + ", " + parameter + ": expected " + expected + ", found " +
                  std::to_string(found));
  };
  const auto length = [&](double value, const char* parameter) {
    expect(std::isfinite(value) && value > 0, parameter, "a positive length", value);
  };
  if (a.kernel <= Kernel::compoundray)
    expect(a.width_rad >= 0 && a.width_rad <= 2 * pi, "width_rad", "0 to 2 pi rad", a.width_rad);
  if (a.kernel == Kernel::gaussian) {
    expect(a.minor_width_rad >= 0 && a.minor_width_rad <= a.width_rad, "minor_width_rad",
           "0 (round) to width_rad", a.minor_width_rad);
    expect(std::isfinite(a.major_angle_rad), "major_angle_rad", "an angle", a.major_angle_rad);
  }
  if (a.kernel == Kernel::airy || a.kernel == Kernel::lens_rhabdom) {
    length(a.facet_diameter_m, "facet_diameter_m");
    expect(std::isfinite(a.wavelength_nm) && a.wavelength_nm > 0, "wavelength_nm",
           "a positive wavelength", a.wavelength_nm);
  }
  if (a.kernel == Kernel::lens_rhabdom) {
    length(a.focal_length_m, "focal_length_m");
    length(a.rhabdom_diameter_m, "rhabdom_diameter_m");
    expect(std::isfinite(a.surround_index) && a.surround_index >= 1, "surround_index",
           "a refractive index of at least 1", a.surround_index);
    expect(std::isfinite(a.rhabdom_index) && a.rhabdom_index > a.surround_index, "rhabdom_index",
           "more than surround_index", a.rhabdom_index);
  }
  if (a.kernel == Kernel::table) validate_table(a.table.get(), where);
}

namespace {

// Where S along an azimuth, from the axis outwards, last is at least half its largest value there.
double half_width_rad(const SensitivityView& s, double azimuth_rad) {
  constexpr int steps = 4096;
  // Sines of the angles are spaced evenly where only they count.
  const auto at = [&](double t) { return eval_sensitivity(s, t * t * pi, azimuth_rad); };
  const double half = 0.5;
  for (int k = steps; k-- > 0;) {
    double low = static_cast<double>(k) / steps, high = static_cast<double>(k + 1) / steps;
    if (at(low) < half) continue;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (low + high);
      (at(middle) >= half ? low : high) = middle;
    }
    return low * low * pi;
  }
  return 0;
}

}  // namespace

double acceptance_width_rad(const Acceptance& a, double azimuth_rad) {
  if (a.kernel <= Kernel::compoundray && is_round(a)) return a.width_rad;
  const Sensitivity sensitivity = make_sensitivity(a);
  const SensitivityView s = view(sensitivity);
  const double there = half_width_rad(s, azimuth_rad);
  return there + (is_round(a) ? there : half_width_rad(s, azimuth_rad + pi));
}

double mean_acceptance_width_rad(const Acceptance& a) {
  if (is_round(a)) return acceptance_width_rad(a, 0);
  if (a.kernel == Kernel::gaussian) return std::sqrt(a.width_rad * a.minor_width_rad);
  double narrowest = 1e300, widest = 0;
  for (int k = 0; k < 90; ++k) {
    const double width = acceptance_width_rad(a, k * pi / 90);
    narrowest = std::min(narrowest, width);
    widest = std::max(widest, width);
  }
  return std::sqrt(narrowest * widest);
}

void eval_acceptance(const Acceptance& acceptance, std::span<const double> theta_rad,
                     std::span<const double> azimuth_rad, std::span<double> sensitivity) {
  const Sensitivity made = make_sensitivity(acceptance);
  for (std::size_t i = 0; i < sensitivity.size(); ++i)
    sensitivity[i] = eval_sensitivity(view(made), theta_rad[i], azimuth_rad[i]);
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

void acceptance_pdf(const Acceptance& acceptance, std::span<const double> theta_rad,
                    std::span<const double> azimuth_rad, std::span<double> per_sr) {
  const AcceptanceWarp warp = make_acceptance_warp(acceptance);
  for (std::size_t i = 0; i < per_sr.size(); ++i)
    per_sr[i] = acceptance_pdf(view(warp), theta_rad[i], azimuth_rad[i]);
}

// The response to 1 + cos(2 pi nu t), t the angle along the azimuth: over directions spread evenly
// through the warp.
void acceptance_mtf(const Acceptance& acceptance, std::span<const double> cycles_per_rad,
                    std::span<const double> azimuth_rad, std::span<double> transfer) {
  const AcceptanceWarp warp = make_acceptance_warp(acceptance);
  constexpr int points = 1 << 16;
  std::vector<Vec3d> directions;
  for (int i = 0; i < points; ++i) {
    const double r = std::sqrt(-2 * std::log((i + 0.5) / points));
    const double turn = 2 * pi * i * 0.61803398874989485;
    directions.push_back(sample_acceptance(view(warp), r * std::cos(turn), r * std::sin(turn)));
  }
  for (std::size_t k = 0; k < transfer.size(); ++k) {
    const double up = std::cos(azimuth_rad[k]), right = std::sin(azimuth_rad[k]);
    double cosine = 0, sine = 0;
    for (const Vec3d& d : directions) {
      const double phase = 2 * pi * cycles_per_rad[k] * std::atan2(d.x * up + d.y * right, d.z);
      cosine += std::cos(phase);
      sine += std::sin(phase);
    }
    transfer[k] = std::hypot(cosine, sine) / points;
  }
}

}  // namespace omma
