// Bessel functions of a grid of x and the nodes of a quadrature are the same for every lens; they
// are made once, and a profile is then a matrix times a vector for each mode.
#include "optics/lens_rhabdom.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "optics/bessel.h"
#include "optics/gauss_legendre.h"
#include "physics/sampling/acceptance_sampling.h"
#include "threads/made_once.h"

namespace omma {
namespace {

// Knots behind the last one, for its slope.
constexpr int margin = 3, rows = profile_knots + margin;

// K_{l+1}(w)/K_l(w), by the recurrence of K, which is stable upwards.
double bessel_k_ratio(int l, double w) {
  double ratio = w < 600 ? bessel_k1_over_k0(w) : 1 + 0.5 / w;
  for (int i = 1; i <= l; ++i) ratio = 1 / ratio + 2 * i / w;
  return ratio;
}

// A zero between two points of different sign: false position that halves the value at an end kept
// twice (Illinois).
double find_zero(const std::function<double(double)>& f, double low, double high) {
  double at_low = f(low), at_high = f(high);
  for (int step = 0; step < 200 && high - low > 1e-15 * std::max(1.0, std::fabs(high)); ++step) {
    double x = high - at_high * (high - low) / (at_high - at_low);
    if (!(x > low && x < high)) x = 0.5 * (low + high);
    const double value = f(x);
    if (value == 0) return x;
    if ((value > 0) == (at_high > 0)) {
      high = x;
      at_high = value;
      at_low *= 0.5;
    } else {
      low = x;
      at_low = value;
      at_high *= 0.5;
    }
    if (std::fabs(value) < 1e-15) break;
  }
  return 0.5 * (low + high);
}

// Zeros of J_l above 0 and up to `last`.
std::vector<double> bessel_zeros(int l, double last) {
  std::vector<double> zeros;
  constexpr double step = 0.1;  // neighbouring zeros are over 2.4 apart
  for (double x = 0.5; x < last; x += step)
    if (jn(l, x) * jn(l, x + step) < 0) {
      const double zero = find_zero([l](double y) { return jn(l, y); }, x, x + step);
      if (zero < last) zeros.push_back(zero);
    }
  return zeros;
}

// Looks for w rather than u, and for its logarithm: a mode LP_0m that begins at V = c has w =
// exp(-1/(c (V - c))) at first, which u close to V does not tell. One that reaches out further than
// 1/least_w radii has nothing inside (its part in S is as w^4), wherever it ends.
WaveguideMode solve_mode(int l, int m, double v, double low_u, double high_u) {
  constexpr double least_w = 1e-100;
  const auto other = [v](double x) { return std::sqrt(std::max((v - x) * (v + x), 0.0)); };
  WaveguideMode mode{l, m, 0, 0, 0, 0};
  mode.w = std::exp(find_zero(
      [&](double log_w) {
        const double w = std::exp(log_w), u = other(w);
        return u * jn(l + 1, u) - w * bessel_k_ratio(l, w) * jn(l, u);
      },
      std::log(std::max(other(high_u), least_w)), std::log(other(low_u))));
  mode.u = other(mode.w);
  const double j = jn(l, mode.u), ratio = bessel_k_ratio(l, mode.w);
  // K_{-1} = K_1, J_{-1} = -J_1.
  const double k_below = l == 0 ? ratio : 1 / bessel_k_ratio(l - 1, mode.w);
  const double j_below = l == 0 ? -j1(mode.u) : jn(l - 1, mode.u);
  const double inside = 0.5 * (1 - j_below * jn(l + 1, mode.u) / (j * j));
  const double outside = 0.5 * (k_below * ratio - 1);
  mode.norm = inside + outside;
  mode.core_power = inside / mode.norm;
  return mode;
}

// Rows of J_l(x t): [rows][nodes], for the knots' x.
struct BesselRows {
  Quadrature quadrature;
  std::vector<double> value;
};

// x t goes up to 202, which is 32 turns: Gauss-Legendre needs more than half that number of nodes,
// and some for what it is multiplied with.
constexpr int pupil_nodes = 192, transfer_nodes = 640;

BesselRows make_rows(int l, Quadrature quadrature) {
  BesselRows made{std::move(quadrature), {}};
  for (int i = 0; i < rows; ++i)
    for (const double t : made.quadrature.node) made.value.push_back(jn(l, i * profile_step * t));
  return made;
}

const BesselRows& pupil_rows(int l) {
  static std::array<MadeOnce<BesselRows>, static_cast<std::size_t>(most_waveguide_parameter) + 2>
      made;
  return made[static_cast<std::size_t>(l)].get(
      [&] { return make_rows(l, gauss_legendre(pupil_nodes)); });
}

// Nodes over the frequencies from 0 to 2: 2 (1 - t^2), which takes the root out of the end of
// airy_transfer.
const BesselRows& transfer_rows() {
  static MadeOnce<BesselRows> made;
  return made.get([] {
    Quadrature q = gauss_legendre(transfer_nodes);
    for (std::size_t i = 0; i < q.node.size(); ++i) {
      q.weight[i] *= 4 * q.node[i];
      q.node[i] = 2 * (1 - q.node[i] * q.node[i]);
    }
    return make_rows(0, std::move(q));
  });
}

// For each row the sum of value * amplitude.
std::vector<double> row_sums(const BesselRows& bessel, const std::vector<double>& amplitude) {
  std::vector<double> sums(rows);
  const std::size_t n = amplitude.size();
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double* row = bessel.value.data() + i * n;
    double part[4] = {};
    for (std::size_t k = 0; k < n; k += 4)
      for (std::size_t p = 0; p < 4; ++p) part[p] += row[k + p] * amplitude[k + p];
    sums[i] = part[0] + part[1] + part[2] + part[3];
  }
  return sums;
}

// What a mode's overlap counts. With an azimuth there are two modes, a cosine's and a sine's, whose
// squares over the azimuth are half as much as without.
double mode_weight(const WaveguideMode& mode) {
  return (mode.l == 0 ? 1 : 2) * mode.core_power / mode.norm;
}

std::vector<double> waveguide_values(const Acceptance& acceptance) {
  const double b = rhabdom_radius_x(acceptance);
  std::vector<double> values(rows, 0.0);
  for (const WaveguideMode& mode : waveguide_modes(waveguide_parameter(acceptance))) {
    const BesselRows& bessel = pupil_rows(mode.l);
    const Quadrature& q = bessel.quadrature;
    std::vector<double> amplitude;
    for (std::size_t k = 0; k < q.node.size(); ++k)
      amplitude.push_back(q.weight[k] * q.node[k] * mode_spectrum(mode, b * q.node[k]));
    const double power = mode_weight(mode);
    const std::vector<double> overlap = row_sums(bessel, amplitude);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += power * overlap[i] * overlap[i];
  }
  return values;
}

std::vector<double> geometric_values(const Acceptance& acceptance) {
  const double b = rhabdom_radius_x(acceptance);
  const BesselRows& bessel = transfer_rows();
  const Quadrature& q = bessel.quadrature;
  std::vector<double> amplitude;
  for (std::size_t k = 0; k < q.node.size(); ++k)
    amplitude.push_back(q.weight[k] * q.node[k] * airy_transfer(q.node[k]) *
                        disc_transform(b * q.node[k]));
  return row_sums(bessel, amplitude);
}

std::shared_ptr<const LensProfile> to_profile(std::vector<double> values) {
  const double largest = *std::max_element(values.begin(), values.end());
  for (double& value : values) value = std::max(value / largest, 0.0);
  const auto profile = std::make_shared<LensProfile>();
  // S is even in x, and sums of waves of at least 16 knots: the first term that the central
  // difference of sixth order leaves out is below 3e-5 of a ring's height.
  const auto at = [&](int i) { return values[static_cast<std::size_t>(std::abs(i))]; };
  for (int i = 0; i < profile_knots; ++i) {
    profile->knots.push_back(at(i));
    profile->knots.push_back(
        (45 * (at(i + 1) - at(i - 1)) - 9 * (at(i + 2) - at(i - 2)) + (at(i + 3) - at(i - 3))) /
        60);
  }
  // S falls as the cube of x, on the average over a ring: the last eight rings say how high.
  constexpr int some = 8 * 16;
  for (int i = profile_knots - some; i < profile_knots; ++i)
    profile->tail += at(i) * std::pow(i, 3) / some;
  return profile;
}

}  // namespace

