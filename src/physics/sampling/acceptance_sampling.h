// Angular sensitivity of an ommatidium: S per unit solid angle, and the exact warp from uniform
// numbers to directions. Directions have a polar angle theta from the axis and an azimuth, from the
// up vector towards right. What is heavy (Bessel integrals, waveguide modes, distributions) is
// tabulated on the host (optics/acceptance_warp) and only read here.
//
// A sample starts from two independent standard normals. Their radius r is Rayleigh distributed, so
// u = 1 - exp(-r^2/2) is uniform, and theta is the inverse of the distribution over the polar angle
// at u; the measure is sin(theta) dtheta dphi, so wide ommatidia are exact. The composed map
// theta(r) is smooth and nearly linear for a Gaussian, which is why it is what the table holds.
// Where S is round the azimuth is that of the normals. Where it is not, their azimuth goes through
// the inverse of the distribution over azimuth first, and theta(r) is that of the azimuth found:
// two neighbouring rows of a table, mixed.
#pragma once

#include "omma/kernel.h"
#include "omma/vec.h"

namespace omma {

// Standard deviation over full width at half maximum of a normal: 1 / (2 sqrt(2 ln 2)).
inline constexpr double sigma_per_fwhm = 0.42466090014400953;

// S of one ommatidium. Which fields count depends on the kernel.
struct SensitivityView {
  Kernel kernel = Kernel::gaussian;
  double width_rad = 0;        // gaussian, pillbox, compoundray; of the major axis
  double minor_width_rad = 0;  // gaussian; equal: round
  double major_angle_rad = 0;  // gaussian
  // airy, lens_rhabdom: S over sin(theta), cubic Hermite between knots, in front only. Beyond the
  // last knot, where dark rings lie close, their mean: tail over the cube of the knot's number.
  const double* profile = nullptr;  // [knots][S, slope per knot]
  int knots = 0;
  double knots_per_sine = 0;
  double tail = 0;
  // table: linear between knots over theta, or bilinear over (right, up)
  const double* right_rad = nullptr;  // [columns]
  const double* up_rad = nullptr;     // [rows]
  const double* table = nullptr;      // [rows][columns]
  int columns = 0, rows = 0;          // rows 0: over theta
};

// Half-normal density of the polar angle folded onto [0, pi]: directions turned past pi come round.
OMMA_HD double folded_half_normal(double theta_rad, double sigma_rad) {
  double sum = 0;
  const double inverse = 1.0 / sigma_rad;
  for (int turn = 0; turn < 4; ++turn) {
    const double out = (theta_rad + 2 * pi * turn) * inverse;
    const double back = (2 * pi * (turn + 1) - theta_rad) * inverse;
    sum += exp(-0.5 * out * out) + exp(-0.5 * back * back);
  }
  return sum * inverse * 0.79788456080286536;  // sqrt(2/pi)
}

// Cubic Hermite between knots 0 and 1 with slopes per knot.
OMMA_HD double hermite(double value_0, double slope_0, double value_1, double slope_1, double t) {
  const double t2 = t * t, t3 = t2 * t;
  return value_0 * (2 * t3 - 3 * t2 + 1) + slope_0 * (t3 - 2 * t2 + t) +
         value_1 * (3 * t2 - 2 * t3) + slope_1 * (t3 - t2);
}

OMMA_HD double eval_profile(const SensitivityView& s, double theta_rad) {
  if (theta_rad > 0.5 * pi) return 0;
  const double x = sin(theta_rad) * s.knots_per_sine;
  if (x >= s.knots - 1) return s.tail / (x * x * x);
  const int i = static_cast<int>(x);
  const double* p = s.profile + 2 * i;
  return fmax(hermite(p[0], p[1], p[2], p[3], x - i), 0.0);
}

// Index of the interval of ascending knots that holds x, which lies between the first and the last.
OMMA_HD int find_interval(const double* knots, int count, double x) {
  int low = 0, high = count - 1;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (x < knots[middle] ? high : low) = middle;
  }
  return low;
}

OMMA_HD double eval_table(const SensitivityView& s, double theta_rad, double azimuth_rad) {
  if (s.rows == 0) {
    if (theta_rad > s.right_rad[s.columns - 1]) return 0;
    const double x = fmax(theta_rad, s.right_rad[0]);
    const int i = find_interval(s.right_rad, s.columns, x);
    const double t = (x - s.right_rad[i]) / (s.right_rad[i + 1] - s.right_rad[i]);
    return s.table[i] * (1 - t) + s.table[i + 1] * t;
  }
  const double right = theta_rad * sin(azimuth_rad), up = theta_rad * cos(azimuth_rad);
  if (right < s.right_rad[0] || right > s.right_rad[s.columns - 1] || up < s.up_rad[0] ||
      up > s.up_rad[s.rows - 1])
    return 0;
  const int i = find_interval(s.right_rad, s.columns, right);
  const int j = find_interval(s.up_rad, s.rows, up);
  const double t = (right - s.right_rad[i]) / (s.right_rad[i + 1] - s.right_rad[i]);
  const double v = (up - s.up_rad[j]) / (s.up_rad[j + 1] - s.up_rad[j]);
  const double* p = s.table + j * s.columns + i;
  return (p[0] * (1 - t) + p[1] * t) * (1 - v) +
         (p[s.columns] * (1 - t) + p[s.columns + 1] * t) * v;
}

