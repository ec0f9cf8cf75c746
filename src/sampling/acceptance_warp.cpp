// Inverts the distribution of the polar angle numerically: Gauss-Legendre quadrature on a fine
// grid, summed from both ends so that the tail keeps its relative accuracy, then Newton's method.
#include "sampling/acceptance_warp.h"

#include <algorithm>
#include <cmath>

namespace omma {
namespace {

constexpr int cells = 512;

// Integral of the polar density over [a, b]: five-point Gauss-Legendre.
double integrate(Kernel kernel, double acceptance_rad, double a, double b) {
  constexpr double node[3] = {0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr double weight[3] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  const auto f = [&](double theta) { return eval_polar_density(kernel, theta, acceptance_rad); };
  double sum = weight[0] * f(middle);
  for (int i = 1; i < 3; ++i)
    sum += weight[i] * (f(middle - half * node[i]) + f(middle + half * node[i]));
  return half * sum;
}

// Beyond this angle the density is zero or below 1e-17 of the whole.
double largest_polar_angle(Kernel kernel, double acceptance_rad) {
  switch (kernel) {
    case Kernel::gaussian:
      return std::min(pi, 3.9 * acceptance_rad);
    case Kernel::pillbox:
      return std::min(pi, 0.5 * acceptance_rad);
    case Kernel::compoundray:
      return std::min(pi, 8.6 * sigma_per_fwhm * acceptance_rad);
  }
  return pi;
}

}  // namespace

AcceptanceWarp make_acceptance_warp(Kernel kernel, double acceptance_rad) {
  constexpr int knots = AcceptanceWarpView::intervals;
  AcceptanceWarp warp;
  warp.kernel = kernel;
  warp.acceptance_rad = acceptance_rad;
  warp.theta.assign(knots + 1, 0.0);
  warp.dtheta.assign(knots + 1, 0.0);
  if (acceptance_rad == 0) return warp;  // all light from the axis

  // Distribution from below and from above, on a grid of polar angles.
  const double end = largest_polar_angle(kernel, acceptance_rad);
  const double width = end / cells;
  std::vector<double> below(cells + 1, 0.0), above(cells + 1, 0.0);
  for (int i = 0; i < cells; ++i)
    below[i + 1] = below[i] + integrate(kernel, acceptance_rad, i * width, (i + 1) * width);
  for (int i = cells; i-- > 0;)
    above[i] = above[i + 1] + integrate(kernel, acceptance_rad, i * width, (i + 1) * width);
  const double total = below[cells];
  warp.polar_integral = total;

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
      const double excess =
          upper_half ? tail - (above[cell + 1] + integrate(kernel, acceptance_rad, theta, high))
                     : below[cell] + integrate(kernel, acceptance_rad, low, theta) - head;
      const double density = eval_polar_density(kernel, theta, acceptance_rad);
      if (!(density > 0)) break;
      const double next = std::clamp(theta - excess / density, low, high);
      const bool done = std::fabs(next - theta) < 1e-15 * end;
      theta = next;
      if (done) break;
    }
    warp.theta[k] = theta;
    const double density = eval_polar_density(kernel, theta, acceptance_rad);
    warp.dtheta[k] = density > 0 ? tail * r / density * r_step : 0.0;
  }
  // At the axis theta grows as r sqrt(total / S(0)), but for CompoundRay's kernel as r^2.
  warp.dtheta[0] = kernel == Kernel::compoundray ? 0.0 : std::sqrt(total) * r_step;
  return warp;
}

AcceptanceWarpView view(const AcceptanceWarp& warp) {
  return {warp.kernel, warp.acceptance_rad, warp.polar_integral, warp.theta.data(),
          warp.dtheta.data()};
}

}  // namespace omma