double waveguide_parameter(const Acceptance& a) {
  return pi * a.rhabdom_diameter_m / (a.wavelength_nm * 1e-9) *
         std::sqrt(a.rhabdom_index * a.rhabdom_index - a.surround_index * a.surround_index);
}

double rhabdom_radius_x(const Acceptance& a) {
  return 0.5 * pi * a.facet_diameter_m * a.rhabdom_diameter_m /
         (a.wavelength_nm * 1e-9 * a.focal_length_m);
}

Acceptance lens_level(const Acceptance& acceptance, double step) {
  const auto to_step = [&](double x) { return std::exp(step * std::round(std::log(x) / step)); };
  Acceptance level = acceptance;
  level.facet_diameter_m = to_step(acceptance.facet_diameter_m);
  if (acceptance.kernel == Kernel::lens_rhabdom)
    level.focal_length_m *= rhabdom_radius_x(level) / to_step(rhabdom_radius_x(acceptance));
  return level;
}

double snyder_width_rad(const Acceptance& a) {
  return std::hypot(a.wavelength_nm * 1e-9 / a.facet_diameter_m,
                    a.rhabdom_diameter_m / a.focal_length_m);
}

std::vector<WaveguideMode> waveguide_modes(double v) {
  std::vector<WaveguideMode> modes;
  // LP_lm begins where J_{l-1} has its m-th zero (l = 0: J_1 its (m-1)-th, or 0), and its u ends
  // where J_l has.
  std::vector<double> cutoffs = bessel_zeros(1, v);
  cutoffs.insert(cutoffs.begin(), 0.0);
  for (int l = 0; !cutoffs.empty(); ++l) {
    const std::vector<double> ends = bessel_zeros(l, v);
    for (std::size_t i = 0; i < cutoffs.size(); ++i)
      modes.push_back(
          solve_mode(l, static_cast<int>(i) + 1, v, cutoffs[i], i < ends.size() ? ends[i] : v));
    cutoffs = ends;
  }
  return modes;
}

