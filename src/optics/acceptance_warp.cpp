// A round sensitivity has one row of theta(r). Elliptical Gaussians share rows: at one azimuth each
// is a round Gaussian of some width. Tables have rows at evenly spaced azimuths.
#include "optics/acceptance_warp.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "optics/polar_inverse.h"
#include "threads/made_once.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Knots over the radius. Dark rings and kinks need more: at Airy's first ring 0.0008 of the
// directions are on its wrong side, in a gap of a table 0.002, elsewhere the distribution is within
// 1e-4.
constexpr int smooth_intervals = 512, ring_intervals = 1024;
// Azimuths that the distribution over azimuth is integrated on; rows of a table, and of Gaussians.
constexpr int marginal_steps = 4096, table_rows = 256, gaussian_rows = 256;

// Inverts the cumulative distribution of `density`, given at the middles of evenly spaced azimuths:
// appends the azimuth of each quantile and its row. Returns the integral.
double invert_azimuth(const std::vector<double>& density,
                      const std::function<double(double)>& row_of, std::vector<double>& azimuth) {
  std::vector<double> below{0};
  for (const double d : density) below.push_back(below.back() + d);
  const double total = below.back(), step = 2 * pi / static_cast<double>(density.size());
  std::size_t cell = 0;
  for (int i = 0; i <= AcceptanceWarpView::azimuths; ++i) {
    const double wanted = total * i / AcceptanceWarpView::azimuths;
    while (cell + 1 < density.size() && below[cell + 1] <= wanted) ++cell;
    const double part = density[cell] > 0 ? (wanted - below[cell]) / density[cell] : 1;
    const double a = (static_cast<double>(cell) + std::clamp(part, 0.0, 1.0)) * step;
    azimuth.push_back(a);
    azimuth.push_back(row_of(a));
  }
  return total * step;
}

// Rows of round Gaussians whose widths go evenly from 0 to a whole turn, and of each the polar
// integral over the square of its width.
struct GaussianFamily {
  std::shared_ptr<const WarpRows> rows;
  std::vector<double> integral;
};

SensitivityView gaussian(double width_rad) {
  SensitivityView s;
  s.width_rad = s.minor_width_rad = width_rad;
  return s;
}

const GaussianFamily& gaussian_family() {
  static MadeOnce<GaussianFamily> family;
  return family.get([] {
    std::vector<WarpRows> made(gaussian_rows + 1);
    GaussianFamily all;
    all.integral.assign(gaussian_rows + 1, 0.125 / std::log(2.0));
    parallel_for(1, gaussian_rows + 1, [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      const double width = 2 * pi * i / gaussian_rows;
      const SensitivityView s = gaussian(width);
      all.integral[k] =
          append_inverse(s, 0, polar_cells(s), smooth_intervals, made[k].theta, made[k].dtheta) /
          (width * width);
    });
    const auto rows = std::make_shared<WarpRows>();
    rows->intervals = smooth_intervals;
    rows->theta.assign(smooth_intervals + 1, 0.0);
    rows->dtheta.assign(smooth_intervals + 1, 0.0);
    for (const WarpRows& row : made) {
      rows->theta.insert(rows->theta.end(), row.theta.begin(), row.theta.end());
      rows->dtheta.insert(rows->dtheta.end(), row.dtheta.begin(), row.dtheta.end());
    }
    all.rows = rows;
    return all;
  });
}

// Polar integral of a round Gaussian: a cubic through four neighbours, within 1e-9.
double gaussian_integral(const GaussianFamily& family, double width_rad) {
  const double x = width_rad / (2 * pi) * gaussian_rows;
  const int i = std::clamp(static_cast<int>(x) - 1, 0, gaussian_rows - 3);
  double sum = 0;
  for (int k = 0; k < 4; ++k) {
    double weight = family.integral[static_cast<std::size_t>(i + k)];
    for (int other = 0; other < 4; ++other)
      if (other != k) weight *= (x - i - other) / (k - other);
    sum += weight;
  }
  return sum * width_rad * width_rad;
}

void make_elliptical(const SensitivityView& s, AcceptanceWarp& warp) {
  const GaussianFamily& family = gaussian_family();
  const auto width_at = [&](double azimuth) {
    const double along = std::cos(azimuth - s.major_angle_rad) / s.width_rad;
    const double across = std::sin(azimuth - s.major_angle_rad) / s.minor_width_rad;
    return 1 / std::sqrt(along * along + across * across);
  };
  std::vector<double> density;
  for (int i = 0; i < marginal_steps; ++i)
    density.push_back(gaussian_integral(family, width_at(2 * pi * (i + 0.5) / marginal_steps)));
  const auto row_of = [&](double azimuth) {
    return std::min(width_at(azimuth) / (2 * pi) * gaussian_rows, gaussian_rows - 1e-6);
  };
  warp.integral_sr = invert_azimuth(density, row_of, warp.azimuth);
  warp.rows = family.rows;
}

// Where a direction's line from the axis is inside the table, by the polar angle.
PolarCells line_cells(const SensitivityView& s, double azimuth) {
  double begin = 0, end = pi;
  const auto cut = [&](double per_theta, double least, double most) {
    if (per_theta == 0) {
      if (least > 0 || most < 0) end = 0;
      return;
    }
    begin = std::max(begin, std::min(least / per_theta, most / per_theta));
    end = std::min(end, std::max(least / per_theta, most / per_theta));
  };
  cut(std::sin(azimuth), s.right_rad[0], s.right_rad[s.columns - 1]);
  cut(std::cos(azimuth), s.up_rad[0], s.up_rad[s.rows - 1]);
  const int count = std::clamp(4 * (s.columns + s.rows), 64, 512);
  return even_cells(begin, std::max(begin, end), count);
}

