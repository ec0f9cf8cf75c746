// Modulation transfer: the transform of S over the plane that touches the sphere at the axis, over
// its integral. Gratings of cycles per radian are straight lines there; for lenses the plane's
// coordinate is sin(theta). A negative value is a grating seen with light and dark exchanged. Of a
// two-dimensional table, whose transform has a phase, it is the magnitude.
#include <algorithm>
#include <cmath>
#include <complex>

#include "omma/acceptance.h"
#include "optics/acceptance_warp.h"
#include "optics/bessel.h"
#include "optics/gauss_legendre.h"
#include "optics/lens_rhabdom.h"
#include "threads/cancel.h"
#include "threads/made_once.h"

namespace omma {
namespace {

// exp(-pi^2 nu^2 width^2/(4 ln 2)).
double gaussian_transfer(double cycles) {
  return std::exp(-pi * pi / (4 * std::log(2.0)) * cycles * cycles);
}

// Of the density exp(-theta^2/(2 sigma^2))/theta: exp(-y) I0(y), y = (pi nu sigma)^2.
double compoundray_transfer(double cycles) {
  const double y = std::pow(pi * cycles * sigma_per_fwhm, 2);
  // From the asymptotic series of I0, which would overflow.
  if (y > 300) return (1 + 1 / (8 * y)) / std::sqrt(2 * pi * y);
  return std::exp(-y) * bessel_i0(y);
}

MadeOnce<Quadrature> made_nodes;

const Quadrature& nodes() {
  return made_nodes.get([] { return gauss_legendre(10); });
}

// Up to so many turns of k in an interval are summed; beyond, closed forms are as exact, and cost
// the same however fast gratings are.
constexpr double most_turns = 8;

// Integral of f over [a, b] in pieces of which none holds more than a turn of k.
template <typename Function>
auto integrate(double a, double b, double k, const Function& f) {
  check_cancelled();
  const int pieces = 1 + static_cast<int>(std::fabs(k) * (b - a) / (2 * pi));
  auto sum = f(a) * 0.0;
  for (int p = 0; p < pieces; ++p)
    for (std::size_t i = 0; i < nodes().node.size(); ++i)
      sum += nodes().weight[i] * (b - a) / pieces * f(a + (b - a) * (p + nodes().node[i]) / pieces);
  return sum;
}

bool is_fast(double a, double b, double k) {
  return std::fabs(k) * (b - a) > 2 * pi * most_turns;
}

// Integral of J0 from x on. Partly integrated again and again the integrals of J0(t)/t^n follow
// from each other, and where x is over 25 the terms fall below 1e-10.
double bessel_integral_beyond(double x) {
  if (x < 25) return 1 - integrate(0, x, 1, [](double t) { return j0(t); });
  const double from_j0 = j0(x) / x, from_j1 = j1(x);
  double sum = 0, factor = 1;  // of what is left, and x^-n
  for (int n = 0; n < 24; n += 2) {
    sum += factor * ((n + 1) * from_j0 - from_j1);
    factor *= -(n + 1.0) * (n + 1.0) / (x * x);
  }
  return sum;
}

// Integral of (value + slope (theta - a)) theta J0(k theta) over [a, b].
double fast_radial(double a, double b, double value, double slope, double k) {
  const double level = value - slope * a;
  const auto below = [&](double theta) {
    const double x = k * theta;
    return (level + slope * theta) * theta * j1(x) / k +
           slope / (k * k) * (theta * j0(x) + bessel_integral_beyond(x) / k);
  };
  return below(b) - below(a);
}

double radial_transfer(const SensitivityView& s, double cycles_k) {
  const double k = std::fabs(cycles_k);
  double sum = 0, whole = 0;
  for (int i = -1; i + 1 < s.columns; ++i) {
    const double a = i < 0 ? 0 : s.right_rad[i], b = s.right_rad[i + 1];
    if (!(b > a)) continue;
    const auto density = [&](double theta) { return eval_table(s, theta, 0) * theta; };
    whole += integrate(a, b, 0, density);
    if (is_fast(a, b, k)) {
      const double at_b = s.table[i + 1], at_a = i < 0 ? at_b : s.table[i];
      sum += fast_radial(a, b, at_a, (at_b - at_a) / (b - a), k);
    } else {
      sum += integrate(a, b, k, [&](double theta) { return density(theta) * j0(k * theta); });
    }
  }
  return sum / whole;
}

// The transform of the tent of each knot.
std::vector<std::complex<double>> tents(const double* knots, int count, double k) {
  std::vector<std::complex<double>> result(static_cast<std::size_t>(count), 0.0);
  for (int i = 0; i + 1 < count; ++i) {
    const double a = knots[i], b = knots[i + 1];
    const auto wave = [&](double x) { return std::polar(1.0, k * x); };
    std::complex<double>& falling = result[static_cast<std::size_t>(i)];
    std::complex<double>& rising = result[static_cast<std::size_t>(i) + 1];
    if (is_fast(a, b, k)) {
      const std::complex<double> step(0, 1 / k);
      const std::complex<double> both = (wave(a) - wave(b)) / (k * k * (b - a));
      falling += wave(a) * step + both;
      rising -= wave(b) * step + both;
      continue;
    }
    falling += integrate(a, b, k, [&](double x) { return wave(x) * ((b - x) / (b - a)); });
    rising += integrate(a, b, k, [&](double x) { return wave(x) * ((x - a) / (b - a)); });
  }
  return result;
}

double bilinear_transform(const SensitivityView& s, double k_right, double k_up) {
  const auto right = tents(s.right_rad, s.columns, k_right), up = tents(s.up_rad, s.rows, k_up);
  std::complex<double> sum = 0;
  for (std::size_t j = 0; j < up.size(); ++j)
    for (std::size_t i = 0; i < right.size(); ++i)
      sum += s.table[j * right.size() + i] * right[i] * up[j];
  return std::abs(sum);
}

}  // namespace

void acceptance_mtf(const Acceptance& a, std::span<const double> cycles_per_rad,
                    std::span<const double> azimuth_rad, std::span<double> transfer) {
  const auto fill = [&](const auto& of) {
    for (std::size_t i = 0; i < transfer.size(); ++i)
      transfer[i] = of(cycles_per_rad[i], azimuth_rad[i]);
  };
  const double waves = a.wavelength_nm * 1e-9 / a.facet_diameter_m;  // lambda/D
  switch (a.kernel) {
    case Kernel::gaussian:
      return fill([&](double cycles, double azimuth) {
        if (is_round(a)) return gaussian_transfer(cycles * a.width_rad);
        return gaussian_transfer(
            cycles * std::hypot(a.width_rad * std::cos(azimuth - a.major_angle_rad),
                                a.minor_width_rad * std::sin(azimuth - a.major_angle_rad)));
      });
    case Kernel::pillbox:
      return fill([&](double cycles, double) { return disc_transform(pi * cycles * a.width_rad); });
    case Kernel::compoundray:
      return fill(
          [&](double cycles, double) { return compoundray_transfer(cycles * a.width_rad); });
    case Kernel::airy:
      return fill([&](double cycles, double) { return airy_transfer(2 * cycles * waves); });
    case Kernel::lens_rhabdom: {
      if (a.model == RhabdomModel::snyder)
        return fill(
            [&](double cycles, double) { return gaussian_transfer(cycles * snyder_width_rad(a)); });
      if (a.model == RhabdomModel::geometric)
        return fill([&](double cycles, double) {
          return airy_transfer(2 * cycles * waves) *
                 disc_transform(pi * cycles * a.rhabdom_diameter_m / a.focal_length_m);
        });
      std::vector<double> frequency;
      for (const double cycles : cycles_per_rad) frequency.push_back(2 * cycles * waves);
      const std::vector<double> found = waveguide_transfer(a, frequency);
      std::copy(found.begin(), found.end(), transfer.begin());
      return;
    }
    case Kernel::table: {
      const Sensitivity sensitivity = make_sensitivity(a);
      const SensitivityView s = view(sensitivity);
      if (is_round(a))
        return fill([&](double cycles, double) { return radial_transfer(s, 2 * pi * cycles); });
      const double whole = bilinear_transform(s, 0, 0);
      return fill([&](double cycles, double azimuth) {
        const double k = 2 * pi * cycles;
        return bilinear_transform(s, k * std::sin(azimuth), k * std::cos(azimuth)) / whole;
      });
    }
  }
}

}  // namespace omma