double mode_spectrum(const WaveguideMode& mode, double q) {
  const int l = mode.l;
  const double u = mode.u, w = mode.w, v2 = u * u + w * w;
  const double a = w * bessel_k_ratio(l, w);
  // The integrals of J_l J_l R and K_l J_l R over both parts, added up with the mode equation.
  if (std::fabs(q - u) < 1e-5 * u) {  // numerator and denominator vanish: their slopes
    const double j = jn(l, u), next = jn(l + 1, u);
    return (a * (next - l / u * j) + u * j - l * next) / (2 * u) * v2 / (w * w + u * u);
  }
  return (a * jn(l, q) - q * jn(l + 1, q)) * v2 / ((u * u - q * q) * (w * w + q * q));
}

double disc_transform(double x) {
  return std::fabs(x) < 1e-4 ? 1 - x * x / 8 : 2 * j1(x) / x;
}

// Overlap of two discs: the transform of Airy's pattern (e.g. Goodman, Introduction to Fourier
// optics, section 6.3).
double airy_transfer(double frequency) {
  const double s = 0.5 * std::fabs(frequency);
  return s >= 1 ? 0 : 2 / pi * (std::acos(s) - s * std::sqrt(1 - s * s));
}

std::shared_ptr<const LensProfile> make_lens_profile(const Acceptance& acceptance) {
  if (acceptance.kernel == Kernel::lens_rhabdom)
    return to_profile(acceptance.model == RhabdomModel::waveguide ? waveguide_values(acceptance)
                                                                  : geometric_values(acceptance));
  static MadeOnce<std::shared_ptr<const LensProfile>> airy;
  return airy.get([] {
    std::vector<double> values;
    for (int i = 0; i < rows; ++i) values.push_back(std::pow(disc_transform(i * profile_step), 2));
    return to_profile(std::move(values));
  });
}