void make_from_table(const SensitivityView& s, AcceptanceWarp& warp) {
  std::vector<double> density(marginal_steps);
  parallel_for(0, marginal_steps, [&](int i) {
    const double azimuth = 2 * pi * (i + 0.5) / marginal_steps;
    density[static_cast<std::size_t>(i)] = polar_integral(s, azimuth, line_cells(s, azimuth));
  });
  std::vector<WarpRows> made(table_rows);
  std::vector<char> dark(table_rows);
  parallel_for(0, table_rows, [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    const double azimuth = 2 * pi * i / table_rows;
    dark[k] = !(append_inverse(s, azimuth, line_cells(s, azimuth), ring_intervals, made[k].theta,
                               made[k].dtheta) > 0);
  });
  const auto rows = std::make_shared<WarpRows>();
  rows->intervals = ring_intervals;
  for (int i = 0; i <= table_rows; ++i) {
    // Azimuths without light take the row of the nearest with some.
    std::size_t k = static_cast<std::size_t>(i % table_rows);
    for (int away = 1; dark[k] != 0 && away < table_rows; ++away) {
      const int side = away % 2 == 1 ? (away + 1) / 2 : table_rows - away / 2;
      k = static_cast<std::size_t>((i + side) % table_rows);
    }
    const WarpRows& row = made[k];
    rows->theta.insert(rows->theta.end(), row.theta.begin(), row.theta.end());
    rows->dtheta.insert(rows->dtheta.end(), row.dtheta.begin(), row.dtheta.end());
  }
  const auto row_of = [](double azimuth) {
    return std::min(azimuth / (2 * pi) * table_rows, table_rows - 1e-6);
  };
  warp.integral_sr = invert_azimuth(density, row_of, warp.azimuth);
  warp.rows = rows;
}

}  // namespace

Sensitivity make_sensitivity(const Acceptance& acceptance) {
  Sensitivity sensitivity{acceptance, nullptr};
  if (acceptance.kernel == Kernel::lens_rhabdom && acceptance.model == RhabdomModel::snyder) {
    sensitivity.acceptance = {};
    sensitivity.acceptance.width_rad = snyder_width_rad(acceptance);
  } else if (acceptance.kernel == Kernel::airy || acceptance.kernel == Kernel::lens_rhabdom) {
    sensitivity.profile = make_lens_profile(acceptance);
  }
  return sensitivity;
}

SensitivityView view(const Sensitivity& sensitivity) {
  const Acceptance& a = sensitivity.acceptance;
  SensitivityView s;
  s.kernel = a.kernel;
  s.width_rad = a.width_rad;
  s.minor_width_rad = a.minor_width_rad > 0 ? a.minor_width_rad : a.width_rad;
  s.major_angle_rad = a.major_angle_rad;
  if (sensitivity.profile != nullptr) {
    s.profile = sensitivity.profile->knots.data();
    s.knots = profile_knots;
    s.knots_per_sine = pi * a.facet_diameter_m / (a.wavelength_nm * 1e-9) / profile_step;
    s.tail = sensitivity.profile->tail;
  }
  if (a.table != nullptr) {
    s.right_rad = a.table->right_rad.data();
    s.up_rad = a.table->up_rad.data();
    s.table = a.table->sensitivity.data();
    s.columns = static_cast<int>(a.table->right_rad.size());
    s.rows = static_cast<int>(a.table->up_rad.size());
  }
  return s;
}

AcceptanceWarp make_acceptance_warp(const Acceptance& acceptance) {
  AcceptanceWarp warp;
  warp.acceptance = acceptance;
  warp.sensitivity = make_sensitivity(acceptance);
  warp.round = is_round(acceptance);
  const SensitivityView s = view(warp.sensitivity);
  const bool has_width = s.kernel == Kernel::gaussian || s.kernel == Kernel::pillbox ||
                         s.kernel == Kernel::compoundray;
  if (has_width && s.width_rad == 0) return warp;  // all light from the axis
  if (!warp.round) {
    (s.kernel == Kernel::gaussian ? make_elliptical : make_from_table)(s, warp);
    return warp;
  }
  const auto rows = std::make_shared<WarpRows>();
  rows->intervals = has_width ? smooth_intervals : ring_intervals;
  warp.integral_sr =
      2 * pi * append_inverse(s, 0, polar_cells(s), rows->intervals, rows->theta, rows->dtheta);
  warp.rows = rows;
  return warp;
}

AcceptanceWarpView view(const AcceptanceWarp& warp) {
  AcceptanceWarpView v;
  v.sensitivity = view(warp.sensitivity);
  v.integral_sr = warp.integral_sr;
  if (warp.rows == nullptr) return v;
  v.intervals = warp.rows->intervals;
  v.theta = warp.rows->theta.data();
  v.dtheta = warp.rows->dtheta.data();
  v.azimuth = warp.azimuth.empty() ? nullptr : warp.azimuth.data();
  v.rows = static_cast<int>(warp.rows->theta.size()) / (v.intervals + 1);
  return v;
}

}  // namespace omma