// S in a direction; 1 at its largest but for `compoundray`, which is not normalised. That one draws
// theta from a one-dimensional normal of full width `width` and azimuth uniformly (Millward,
// Maddock, Mangan 2022, eLife 73893), which per unit solid angle is that normal over sin(theta).
OMMA_HD_LARGE double eval_sensitivity(const SensitivityView& s, double theta_rad, double azimuth_rad) {
  const double q = theta_rad / s.width_rad;
  switch (s.kernel) {
    case Kernel::gaussian: {
      constexpr double four_ln2 = 2.7725887222397811;
      if (s.minor_width_rad == s.width_rad) return exp(-four_ln2 * q * q);
      const double along = q * cos(azimuth_rad - s.major_angle_rad);
      const double across = theta_rad / s.minor_width_rad * sin(azimuth_rad - s.major_angle_rad);
      return exp(-four_ln2 * (along * along + across * across));
    }
    case Kernel::pillbox:
      return q <= 0.5 ? 1.0 : 0.0;
    case Kernel::compoundray:
      return folded_half_normal(theta_rad, sigma_per_fwhm * s.width_rad) /
             fmax(sin(theta_rad), 1e-300);
    case Kernel::airy:
    case Kernel::lens_rhabdom:
      return eval_profile(s, theta_rad);
    case Kernel::table:
      return eval_table(s, theta_rad, azimuth_rad);
  }
  return 0;
}

// Density over theta at an azimuth, not normalised: S(theta) sin(theta). Kept apart from
// eval_sensitivity because CompoundRay's kernel is finite here where S is not.
OMMA_HD double eval_polar_density(const SensitivityView& s, double theta_rad, double azimuth_rad) {
  if (s.kernel == Kernel::compoundray)
    return folded_half_normal(theta_rad, sigma_per_fwhm * s.width_rad);
  return eval_sensitivity(s, theta_rad, azimuth_rad) * sin(theta_rad);
}

// The warp of one sensitivity, made on the host by optics/acceptance_warp: rows of theta(r),
// cubic Hermite between knots. Round: one row. Else, for the azimuth of the pair of normals, the
// azimuth of the direction and the row (a number with a fraction) that gives its polar angle.
struct AcceptanceWarpView {
  static constexpr double r_max = 8.0;  // exp(-r_max^2/2) is below one in 2^46
  static constexpr int azimuths = 1024;
  SensitivityView sensitivity;
  double integral_sr = 0;           // of S over the sphere
  int intervals = 0;                // from r = 0 to r_max; 0: all light comes along the axis
  const double* theta = nullptr;    // [row][intervals + 1], rad
  const double* dtheta = nullptr;   // [row][intervals + 1], d theta / d knot
  const double* azimuth = nullptr;  // [azimuths + 1][azimuth in rad, row]; null: round
  int rows = 0;
};

// Polar angle for the radius r of a pair of standard normals, from one row.
OMMA_HD double sample_polar_angle(const AcceptanceWarpView& warp, double r, int row) {
  const double x = fmin(r * (warp.intervals / AcceptanceWarpView::r_max), warp.intervals - 1e-9);
  const int i = static_cast<int>(x);
  const double* theta = warp.theta + row * (warp.intervals + 1) + i;
  const double* dtheta = warp.dtheta + row * (warp.intervals + 1) + i;
  return hermite(theta[0], dtheta[0], theta[1], dtheta[1], x - i);
}

// A direction around the axis (0, 0, 1), with x up and y right, from a pair of independent standard
// normals.
OMMA_HD Vec3d sample_acceptance(const AcceptanceWarpView& warp, double normal_x, double normal_y) {
  const double r = sqrt(normal_x * normal_x + normal_y * normal_y);
  if (r == 0 || warp.intervals == 0) return {0, 0, 1};
  if (warp.azimuth == nullptr) {
    const double theta = sample_polar_angle(warp, r, 0);
    const double s = sin(theta) / r;
    return {normal_x * s, normal_y * s, cos(theta)};
  }
  const double turn = atan2(normal_y, normal_x) * (0.5 / pi);
  const double x = fmin((turn < 0 ? turn + 1 : turn) * AcceptanceWarpView::azimuths,
                        AcceptanceWarpView::azimuths - 1e-9);
  const int i = static_cast<int>(x);
  const double* p = warp.azimuth + 2 * i;
  const double azimuth = p[0] + (x - i) * (p[2] - p[0]), place = p[1] + (x - i) * (p[3] - p[1]);
  const int row = static_cast<int>(place);
  const double before = sample_polar_angle(warp, r, row);
  const double theta = before + (place - row) * (sample_polar_angle(warp, r, row + 1) - before);
  const double s = sin(theta);
  return {cos(azimuth) * s, sin(azimuth) * s, cos(theta)};
}

// Density of sample_acceptance per unit solid angle.
OMMA_HD double acceptance_pdf(const AcceptanceWarpView& warp, double theta_rad,
                              double azimuth_rad) {
  return eval_sensitivity(warp.sensitivity, theta_rad, azimuth_rad) / warp.integral_sr;
}

}  // namespace omma