double coupling_efficiency(const Acceptance& acceptance) {
  if (acceptance.kernel != Kernel::lens_rhabdom || acceptance.model == RhabdomModel::snyder)
    return 1;
  const double b = rhabdom_radius_x(acceptance);
  // What of an Airy pattern is within b (Born and Wolf, Principles of optics, 8.5.2).
  if (acceptance.model == RhabdomModel::geometric)
    return 1 - std::pow(j0(b), 2) - std::pow(j1(b), 2);
  // A pupil that lets one unit of power through has the amplitude 1/(sqrt(pi) b) at the rhabdom's
  // spatial frequencies q up to b, and a mode the power 2 pi norm: the square of
  //   2 pi b^2/(sqrt(pi) b sqrt(2 pi norm)) integral of mode_spectrum(b t) t dt from 0 to 1.
  const std::vector<double> values = waveguide_values(acceptance);
  return 2 * b * b * *std::max_element(values.begin(), values.end());
}

namespace {

// A mode's spectrum over the pupil, from its centre to its rim, cubic between 512 steps.
class PupilSpectrum {
 public:
  PupilSpectrum(const WaveguideMode& mode, double b) {
    for (int i = -1; i <= steps + 2; ++i)
      table_.push_back(mode_spectrum(mode, b * std::abs(i) / steps) *
                       (i < 0 && mode.l % 2 == 1 ? -1 : 1));
  }
  double at(double q) const {
    const double x = std::min(q, 1.0) * steps;
    const int i = std::min(static_cast<int>(x), steps - 1);
    const double* p = table_.data() + i + 1;
    return hermite(p[0], 0.5 * (p[1] - p[-1]), p[1], 0.5 * (p[2] - p[0]), x - i);
  }

 private:
  static constexpr int steps = 512;
  std::vector<double> table_;
};

MadeOnce<Quadrature> made_nodes;

// The transform of |amplitude|^2 is the autocorrelation of what fills the pupil: an integral over
// the overlap of two pupils whose centres are `frequency` apart. Of a mode with cosine and sine of
// the azimuth the turn from one to the other is left.
double autocorrelation(const PupilSpectrum& spectrum, int l, double frequency) {
  const Quadrature& nodes = made_nodes.get([] { return gauss_legendre(96); });
  const double shift = 0.5 * frequency, most_y = std::sqrt(1 - shift * shift);
  double sum = 0;  // over a quarter of the overlap
  for (std::size_t i = 0; i < nodes.node.size(); ++i) {
    // y = most_y (1 - t^2) takes the root out of the border's end.
    const double t = nodes.node[i], y = most_y * (1 - t * t);
    const double most_x = std::sqrt(std::max(1 - y * y, 0.0)) - shift;
    for (std::size_t k = 0; k < nodes.node.size(); ++k) {
      const double x = most_x * nodes.node[k], low = x - shift, high = x + shift;
      const double turn = l == 0 ? 1 : std::cos(l * (std::atan2(y, high) - std::atan2(y, low)));
      sum += nodes.weight[i] * nodes.weight[k] * 2 * t * most_y * most_x * turn *
             spectrum.at(std::sqrt(low * low + y * y)) *
             spectrum.at(std::sqrt(high * high + y * y));
    }
  }
  return sum;
}

}  // namespace

std::vector<double> waveguide_transfer(const Acceptance& acceptance,
                                       std::span<const double> frequency) {
  std::vector<double> transfer(frequency.size(), 0.0);
  double whole = 0;
  for (const WaveguideMode& mode : waveguide_modes(waveguide_parameter(acceptance))) {
    const PupilSpectrum spectrum(mode, rhabdom_radius_x(acceptance));
    const double power = mode_weight(mode);
    whole += power * autocorrelation(spectrum, mode.l, 0);
    for (std::size_t i = 0; i < transfer.size(); ++i)
      if (std::fabs(frequency[i]) < 2)
        transfer[i] += power * autocorrelation(spectrum, mode.l, std::fabs(frequency[i]));
  }
  for (double& value : transfer) value /= whole;
  return transfer;
}

}  // namespace omma
