// Widths, values and modulation transfer against closed forms and published numbers.
#include <gtest/gtest.h>

#include "optics/bessel.h"
#include "optics/footprint_width.h"
#include "optics/lens_rhabdom.h"
#include "optics_acceptances.h"

namespace omma::test {
namespace {

double waves(const Acceptance& a) {
  return a.wavelength_nm * 1e-9 / a.facet_diameter_m;
}

// What stands in for the C++ library's functions where it has none. 1e-13: some hundreds of
// roundings of terms of one size.
TEST(OpticsNumbers, BesselFunctionsByTheirIntegrals) {
  for (const double x : {0.0, 1e-3, 0.5, 1.0, 10.0, 100.0, 300.0})
    EXPECT_NEAR(bessel_i0_integral(x) / std::cyl_bessel_i(0.0, x), 1, 1e-13) << x;
  for (const double w : {1e-6, 1e-3, 0.1, 1.0, 3.0, 30.0, 599.0})
    EXPECT_NEAR(scaled_bessel_k_integral(1, w) / scaled_bessel_k_integral(0, w),
                std::cyl_bessel_k(1.0, w) / std::cyl_bessel_k(0.0, w),
                1e-13 * std::cyl_bessel_k(1.0, w) / std::cyl_bessel_k(0.0, w))
        << w;
}

TEST(OpticsNumbers, AiryPatternAndItsWidth) {
  const Acceptance a = airy(50, 500);
  EXPECT_NEAR(acceptance_width_rad(a, 0.3) / waves(a), 1.0290, 1.0290 * 0.005);
  for (const double x : {0.01, 0.5, 1.0, 1.616, 3.0, 3.8317, 5.0, 20.0, 100.3, 190.0}) {
    const double theta = std::asin(x * waves(a) / pi);
    // Between knots h apart a cubic is off by h^4/384 of the fourth derivative, which is 0.625 at
    // the centre and 8 times a ring's height further out, where that falls as 8/(pi x^3).
    EXPECT_NEAR(eval_one(a, theta), std::pow(2 * std::cyl_bessel_j(1, x) / x, 2),
                std::fmin(2.5e-6, 3.2e-5 * 8 / pi / (x * x * x)))
        << x;
  }
  EXPECT_EQ(eval_one(a, 91 * degree), 0);
  // Beyond the 64th ring the mean of one.
  EXPECT_NEAR(eval_one(a, std::asin(250 * waves(a) / pi)) / (4 / pi / std::pow(250, 3)), 1, 0.01);
  // The first dark ring, 1.22 lambda/D.
  EXPECT_LT(eval_one(a, std::asin(1.2197 * waves(a))), 1e-6);
}

TEST(OpticsNumbers, AiryWithTheDiscOfARhabdom) {
  const double w[] = {0.5, 1, 1.5, 2, 3}, width[] = {1.067, 1.173, 1.423, 1.874, 2.938};
  for (std::size_t i = 0; i < 5; ++i) {
    const Acceptance a = lens_rhabdom(RhabdomModel::geometric, 40, 2, w[i]);
    EXPECT_NEAR(acceptance_width_rad(a, 0) / waves(a), width[i], 0.01 * width[i]);
    const Acceptance snyder = lens_rhabdom(RhabdomModel::snyder, 40, 2, w[i]);
    EXPECT_NEAR(acceptance_width_rad(snyder, 0) / waves(snyder), std::hypot(1, w[i]), 1e-12);
  }
}

// Directly: the mean of Airy's pattern over a disc, in polar coordinates.
TEST(OpticsNumbers, GeometricSensitivityIsAMeanOverTheDisc) {
  const Acceptance a = lens_rhabdom(RhabdomModel::geometric, 100, 2, 1.7);
  const double radius = 0.5 * 1.7 * pi;  // in x
  const auto mean = [&](double x) {
    constexpr int rings = 200, spokes = 200;
    double sum = 0;
    for (int i = 0; i < rings; ++i)
      for (int j = 0; j < spokes; ++j) {
        const double r = radius * std::sqrt((i + 0.5) / rings), phi = pi * (j + 0.5) / spokes;
        const double y = std::hypot(x + r * std::cos(phi), r * std::sin(phi));
        sum += std::pow(2 * std::cyl_bessel_j(1, y) / y, 2);
      }
    return sum;
  };
  const double peak = mean(0);
  for (const double x : {1.0, 3.0, 5.0, 9.0})
    // The midpoint rule is within 3e-5.
    EXPECT_NEAR(eval_one(a, std::asin(x * waves(a) / pi)), mean(x) / peak, 5e-5) << x;
}

TEST(OpticsNumbers, GaussianPillboxAndEllipse) {
  for (const double width : {0.01, 0.5, 3.0}) {
    EXPECT_NEAR(eval_one(round_acceptance(Kernel::gaussian, width), width / 2), 0.5, 1e-12);
    EXPECT_EQ(eval_one(round_acceptance(Kernel::pillbox, width), width * 0.499), 1);
    EXPECT_EQ(eval_one(round_acceptance(Kernel::pillbox, width), width * 0.501), 0);
  }
  const Acceptance e = elliptical(0.2, 0.05, 0.6);
  EXPECT_FALSE(is_round(e));
  EXPECT_TRUE(is_round(elliptical(0.2, 0.2, 0.6)));
  EXPECT_NEAR(acceptance_width_rad(e, 0.6), 0.2, 1e-12);
  EXPECT_NEAR(acceptance_width_rad(e, 0.6 + pi / 2), 0.05, 1e-12);
  EXPECT_NEAR(acceptance_width_rad(e, 0.6 + pi / 4), std::sqrt(2 / (25.0 + 400)), 1e-12);
  EXPECT_NEAR(mean_acceptance_width_rad(e), 0.1, 1e-12);
  for (int i = 0; i < 12; ++i)
    EXPECT_NEAR(eval_one(e, acceptance_width_rad(e, i * 0.5) / 2, i * 0.5), 0.5, 1e-12);
  EXPECT_NEAR(eval_one(e, 0.1, 0.6 + pi), 0.5, 1e-12);
}

TEST(OpticsNumbers, Tables) {
  const Acceptance profile = measured({0.1, 0.2, 0.4}, {1, 0.8, 0});
  EXPECT_NEAR(eval_one(profile, 0.05), 1, 1e-12);
  EXPECT_NEAR(eval_one(profile, 0.15, 2), 0.9, 1e-12);
  EXPECT_NEAR(eval_one(profile, 0.3), 0.4, 1e-12);
  EXPECT_EQ(eval_one(profile, 0.41), 0);
  EXPECT_NEAR(acceptance_width_rad(profile, 0), 2 * 0.275, 1e-12);
  EXPECT_NEAR(acceptance_width_rad(measured({0, 0.2}, {1, 0.7}), 0), 0.4, 1e-12);
  // A tent to the right, and twice as high on its right side.
  const Acceptance map =
      measured_2d(0.4, 0.2, 5, 3, [](double right, double) { return right < 0.1 ? 0.0 : right; });
  EXPECT_NEAR(eval_one(map, 0.3, pi / 2), 0.75, 1e-12);
  EXPECT_NEAR(eval_one(map, 0.1, pi / 2), 0.25, 1e-12);
  EXPECT_NEAR(eval_one(map, 0.3, -pi / 2), 0, 1e-12);
  EXPECT_NEAR(eval_one(map, std::hypot(0.3, 0.1), std::atan2(0.3, 0.1)), 0.75, 1e-12);
  EXPECT_EQ(eval_one(map, 0.3, 0), 0);
  EXPECT_NEAR(acceptance_width_rad(map, pi / 2), 0.2, 1e-3);
}

// A Gaussian measured finely has a Gaussian's width, transfer, footprint and directions.
TEST(OpticsNumbers, TablesOfAGaussian) {
  const double width = 0.05;
  const auto gaussian = [&](double theta) {
    return std::exp(-4 * std::log(2.0) * theta * theta / (width * width));
  };
  std::vector<double> angle, sensitivity;
  for (int i = 0; i <= 200; ++i) {
    angle.push_back(3 * width * i / 200);
    sensitivity.push_back(gaussian(angle.back()));
  }
  const Acceptance exact = elliptical(width, width, 0);
  const Acceptance map = measured_2d(
      2 * width, 2 * width, 81, 81, [&](double x, double y) { return gaussian(std::hypot(x, y)); });
  for (const Acceptance& a : {measured(angle, sensitivity), map}) {
    EXPECT_NEAR(acceptance_width_rad(a, 1), width, 2e-3 * width);
    EXPECT_NEAR(mean_acceptance_width_rad(a), width, 2e-3 * width);
    EXPECT_NEAR(widest_footprint_rad(make_sensitivity(a)),
                widest_footprint_rad(make_sensitivity(exact)), 0.02 * width);
    // Straight lines between knots, 0.05 of the width apart, add 0.05^2/6 to a variance of 0.18.
    for (const double cycles : {2.0, 8.0, 15.0})
      EXPECT_NEAR(mtf_one(a, cycles, 0.4), mtf_one(exact, cycles), 1e-3);
    EXPECT_NEAR(pdf_one(a, 0.01, 1) / pdf_one(exact, 0.01), 1, 3e-3);
  }
}

TEST(OpticsNumbers, TransferFollowsTheClosedForms) {
  for (const double nu_width : {0.0, 0.1, 0.4, 0.8, 1.3}) {
    const double width = 0.04, cycles = nu_width / width;
    EXPECT_NEAR(mtf_one(round_acceptance(Kernel::gaussian, width), cycles),
                std::exp(-3.5597 * nu_width * nu_width), 1e-5);
    const double x = pi * nu_width;
    EXPECT_NEAR(mtf_one(round_acceptance(Kernel::pillbox, width), cycles),
                x == 0 ? 1 : 2 * std::cyl_bessel_j(1, x) / x, 1e-12);
    const double y = std::pow(pi * nu_width / 2.354820, 2);
    EXPECT_NEAR(mtf_one(round_acceptance(Kernel::compoundray, width), cycles),
                std::exp(-y) * std::cyl_bessel_i(0, y), 1e-6);
    // An ellipse is as wide for a grating as its variance along it.
    const Acceptance e = elliptical(width, width / 3, 0.2);
    for (const double turn : {0.0, 0.7, pi / 2}) {
      const double variance = std::pow(std::cos(turn), 2) + std::pow(std::sin(turn) / 3, 2);
      EXPECT_NEAR(mtf_one(e, cycles, 0.2 + turn),
                  std::exp(-3.5597 * nu_width * nu_width * variance), 1e-5);
    }
    // The overlap of two circles; nothing beyond D/lambda.
    const Acceptance lens = airy(25, 500);
    const double s = nu_width;
    EXPECT_NEAR(mtf_one(lens, s / waves(lens)),
                s >= 1 ? 0 : 2 / pi * (std::acos(s) - s * std::sqrt(1 - s * s)), 1e-12);
    const Acceptance disc = lens_rhabdom(RhabdomModel::geometric, 25, 2, 1.5);
    const double z = pi * s * 1.5;
    EXPECT_NEAR(mtf_one(disc, s / waves(disc)),
                mtf_one(lens, s / waves(lens)) * (z == 0 ? 1 : 2 * std::cyl_bessel_j(1, z) / z),
                1e-12);
  }
  // Far out compoundray's formula changes to its asymptotic series.
  const double width = 0.04, y = 299.999999,
               cycles = std::sqrt(y) / pi * 2.3548200450309493 / width;
  EXPECT_NEAR(mtf_one(round_acceptance(Kernel::compoundray, width), cycles * 1.00000001) /
                  mtf_one(round_acceptance(Kernel::compoundray, width), cycles),
              1, 2e-6);
}

// The transform of the sensitivity itself, summed on a grid, for all that are narrow: the plane and
// the sphere agree there. Beyond the grid a lens has rings with 0.3 % of the light.
TEST(OpticsNumbers, TransferIsTheTransformOfTheSensitivity) {
  for (const auto& [name, a] : acceptances_of_every_kind()) {
    const double width = mean_acceptance_width_rad(a);
    if (width > 0.5 || a.kernel == Kernel::compoundray) continue;
    const bool lens = a.kernel == Kernel::airy ||
                      (a.kernel == Kernel::lens_rhabdom && a.model != RhabdomModel::snyder);
    // Round lenses: Hankel's transform over x.
    constexpr int steps = 40000, turns = 128;
    const double end = lens ? std::fmin(1, 64 * waves(a)) : 0.8;
    for (const double azimuth : {0.0, 1.1}) {
      const double cycles = 0.4 / acceptance_width_rad(a, azimuth);
      if (!(cycles < 1e3)) continue;
      double real = 0, imaginary = 0, whole = 0;
      for (int j = 0; j < (is_round(a) ? 1 : turns); ++j) {
        const double phi = 2 * pi * (j + 0.5) / turns;
        const int count = is_round(a) ? steps : steps / 20;
        std::vector<double> theta, azimuths(static_cast<std::size_t>(count), phi);
        std::vector<double> value(static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) {
          const double r = end * (i + 0.5) / count;
          theta.push_back(lens ? std::asin(r) : r);
        }
        eval_acceptance(a, theta, azimuths, value);
        for (int i = 0; i < count; ++i) {
          const double r = end * (i + 0.5) / count, k = 2 * pi * cycles * r;
          const double s = value[static_cast<std::size_t>(i)] * r;
          whole += s;
          real +=
              s * (is_round(a) ? std::cyl_bessel_j(0, k) : std::cos(k * std::cos(phi - azimuth)));
          imaginary += s * (is_round(a) ? 0 : std::sin(k * std::cos(phi - azimuth)));
        }
      }
      const double found = mtf_one(a, cycles, azimuth);
      EXPECT_NEAR(is_round(a) ? found : std::fabs(found),
                  (is_round(a) ? real : std::hypot(real, imaginary)) / whole, 4e-3)
          << name << " along " << azimuth;
    }
  }
}

// The widest footprint changes the transfer by less than 0.01, as physics/surface/footprint.h promises; and
// is at least a third of what would change it by as much.
TEST(OpticsNumbers, FootprintsKeepTheTransfer) {
  std::vector<NamedAcceptance> all = acceptances_of_every_kind();
  for (const double wide : {0.3, 1.0, 2.0, 4.0, 7.0})
    for (const double rhabdom : {1.0, 1.4, 1.9, 2.6, 4.0}) {
      all.push_back({"waveguide " + std::to_string(rhabdom) + " " + std::to_string(wide),
                     lens_rhabdom(RhabdomModel::waveguide, 25, rhabdom, wide)});
      all.push_back({"geometric " + std::to_string(wide),
                     lens_rhabdom(RhabdomModel::geometric, 25, 2, wide)});
    }
  for (const auto& [name, a] : all) {
    const double width = mean_acceptance_width_rad(a),
                 t = widest_footprint_rad(make_sensitivity(a));
    std::vector<double> cycles;
    for (int i = 1; i < 80; ++i) cycles.push_back(0.04 * i / width);
    double most = 0, most_of_three = 0;
    for (int side = 0; side < (is_round(a) ? 1 : 2); ++side) {
      const double azimuth = a.major_angle_rad + side * pi / 2;
      const std::vector<double> along(cycles.size(), azimuth);
      std::vector<double> transfer(cycles.size());
      acceptance_mtf(a, cycles, along, transfer);
      for (std::size_t i = 0; i < cycles.size(); ++i) {
        const double y = std::pow(2 * pi * cycles[i] * t, 2) / 8;
        most = std::fmax(most, std::fabs(transfer[i]) * -std::expm1(-y));
        most_of_three = std::fmax(most_of_three, std::fabs(transfer[i]) * -std::expm1(-9 * y));
      }
    }
    EXPECT_LT(most, 0.0085) << name;
    EXPECT_GT(most_of_three, 0.0085) << name;
    EXPECT_NEAR(footprint_width_rad(make_sensitivity(a), 1 << 20), width / 1024, 1e-3 * width)
        << name;
  }
}

double between_knots(const std::vector<double>& x, const std::vector<double>& y, double at) {
  std::size_t i = 0;
  while (i + 2 < x.size() && at > x[i + 1]) ++i;
  return y[i] + (y[i + 1] - y[i]) * (at - x[i]) / (x[i + 1] - x[i]);
}

// Fast gratings have closed forms of their own; on either side of where those begin, a table says
// the same as the sum over many small steps.
TEST(OpticsNumbers, TransferOfTablesForFastGratings) {
  const std::vector<double> angle = {0, 0.01, 0.5, 1.2}, sensitivity = {1, 0.5, 0.4, 0.1};
  const Acceptance profile = measured(angle, sensitivity);
  const Acceptance map = measured_2d(
      0.8, 0.6, 2, 2, [](double right, double up) { return 1 + 0.4 * right + 0.9 * up; });
  for (const double cycles : {3.0, 11.0, 12.0, 16.0, 17.0, 40.0, 300.0}) {
    const double k = 2 * pi * cycles;
    // The midpoint rule, in 500 steps a turn and more, is within 1e-8.
    const int steps = 200000;
    double sum = 0, whole = 0;
    for (int i = 0; i < steps; ++i) {
      const double theta = 1.2 * (i + 0.5) / steps, s = between_knots(angle, sensitivity, theta);
      sum += s * theta * std::cyl_bessel_j(0, k * theta);
      whole += s * theta;
    }
    EXPECT_NEAR(mtf_one(profile, cycles), sum / whole, 1e-7) << cycles;
    // A map that is a plane: products of integrals along right, at azimuth pi/2.
    double cosines = 0, sines = 0;
    for (int i = 0; i < steps; ++i) {
      const double x = 0.8 * (2.0 * (i + 0.5) / steps - 1);
      cosines += std::cos(k * x) / steps;
      sines += 0.4 * x * std::sin(k * x) / steps;
    }
    EXPECT_NEAR(mtf_one(map, cycles, pi / 2), std::hypot(cosines, sines), 1e-7) << cycles;
  }
}

}  // namespace
}  // namespace omma::test
