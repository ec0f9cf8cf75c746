// Inverts the distribution of the polar angle numerically: Gauss-Legendre quadrature on a fine
// grid, summed from both ends so that the tail keeps its relative accuracy, then Newton's method.
#include "sampling/acceptance_warp.h"

#include <algorithm>
#include <cmath>

namespace omma {
namespace {

constexpr int cells = 512;
constexpr int smooth_intervals = 512;

// Integral of the polar density over [a, b]: five-point Gauss-Legendre.
double integrate(const SensitivityView& s, double a, double b) {
  constexpr double node[3] = {0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr double weight[3] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  const auto f = [&](double theta) { return eval_polar_density(s, theta, 0); };
  double sum = weight[0] * f(middle);
  for (int i = 1; i < 3; ++i)
    sum += weight[i] * (f(middle - half * node[i]) + f(middle + half * node[i]));
  return half * sum;
}

// Beyond this angle the density is zero or below 1e-17 of the whole.
double largest_polar_angle(const SensitivityView& s) {
  switch (s.kernel) {
    case Kernel::gaussian:
      return std::min(pi, 3.9 * s.width_rad);
    case Kernel::pillbox:
      return std::min(pi, 0.5 * s.width_rad);
    case Kernel::compoundray:
      return std::min(pi, 8.6 * sigma_per_fwhm * s.width_rad);
    default:
      return pi;
  }
}

}  // namespace

Sensitivity make_sensitivity(const Acceptance& acceptance) {
  Sensitivity sensitivity;
  sensitivity.acceptance = acceptance;
  return sensitivity;
}

SensitivityView view(const Sensitivity& sensitivity) {
  const Acceptance& a = sensitivity.acceptance;
  SensitivityView s;
  s.kernel = a.kernel;
  s.width_rad = a.width_rad;
  s.minor_width_rad = a.minor_width_rad > 0 ? a.minor_width_rad : a.width_rad;
  s.major_angle_rad = a.major_angle_rad;
  return s;
}

AcceptanceWarp make_acceptance_warp(const Acceptance& acceptance) {
  AcceptanceWarp warp;
  warp.acceptance = acceptance;
  warp.sensitivity = make_sensitivity(acceptance);
  if (acceptance.width_rad == 0) return warp;  // all light from the axis
  const SensitivityView s = view(warp.sensitivity);
  constexpr int knots = smooth_intervals;
  const auto rows = std::make_shared<WarpRows>();
  rows->intervals = knots;
  rows->theta.assign(knots + 1, 0.0);
  rows->dtheta.assign(knots + 1, 0.0);

  // Distribution from below and from above, on a grid of polar angles.
  const double end = largest_polar_angle(s);
  const double width = end / cells;
  std::vector<double> below(cells + 1, 0.0), above(cells + 1, 0.0);
  for (int i = 0; i < cells; ++i)
    below[i + 1] = below[i] + integrate(s, i * width, (i + 1) * width);
  for (int i = cells; i-- > 0;) above[i] = above[i + 1] + integrate(s, i * width, (i + 1) * width);
  const double total = below[cells];
  warp.integral_sr = 2 * pi * total;

  const double r_step = AcceptanceWarpView::r_max / knots;
  int cell = 0;
  for (int k = 1; k <= knots; ++k) {
    // What must lie above theta for this radius: exp(-r^2/2) of the whole.
    const double r = k * r_step;
    const double tail = std::exp(-0.5 * r * r) * total;
    const double head = -std::expm1(-0.5 * r * r) * total;
    while (cell + 1 < cells && above[cell + 1] > tail) ++cell;

    // Newton's method inside the cell, on whichever of the two sums is the smaller.
    const double low = cell * width, high = low + width;
    const bool upper_half = tail < head;
    double theta = 0.5 * (low + high);
    for (int step = 0; step < 8; ++step) {
      const double excess = upper_half ? tail - (above[cell + 1] + integrate(s, theta, high))
                                       : below[cell] + integrate(s, low, theta) - head;
      const double density = eval_polar_density(s, theta, 0);
      if (!(density > 0)) break;
      const double next = std::clamp(theta - excess / density, low, high);
      const bool done = std::fabs(next - theta) < 1e-15 * end;
      theta = next;
      if (done) break;
    }
    rows->theta[k] = theta;
    const double density = eval_polar_density(s, theta, 0);
    rows->dtheta[k] = density > 0 ? tail * r / density * r_step : 0.0;
  }
  // At the axis theta grows as r sqrt(total / S(0)), but for CompoundRay's kernel as r^2.
  rows->dtheta[0] = s.kernel == Kernel::compoundray ? 0.0 : std::sqrt(total) * r_step;
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
  return v;
}

}  // namespace omma
