// Angular sensitivity of an ommatidium: S(theta) per unit solid angle, its distribution over the
// polar angle and the exact warp from uniform numbers to directions.
//
// Every kernel is a density over the polar angle theta (the measure is sin(theta) dtheta dphi, so
// wide ommatidia are exact) and uniform in azimuth. A sample starts from two independent standard
// normals: their radius r is Rayleigh distributed, so u = 1 - exp(-r^2/2) is uniform, and theta is
// the inverse of the kernel's distribution function at u. The composed map theta(r) is smooth and
// nearly linear for a Gaussian, which is why it is what the table below holds.
#pragma once

#include "omma/kernel.h"
#include "omma/vec.h"

namespace omma {

// Standard deviation over full width at half maximum of a normal: 1 / (2 sqrt(2 ln 2)).
inline constexpr double sigma_per_fwhm = 0.42466090014400953;

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

// S(theta), not normalised; acceptance > 0. `compoundray`: CompoundRay draws theta from a
// one-dimensional normal of full width `acceptance` and azimuth uniformly (Millward, Maddock,
// Mangan 2022, eLife 73893), which per unit solid angle is that normal over sin(theta).
OMMA_HD double eval_acceptance(Kernel kernel, double theta_rad, double acceptance_rad) {
  const double q = theta_rad / acceptance_rad;
  switch (kernel) {
    case Kernel::gaussian:
      return exp(-2.7725887222397811 * q * q);  // 4 ln 2
    case Kernel::pillbox:
      return q <= 0.5 ? 1.0 : 0.0;
    case Kernel::compoundray:
      return folded_half_normal(theta_rad, sigma_per_fwhm * acceptance_rad) /
             fmax(sin(theta_rad), 1e-300);
  }
  return 0;
}

// Density over theta, not normalised: S(theta) sin(theta). Kept apart from eval_acceptance because
// CompoundRay's kernel is finite here where S is not.
OMMA_HD double eval_polar_density(Kernel kernel, double theta_rad, double acceptance_rad) {
  if (kernel == Kernel::compoundray)
    return folded_half_normal(theta_rad, sigma_per_fwhm * acceptance_rad);
  return eval_acceptance(kernel, theta_rad, acceptance_rad) * sin(theta_rad);
}

// The warp theta(r) of one kernel and acceptance angle, cubic Hermite between knots; made on the
// host by sampling/acceptance_warp.
struct AcceptanceWarpView {
  static constexpr int intervals = 512;
  static constexpr double r_max = 8.0;  // exp(-r_max^2/2) is below one in 2^46
  Kernel kernel = Kernel::gaussian;
  double acceptance_rad = 0;
  double polar_integral = 0;       // of eval_polar_density over [0, pi]
  const double* theta = nullptr;   // [intervals + 1], rad
  const double* dtheta = nullptr;  // [intervals + 1], d theta / d knot
};

// Polar angle for the radius r of a pair of standard normals.
OMMA_HD double sample_polar_angle(const AcceptanceWarpView& warp, double r) {
  const double x = fmin(r * (AcceptanceWarpView::intervals / AcceptanceWarpView::r_max),
                        AcceptanceWarpView::intervals - 1e-9);
  const int i = static_cast<int>(x);
  const double t = x - i, t2 = t * t, t3 = t2 * t;
  return warp.theta[i] * (2 * t3 - 3 * t2 + 1) + warp.dtheta[i] * (t3 - 2 * t2 + t) +
         warp.theta[i + 1] * (3 * t2 - 2 * t3) + warp.dtheta[i + 1] * (t3 - t2);
}

// A direction around the axis (0, 0, 1) from a pair of independent standard normals.
OMMA_HD Vec3d sample_acceptance(const AcceptanceWarpView& warp, double normal_x, double normal_y) {
  const double r = sqrt(normal_x * normal_x + normal_y * normal_y);
  if (r == 0 || warp.acceptance_rad == 0) return {0, 0, 1};
  const double theta = sample_polar_angle(warp, r);
  const double s = sin(theta) / r;
  return {normal_x * s, normal_y * s, cos(theta)};
}

// Density of sample_acceptance per unit solid angle at polar angle theta.
OMMA_HD double acceptance_pdf(const AcceptanceWarpView& warp, double theta_rad) {
  return eval_acceptance(warp.kernel, theta_rad, warp.acceptance_rad) /
         (2 * pi * warp.polar_integral);
}

// Quantile of the standard normal, relative error below 1.15e-9 before and 1e-15 after one step of
// Halley's method: Acklam's rational approximation (P. J. Acklam 2003), refined.
OMMA_HD double normal_quantile(double u) {
  const double low = 0.02425;
  double x;
  if (u < low || u > 1 - low) {
    const double q = sqrt(-2 * log(u < low ? u : 1 - u));
    x = (((((-7.784894002430293e-03 * q - 3.223964580411365e-01) * q - 2.400758277161838e+00) * q -
           2.549732539343734e+00) *
              q +
          4.374664141464968e+00) *
             q +
         2.938163982698783e+00) /
        ((((7.784695709041462e-03 * q + 3.224671290700398e-01) * q + 2.445134137142996e+00) * q +
          3.754408661907416e+00) *
             q +
         1.0);
    if (u > 1 - low) x = -x;
  } else {
    const double q = u - 0.5, r = q * q;
    x = (((((-3.969683028665376e+01 * r + 2.209460984245205e+02) * r - 2.759285104469687e+02) * r +
           1.383577518672690e+02) *
              r -
          3.066479806614716e+01) *
             r +
         2.506628277459239e+00) *
        q /
        (((((-5.447609879822406e+01 * r + 1.615858368580409e+02) * r - 1.556989798598866e+02) * r +
           6.680131188771972e+01) *
              r -
          1.328068155288572e+01) *
             r +
         1.0);
  }
  const double e = 0.5 * erfc(-x * 0.70710678118654752) - u;
  const double step = e * 2.5066282746310005 * exp(0.5 * x * x);
  return x - step / (1 + 0.5 * x * step);
}

}  // namespace omma
