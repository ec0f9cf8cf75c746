// Gauss-Legendre quadrature on the cells, summed from both ends so that the tail keeps its relative
// accuracy, then Newton's method.
#include "optics/polar_inverse.h"

#include <algorithm>
#include <cmath>

#include "threads/cancel.h"

namespace omma {
namespace {

// Integral of the polar density over [a, b]: five-point Gauss-Legendre.
double integrate(const SensitivityView& s, double azimuth, double a, double b) {
  constexpr double node[3] = {0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr double weight[3] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  const auto f = [&](double theta) { return eval_polar_density(s, theta, azimuth); };
  double sum = weight[0] * f(middle);
  for (int i = 1; i < 3; ++i)
    sum += weight[i] * (f(middle - half * node[i]) + f(middle + half * node[i]));
  return half * sum;
}

// A cubic through knots that rise stays rising if no slope is above three times the lesser of its
// neighbouring chords (Fritsch and Carlson 1980, SIAM J Numer Anal 17, 238): where S has a dark
// ring theta(r) is vertical.
void limit_slopes(const double* theta, double* dtheta, int intervals) {
  for (int k = 0; k <= intervals; ++k) {
    const double before = k > 0 ? theta[k] - theta[k - 1] : theta[1] - theta[0];
    const double after = k < intervals ? theta[k + 1] - theta[k] : before;
    dtheta[k] = std::clamp(dtheta[k], 0.0, 3 * std::max(std::min(before, after), 0.0));
  }
}

}  // namespace

PolarCells even_cells(double begin, double end, int count) {
  PolarCells cells;
  cells.width = (end - begin) / count;
  for (int i = 0; i <= count; ++i) cells.edge.push_back(begin + i * cells.width);
  return cells;
}

PolarCells polar_cells(const SensitivityView& s) {
  constexpr int count = 512;
  switch (s.kernel) {
    case Kernel::gaussian:
      return even_cells(0, std::min(pi, 3.9 * s.width_rad), count);
    case Kernel::pillbox:
      return even_cells(0, std::min(pi, 0.5 * s.width_rad), count);
    case Kernel::compoundray:
      return even_cells(0, std::min(pi, 8.6 * sigma_per_fwhm * s.width_rad), count);
    case Kernel::airy:
    case Kernel::lens_rhabdom: {
      // The profile's knots as far as they go, then steps that grow, to the side.
      PolarCells cells;
      const double fine = 1 / (s.knots_per_sine * std::ceil(128 / s.knots_per_sine));
      const double last = std::min(1.0, (s.knots - 1) / s.knots_per_sine);
      double sine = 0;
      for (int i = 0; sine < last; sine = ++i * fine) cells.edge.push_back(std::asin(sine));
      for (sine = last; sine < 1; sine *= 1.03) cells.edge.push_back(std::asin(sine));
      cells.edge.push_back(0.5 * pi);
      return cells;
    }
    case Kernel::table: {
      PolarCells cells;
      const double end = std::min(s.right_rad[s.columns - 1], pi);
      cells.edge.push_back(0);
      for (int i = 0; i < s.columns; ++i) {
        const double from = cells.edge.back(), to = std::min(s.right_rad[i], pi);
        const int pieces = static_cast<int>(std::ceil((to - from) / end * count));
        for (int k = 1; k <= pieces; ++k) cells.edge.push_back(from + (to - from) * k / pieces);
      }
      return cells;
    }
  }
  return {};
}

double polar_integral(const SensitivityView& s, double azimuth, const PolarCells& cells) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < cells.edge.size(); ++i)
    sum += integrate(s, azimuth, cells.edge[i], cells.edge[i + 1]);
  return sum;
}

double append_inverse(const SensitivityView& s, double azimuth, const PolarCells& cells,
                      int intervals, std::vector<double>& theta_out,
                      std::vector<double>& dtheta_out) {
  const std::size_t begin = theta_out.size(), knots = static_cast<std::size_t>(intervals) + 1;
  theta_out.resize(begin + knots, 0.0);
  dtheta_out.resize(begin + knots, 0.0);
  double* const theta_of = theta_out.data() + begin;
  double* const dtheta_of = dtheta_out.data() + begin;

  // Distribution from below and from above.
  const std::size_t count = cells.edge.size() - 1;
  std::vector<double> below(count + 1, 0.0), above(count + 1, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    check_cancelled();
    above[i] = integrate(s, azimuth, cells.edge[i], cells.edge[i + 1]);
    below[i + 1] = below[i] + above[i];
  }
  for (std::size_t i = count; i-- > 0;) above[i] += above[i + 1];
  const double total = below[count], end = cells.edge[count];
  if (!(total > 0)) return 0;

  const bool uneven =
      s.kernel == Kernel::airy || s.kernel == Kernel::lens_rhabdom || s.kernel == Kernel::table;
  const double r_step = AcceptanceWarpView::r_max / intervals;
  std::size_t cell = 0;
  for (int k = 1; k <= intervals; ++k) {
    check_cancelled();
    // The share of the distribution above theta at this radius: exp(-r^2/2).
    const double r = k * r_step;
    const double tail = std::exp(-0.5 * r * r) * total;
    const double head = -std::expm1(-0.5 * r * r) * total;
    while (cell + 1 < count && above[cell + 1] > tail) ++cell;

    // Newton's method inside the cell, on whichever of the two sums is the smaller.
    const double low = cells.edge[cell];
    const double high = cells.width > 0 ? low + cells.width : cells.edge[cell + 1];
    const bool upper_half = tail < head;
    double least = low, most = high;
    double theta = 0.5 * (low + high);
    const double guess = theta_of[k - 1] + dtheta_of[k - 1];
    if (uneven && guess > low && guess < high) theta = guess;
    for (int step = 0; step < 8; ++step) {
      const double excess = upper_half
                                ? tail - (above[cell + 1] + integrate(s, azimuth, theta, high))
                                : below[cell] + integrate(s, azimuth, low, theta) - head;
      const double density = eval_polar_density(s, theta, azimuth);
      if (!(density > 0)) break;
      (excess > 0 ? most : least) = theta;
      double next = theta - excess / density;
      // At a dark ring Newton's steps are too long.
      if (!(next >= least && next <= most))
        next = uneven ? 0.5 * (least + most) : std::clamp(next, low, high);
      const bool done = std::fabs(next - theta) < (uneven ? 1e-12 : 1e-15) * end;
      theta = next;
      if (done) break;
    }
    // In the last 1e-12 of the tail rounding could turn it back.
    if (uneven) theta = std::max(theta, theta_of[k - 1]);
    theta_of[k] = theta;
    const double density = eval_polar_density(s, theta, azimuth);
    dtheta_of[k] = density > 0 ? tail * r / density * r_step : 0.0;
  }
  // At the axis theta grows as r sqrt(total / S), but for CompoundRay's kernel as r^2.
  const double on_axis = eval_sensitivity(s, 0, azimuth);
  if (s.kernel != Kernel::compoundray && on_axis > 0)
    dtheta_of[0] = std::sqrt(total / on_axis) * r_step;
  if (uneven) {
    std::size_t first = 0;  // cell that is not dark
    while (first + 1 < count && !(below[first + 1] > 0)) ++first;
    theta_of[0] = cells.edge[first];
    limit_slopes(theta_of, dtheta_of, intervals);
  }
  return total;
}

}  // namespace omma
