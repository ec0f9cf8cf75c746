// Chi-square tests of the directions of every kind of acceptance against its sensitivity,
// integrated here on its own: in doubles, and as random directions in floats out of tables for many
// warps.
#include <gtest/gtest.h>

#include <algorithm>

#include "optics/acceptance_warp.h"
#include "optics_acceptances.h"
#include "physics/sampling/hash.h"
#include "physics/sampling/random_direction.h"
#include "sampling/polar_tables.h"

namespace omma::test {
namespace {

constexpr int polar_bins = 24, azimuth_bins = 16, samples = 200000;

// Integrals of S over cells of polar angle and azimuth: the midpoint rule on a fine grid.
struct Expected {
  std::vector<double> edge;  // [polar_bins + 1], rad
  std::vector<double> share = std::vector<double>(polar_bins * azimuth_bins, 0.0);
  double integral_sr = 0;
};

// Where S ends, for the grid; further out there is under 1e-6 of it.
double last_angle(const Acceptance& a) {
  switch (a.kernel) {
    case Kernel::gaussian:
    case Kernel::pillbox:
    case Kernel::compoundray:
      return std::min(pi, 2.5 * a.width_rad);
    case Kernel::airy:
      return pi / 2;
    case Kernel::lens_rhabdom:
      return a.model == RhabdomModel::snyder ? 2.5 * acceptance_width_rad(a, 0) : pi / 2;
    case Kernel::table:
      return a.table->up_rad.empty()
                 ? a.table->right_rad.back()
                 : std::hypot(a.table->right_rad.back(), a.table->up_rad.back());
  }
  return pi;
}

Expected integrate(const Acceptance& a) {
  const bool round = is_round(a);
  const int thetas = round ? 1 << 17 : 1 << 11, azimuths = round ? 1 : 1 << 10;
  const double end = last_angle(a), step = end / thetas;
  std::vector<double> theta, azimuth, value(static_cast<std::size_t>(thetas));
  for (int i = 0; i < thetas; ++i) theta.push_back((i + 0.5) * step);
  std::vector<std::vector<double>> mass;  // [azimuth][theta]
  std::vector<double> polar(static_cast<std::size_t>(thetas), 0.0);
  Expected expected;
  for (int j = 0; j < azimuths; ++j) {
    azimuth.assign(static_cast<std::size_t>(thetas), 2 * pi * (j + 0.5) / azimuths);
    eval_acceptance(a, theta, azimuth, value);
    for (std::size_t i = 0; i < value.size(); ++i) {
      value[i] *= std::sin(theta[i]) * step * 2 * pi / azimuths;
      polar[i] += value[i];
      expected.integral_sr += value[i];
    }
    mass.push_back(value);
  }
  // Bins of as much light each over the polar angle, as far as the grid allows.
  std::vector<int> bin;
  double sum = 0;
  for (std::size_t i = 0; i < polar.size(); ++i) {
    const int b =
        std::min(static_cast<int>(sum / expected.integral_sr * polar_bins), polar_bins - 1);
    while (static_cast<int>(expected.edge.size()) <= b)
      expected.edge.push_back(static_cast<double>(i) * step);
    bin.push_back(b);
    sum += polar[i];
  }
  while (expected.edge.size() < polar_bins) expected.edge.push_back(end);
  expected.edge.push_back(4);
  for (int j = 0; j < azimuths; ++j)
    for (std::size_t i = 0; i < polar.size(); ++i)
      for (int k = 0; k < (round ? azimuth_bins : 1); ++k) {
        const int cell = round ? k : j * azimuth_bins / azimuths;
        expected.share[static_cast<std::size_t>(bin[i] * azimuth_bins + cell)] +=
            mass[static_cast<std::size_t>(j)][i] / expected.integral_sr /
            (round ? azimuth_bins : 1);
      }
  return expected;
}

// Chi-square over the value that is exceeded with probability 1e-5 (Wilson and Hilferty 1931).
// Cells that expect fewer than 10 directions are one.
double chi_square_ratio(const std::vector<Vec3>& directions, const Expected& expected) {
  std::vector<double> count(expected.share.size(), 0.0);
  for (const Vec3 d : directions) {
    const double theta = std::atan2(std::hypot(d.x, d.y), d.z);
    double turn = std::atan2(d.y, d.x) / (2 * pi);
    turn -= std::floor(turn);
    const auto above = std::upper_bound(expected.edge.begin() + 1, expected.edge.end() - 1, theta);
    const auto p = above - expected.edge.begin() - 1;
    const int a = std::min(static_cast<int>(turn * azimuth_bins), azimuth_bins - 1);
    ++count[static_cast<std::size_t>(p * azimuth_bins + a)];
  }
  double sum = 0, rest_count = 0, rest = 0, freedom = -1;
  const auto add = [&](double seen, double wanted) {
    sum += (seen - wanted) * (seen - wanted) / wanted;
    ++freedom;
  };
  for (std::size_t i = 0; i < count.size(); ++i) {
    const double wanted = expected.share[i] * static_cast<double>(directions.size());
    if (wanted < 10)
      rest_count += count[i], rest += wanted;
    else
      add(count[i], wanted);
  }
  if (rest > 5) add(rest_count, rest);
  constexpr double z = 4.265;
  return sum / (freedom * std::pow(1 - 2 / (9 * freedom) + z * std::sqrt(2 / (9 * freedom)), 3));
}

TEST(OpticsWarp, FollowsItsSensitivity) {
  for (const auto& [name, a] : acceptances_of_every_kind())
    EXPECT_LT(chi_square_ratio(sample_acceptance(a, samples, 11), integrate(a)), 1) << name;
}

// All warps in one set of tables, as an eye of mixed kernels has them.
TEST(OpticsWarp, RandomDirectionsFollowTheirSensitivity) {
  const std::vector<NamedAcceptance> all = acceptances_of_every_kind();
  for (const bool only_round : {true, false}) {
    std::vector<AcceptanceWarp> warps;
    std::vector<const NamedAcceptance*> of;
    for (const NamedAcceptance& named : all)
      if (!only_round || is_round(named.acceptance)) {
        warps.push_back(make_acceptance_warp(named.acceptance));
        of.push_back(&named);
      }
    const PolarTables tables = make_polar_tables(warps);
    EXPECT_EQ(tables.azimuth.empty(), only_round);
    for (std::size_t w = 0; w < warps.size(); ++w) {
      std::vector<Vec3> directions;
      float off = 0;
      for (std::uint32_t i = 0; i < samples; ++i) {
        const auto d = sample_random_direction<float>(view(tables), static_cast<int>(w),
                                                      mix_bits_32(i / 100 + 77u), i % 100);
        directions.push_back({d.x, d.y, d.z});
        off = std::max(off, std::fabs(d.x * d.x + d.y * d.y + d.z * d.z - 1));
      }
      // Through the half angles, as in render_warp.cpp.
      EXPECT_LT(off, 3e-6f) << of[w]->name;
      EXPECT_LT(chi_square_ratio(directions, integrate(of[w]->acceptance)), 1) << of[w]->name;
    }
  }
}

// Lanes of different warps and the same, one at a time.
TEST(OpticsWarp, LanesAgree) {
  std::vector<AcceptanceWarp> warps;
  for (const NamedAcceptance& named : acceptances_of_every_kind())
    warps.push_back(make_acceptance_warp(named.acceptance));
  const PolarTables tables = make_polar_tables(warps);
  for (int first = 0; first < 1000; ++first) {
    Ints warp{};
    Uints hash{}, index{};
    for (int l = 0; l < lane_width; ++l) {
      warp[l] = (first + l) % static_cast<int>(warps.size());
      hash[l] = mix_bits_32(static_cast<std::uint32_t>(first));
      index[l] = static_cast<std::uint32_t>(l);
    }
    const auto lanes = sample_random_direction<Floats>(view(tables), warp, hash, index);
    for (int l = 0; l < lane_width; ++l) {
      const auto one = sample_random_direction<float>(
          view(tables), static_cast<int>(warp[l]), std::uint32_t{hash[l]}, std::uint32_t{index[l]});
      EXPECT_EQ(one.x, lanes.x[l]);
      EXPECT_EQ(one.y, lanes.y[l]);
      EXPECT_EQ(one.z, lanes.z[l]);
    }
  }
}

// A direction of length 1 has its density; all densities together are 1. The grid's midpoint rule
// leaves 1e-4 where S has edges.
TEST(OpticsWarp, DensitiesIntegrateToOne) {
  for (const auto& [name, a] : acceptances_of_every_kind()) {
    const double theta = 0.3 * acceptance_width_rad(a, 0.7) + 0.02;
    if (!(eval_one(a, theta, 0.7) > 0)) continue;
    EXPECT_NEAR(pdf_one(a, theta, 0.7) * integrate(a).integral_sr / eval_one(a, theta, 0.7), 1,
                3e-4)
        << name;
  }
}

// FollowsItsSensitivity can fail.
TEST(OpticsWarp, WrongSensitivityIsCaught) {
  const std::vector<Vec3> ellipse =
      sample_acceptance(elliptical(5 * degree, 2 * degree, 0.4), samples, 1);
  EXPECT_GT(chi_square_ratio(ellipse, integrate(elliptical(5 * degree, 2.06 * degree, 0.4))), 1);
  EXPECT_GT(chi_square_ratio(ellipse, integrate(elliptical(5 * degree, 2 * degree, 0.43))), 1);
  EXPECT_GT(chi_square_ratio(ellipse, integrate(elliptical(5 * degree, 2 * degree, -0.4))), 1);
  const std::vector<Vec3> lens = sample_acceptance(airy(25, 500), samples, 1);
  EXPECT_GT(chi_square_ratio(lens, integrate(airy(25, 510))), 1);
}

// theta(r) never turns back, and the mixture of two rows, of ellipses, is where the exact inverse
// at that azimuth is. Relative to the major width; the rows are linear between in the width.
TEST(OpticsWarp, RowsOfEllipsesAreThoseOfTheirWidth) {
  for (const auto& [name, a] : acceptances_of_every_kind()) {
    const AcceptanceWarp warp = make_acceptance_warp(a);
    const AcceptanceWarpView v = view(warp);
    const auto knots = static_cast<std::size_t>(v.intervals) + 1;
    for (std::size_t i = 0; i + 1 < warp.rows->theta.size(); ++i)
      if ((i + 1) % knots != 0) {
        ASSERT_LE(warp.rows->theta[i], warp.rows->theta[i + 1]) << name << ", knot " << i;
      }
  }
  const Acceptance ellipse = elliptical(60 * degree, 20 * degree, 0);
  const AcceptanceWarp warp = make_acceptance_warp(ellipse);
  for (int i = 0; i < 360; ++i)
    for (const double r : {0.1, 1.0, 2.0, 3.0}) {
      const double phi = i * degree;
      const Vec3d d = sample_acceptance(view(warp), r * std::cos(phi), r * std::sin(phi));
      const double width = acceptance_width_rad(ellipse, std::atan2(d.y, d.x));
      const AcceptanceWarp round = make_acceptance_warp(round_acceptance(Kernel::gaussian, width));
      EXPECT_NEAR(std::acos(d.z), sample_polar_angle(view(round), r, 0), 1e-4 * width);
    }
}

// Between knots too the distribution over the polar angle is the one of S, as far as a sum in a
// million steps tells: 3e-5 in the mean. At Airy's first dark ring 8e-4 are on its wrong side, and
// where S has a gap half of what is between two knots is in it.
TEST(OpticsWarp, DistributionIsRightBetweenKnots) {
  for (const auto& [name, a] : acceptances_of_every_kind()) {
    if (!is_round(a) || a.kernel == Kernel::pillbox || name == "airy 200 um") continue;
    constexpr int steps = 1 << 20, radii = 4000;
    const AcceptanceWarp warp = make_acceptance_warp(a);
    const double end = last_angle(a);
    std::vector<double> below{0};
    for (int i = 0; i < steps; ++i)
      below.push_back(below.back() +
                      eval_polar_density(view(warp).sensitivity, end * (i + 0.5) / steps, 0));
    double worst = 0, mean = 0;
    for (int i = 0; i < radii; ++i) {
      const double u = (i + 0.5) / radii, r = std::sqrt(-2 * std::log1p(-u));
      const double theta = sample_polar_angle(view(warp), r, 0);
      const auto place = static_cast<std::size_t>(std::min(theta / end, 1.0) * steps);
      const double error = std::fabs(below[place] / below.back() - u);
      worst = std::max(worst, error);
      mean += error / radii;
    }
    EXPECT_LT(worst, name == "profile, ring" ? 2.5e-3 : 1e-3) << name;
    EXPECT_LT(mean, 8e-5) << name;
  }
}

// Rows in floats, with more knots where another warp has more, are the rows in doubles.
TEST(OpticsWarp, RowsInFloatsAreThoseInDoubles) {
  for (const double width : {0.01, 3.0}) {
    const std::vector<AcceptanceWarp> warps = {
        make_acceptance_warp(airy(25, 500)),
        make_acceptance_warp(round_acceptance(Kernel::gaussian, width))};
    const PolarTables tables = make_polar_tables(warps);
    ASSERT_GT(tables.intervals, warps[1].rows->intervals);
    for (std::size_t w = 0; w < 2; ++w)
      for (int i = 1; i < 1300; ++i) {
        const double r = i * 0.005;
        const double exact = sample_polar_angle(view(warps[w]), r, 0);
        const float knot = static_cast<float>(r * tables.intervals / AcceptanceWarpView::r_max);
        EXPECT_NEAR(polar_angle_lanes(tables.polar.data(),
                                      static_cast<int>(w) * 2 * (tables.intervals + 1), knot),
                    exact, 1e-6 * (w == 0 ? 1 : width) * (1 + r))
            << r;
      }
  }
}

}  // namespace
}  // namespace omma::test
