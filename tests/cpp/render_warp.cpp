// Chi-square tests of sample directions against the density of their kernel, integrated here on its
// own in double precision. Each test takes one direction per scramble: those are independent, while
// the points of one low-discrepancy set are more even than chance and would hide an error.
#include <gtest/gtest.h>

#include <algorithm>

#include "physics/sampling/low_discrepancy.h"
#include "physics/sampling/random_direction.h"
#include "reference.h"
#include "sampling/directions.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

constexpr Kernel kernels[] = {Kernel::gaussian, Kernel::pillbox, Kernel::compoundray};
constexpr double angles_deg[] = {0.3, 2.6, 30, 120, 240, 359.99};
constexpr int theta_bins = 32, phi_bins = 8;

struct Polar {
  double theta_rad = 0, phi_rad = 0;
};

// Distribution function of the polar angle: the midpoint rule over S(theta) sin(theta).
struct PolarDistribution {
  double last_rad = 0;
  std::vector<double> cumulative{0};

  double at(double theta_rad) const {
    const auto steps = static_cast<double>(cumulative.size() - 1);
    const double x = std::clamp(theta_rad / last_rad * steps, 0.0, steps);
    const auto i = std::min(static_cast<std::size_t>(x), cumulative.size() - 2);
    const double share = x - static_cast<double>(i);
    return (cumulative[i] * (1 - share) + cumulative[i + 1] * share) / cumulative.back();
  }
};

PolarDistribution integrate(Kernel kernel, double acceptance_rad) {
  constexpr int steps = 1 << 16;
  PolarDistribution result;
  result.last_rad = std::min(pi, 4 * acceptance_rad);  // a Gaussian has 2^-64 of its peak there
  for (int i = 0; i < steps; ++i) {
    const double theta = result.last_rad * (i + 0.5) / steps;
    result.cumulative.push_back(result.cumulative.back() +
                                sensitivity(kernel, theta, acceptance_rad) * std::sin(theta));
  }
  return result;
}

double chi_square(const std::vector<Polar>& sample, const PolarDistribution& distribution) {
  std::vector<int> count(theta_bins * phi_bins);
  for (const Polar& p : sample) {
    const int t =
        std::min(static_cast<int>(distribution.at(p.theta_rad) * theta_bins), theta_bins - 1);
    const int f = std::min(static_cast<int>((p.phi_rad / (2 * pi) + 0.5) * phi_bins), phi_bins - 1);
    ++count[static_cast<std::size_t>(t * phi_bins + f)];
  }
  const double expected = static_cast<double>(sample.size()) / (theta_bins * phi_bins);
  double sum = 0;
  for (const int n : count) sum += (n - expected) * (n - expected) / expected;
  return sum;
}

// Exceeded with probability 1e-5 (one side): Wilson and Hilferty 1931. The seeds are fixed, so a
// test that passes once passes always; with 54 of them a right warp fails with 0.05 %.
double critical_chi_square() {
  constexpr double k = theta_bins * phi_bins - 1, z = 4.265;
  return k * std::pow(1 - 2 / (9 * k) + z * std::sqrt(2 / (9 * k)), 3);
}

Polar polar(double x, double y, double z) {
  return {std::atan2(std::hypot(x, y), z), std::atan2(y, x)};
}

RenderSettings settings_for(Kernel kernel, Points points, std::uint64_t seed) {
  return {.sampling = Fixed{1}, .seed = seed, .kernel = kernel, .points = points};
}

// One direction out of each tabulated pattern, over many seeds.
std::vector<Polar> from_tables(Kernel kernel, double acceptance_rad) {
  constexpr int samples = 16;
  Random random{7};
  std::vector<Polar> result;
  const Eye eye = make_eye(Vec3d{0, 0, -1}, acceptance_rad);
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const DirectionTables tables =
        make_direction_tables(eye, settings_for(kernel, Points::low_discrepancy, seed), samples);
    EXPECT_GE(tables.patterns, 64) << "too few patterns for this test to mean anything";
    for (int k = 0; k < tables.patterns; ++k) {
      const float* p = tables.local.data() + 3 * samples * k + random.index(samples);
      result.push_back(polar(p[0], p[samples], p[2 * samples]));
    }
  }
  return result;
}

Polar random_polar(const DirectionTables& tables, std::uint64_t hash, std::uint32_t index) {
  const LocalDirection<float> d = sample_random_direction<float>(
      view(tables.polar), 0, static_cast<std::uint32_t>(hash), index);
  // Through the half angle the length is off by up to four times what its sine and cosine are, and
  // that for the azimuth too; those are off by a few 6e-8.
  EXPECT_NEAR(d.x * d.x + d.y * d.y + d.z * d.z, 1, 3e-6);
  return polar(d.x, d.y, d.z);
}

// One direction out of each scramble that is made where it is needed, without a table.
std::vector<Polar> on_the_fly(Kernel kernel, Points points, double acceptance_rad) {
  constexpr int samples = 16;
  Random random{8};
  std::vector<Polar> result;
  const DirectionTables tables = make_direction_tables(make_eye(Vec3d{0, 0, -1}, acceptance_rad),
                                                       settings_for(kernel, points, 1), samples);
  for (int i = 0; i < 40000; ++i) {
    const std::uint64_t hash = random.next();
    const int index = random.index(samples);
    if (points == Points::random) {
      result.push_back(random_polar(tables, hash, static_cast<std::uint32_t>(index)));
      continue;
    }
    const Vec3 d = low_discrepancy_direction(tables.warp_views[0],
                                             static_cast<std::uint32_t>(hash), index);
    result.push_back(polar(d.x, d.y, d.z));
  }
  return result;
}

TEST(Warp, FollowsItsDensity) {
  for (const Kernel kernel : kernels)
    for (const double angle_deg : angles_deg) {
      const double angle = angle_deg * degree;
      const PolarDistribution distribution = integrate(kernel, angle);
      const auto place = name_of(kernel) + ' ' + std::to_string(angle_deg) + " degrees";
      EXPECT_LT(chi_square(from_tables(kernel, angle), distribution), critical_chi_square())
          << place << ", low discrepancy from tables";
      EXPECT_LT(chi_square(on_the_fly(kernel, Points::low_discrepancy, angle), distribution),
                critical_chi_square())
          << place << ", low discrepancy on the fly";
      EXPECT_LT(chi_square(on_the_fly(kernel, Points::random, angle), distribution),
                critical_chi_square())
          << place << ", random";
    }
}

// Random directions follow one another within an estimate, and estimates have neighbouring hashes:
// a million of them at once, in the order in which a render takes them.
TEST(Warp, ConsecutiveRandomDirectionsFollowTheDensity) {
  for (const Kernel kernel : kernels) {
    const double angle = 20 * degree;
    const DirectionTables tables = make_direction_tables(
        make_eye(Vec3d{0, 0, -1}, angle), settings_for(kernel, Points::random, 1), 1);
    std::vector<Polar> sample;
    for (std::uint64_t estimate = 0; estimate < 1000; ++estimate)
      for (std::uint32_t index = 0; index < 1000; ++index)
        sample.push_back(random_polar(tables, hash_combine(5, estimate), index));
    EXPECT_LT(chi_square(sample, integrate(kernel, angle)), critical_chi_square())
        << name_of(kernel);
  }
}

// Neighbours in the order of samples, and the same samples of neighbouring estimates, are
// independent: the correlation of a million pairs is normal with a deviation of 1e-3, and seven
// numbers stay within 4 of it but for 0.05 %.
TEST(Warp, NeighbouringRandomDirectionsAreIndependent) {
  const DirectionTables tables = make_direction_tables(
      make_eye(Vec3d{0, 0, -1}, 20 * degree), settings_for(Kernel::gaussian, Points::random, 1), 1);
  constexpr std::uint32_t n = 1000;
  const auto numbers = [&](std::uint64_t estimate, std::uint32_t index) {
    const Polar p = random_polar(tables, hash_combine(5, estimate), index);
    return std::array{p.theta_rad, std::sin(p.phi_rad), std::cos(p.phi_rad)};
  };
  const auto correlation = [&](std::size_t a, std::size_t b, std::uint64_t estimates,
                               std::uint32_t indices) {
    double sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
    for (std::uint64_t estimate = 0; estimate < n; ++estimate)
      for (std::uint32_t index = 0; index < n; ++index) {
        const double x = numbers(estimate, index)[a];
        const double y = numbers(estimate + estimates, index + indices)[b];
        sum_a += x, sum_b += y, aa += x * x, bb += y * y, ab += x * y;
      }
    const double count = 1.0 * n * n;
    return (ab / count - sum_a * sum_b / count / count) /
           std::sqrt((aa / count - sum_a * sum_a / count / count) *
                     (bb / count - sum_b * sum_b / count / count));
  };
  EXPECT_LT(std::fabs(correlation(0, 0, 0, 1)), 4e-3) << "polar angles of neighbouring samples";
  EXPECT_LT(std::fabs(correlation(1, 1, 0, 1)), 4e-3) << "azimuths of neighbouring samples";
  EXPECT_LT(std::fabs(correlation(2, 2, 0, 1)), 4e-3) << "azimuths of neighbouring samples";
  EXPECT_LT(std::fabs(correlation(0, 0, 1, 0)), 4e-3) << "polar angles of neighbouring estimates";
  EXPECT_LT(std::fabs(correlation(1, 1, 1, 0)), 4e-3) << "azimuths of neighbouring estimates";
  EXPECT_LT(std::fabs(correlation(0, 1, 0, 0)), 4e-3) << "polar angle and azimuth";
  EXPECT_LT(std::fabs(correlation(0, 2, 0, 0)), 4e-3) << "polar angle and azimuth";
}

// The functions behind random directions, against the standard library's in doubles.
TEST(Warp, LogarithmAndSineOfLanes) {
  for (int i = -2000; i <= 2000; ++i) {
    const float x = std::exp2(static_cast<float>(i) * 0.05f * 0.33f);
    const double exact = std::log(static_cast<double>(x));
    // Two roundings of a sum of two terms, the larger at most 0.7 + |exact|.
    EXPECT_NEAR(log_lanes(x), exact, 2e-7 * (0.7 + std::fabs(exact))) << x;
    const float angle = static_cast<float>(i / 2000.0 * pi);
    EXPECT_NEAR(sine_cosine(angle).sine, std::sin(static_cast<double>(angle)), 4e-7) << angle;
    EXPECT_NEAR(sine_cosine(angle).cosine, std::cos(static_cast<double>(angle)), 4e-7) << angle;
  }
}

// FollowsItsDensity can fail: an acceptance angle 5 % off does not pass it.
TEST(Warp, WrongDensityIsCaught) {
  const double angle = 30 * degree;
  const std::vector<Polar> sample = on_the_fly(Kernel::gaussian, Points::random, angle);
  EXPECT_GT(chi_square(sample, integrate(Kernel::gaussian, angle * 1.05)), critical_chi_square());
  EXPECT_GT(chi_square(sample, integrate(Kernel::pillbox, angle)), critical_chi_square());
}

TEST(Warp, TailsReachWhereTheDensityDoes) {
  // A pillbox ends at its edge. Of a Gaussian the farthest of n directions leaves a rest of about
  // 1/n beyond it; n times the rest is distributed exponentially: within 1e-3 and 10 but for 0.1 %.
  const double angle = 10 * degree;
  const auto farthest = [&](Kernel kernel) {
    double theta = 0;
    for (const Polar& p : on_the_fly(kernel, Points::random, angle))
      theta = std::max(theta, p.theta_rad);
    return theta;
  };
  EXPECT_LE(farthest(Kernel::pillbox), angle / 2 * (1 + 1e-6));
  EXPECT_GT(farthest(Kernel::pillbox), angle / 2 * 0.999);
  const double rest =
      40000 * (1 - integrate(Kernel::gaussian, angle).at(farthest(Kernel::gaussian)));
  EXPECT_GT(rest, 1e-3);
  EXPECT_LT(rest, 10);
}

// --- From outside: what a renderer really looks at. The faces of a cube carry their position as
// colour, so a response of one sample tells its direction.
std::vector<Polar> looked_at(const RenderSettings& settings, double acceptance_rad, Vec3d axis,
                             std::size_t count) {
  Scene scene;
  Material plain;
  add_material(scene, plain);
  Mesh cube = cube_seen_from_inside(1, 0);
  for (const Vec3 p : cube.positions)
    cube.colors.push_back({(p.x + 1) / 2, (p.y + 1) / 2, (p.z + 1) / 2, 1});
  add_instance(scene, add_mesh(scene, cube));
  const Result result = render(scene, make_eye(axis, acceptance_rad, count), settings);
  const auto [u, v] = tangents(axis);
  std::vector<Polar> seen;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d d{2 * result.at(i, 0) - 1, 2 * result.at(i, 1) - 1, 2 * result.at(i, 2) - 1};
    seen.push_back(polar(dot(d, u), dot(d, v), dot(d, axis)));
  }
  return seen;
}

TEST(Warp, RendererLooksWhereItShould) {
  for (const Kernel kernel : kernels)
    for (const double angle_deg : {2.6, 60.0}) {
      const double angle = angle_deg * degree;
      const std::vector<Polar> seen = looked_at(settings_for(kernel, Points::random, 3), angle,
                                                normalize(Vec3d{-0.4, 0.7, 0.5}), 40000);
      EXPECT_LT(chi_square(seen, integrate(kernel, angle)), critical_chi_square())
          << name_of(kernel) << ' ' << angle_deg << " degrees";
    }
}

// Tabulated patterns are drawn with replacement: at 1,024 of them and 64 ommatidia per seed that
// adds 6 % to chi-square in theta, a fraction of that in the joint bins.
TEST(Warp, TabulatedPatternsAreTurnedEvenly) {
  std::vector<Polar> seen;
  const double angle = 20 * degree;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto some = looked_at(settings_for(Kernel::gaussian, Points::low_discrepancy, seed),
                                angle, normalize(Vec3d{-0.4, -0.7, 0.5}), 64);
    seen.insert(seen.end(), some.begin(), some.end());
  }
  EXPECT_LT(chi_square(seen, integrate(Kernel::gaussian, angle)), critical_chi_square());
}

TEST(Warp, NoAcceptanceAngleLooksAlongTheAxis) {
  const Vec3d axis = normalize(Vec3d{-0.4, -0.7, 0.5});
  for (const Kernel kernel : kernels)
    for (const Points points : {Points::low_discrepancy, Points::random})
      for (const Polar& p : looked_at(settings_for(kernel, points, 0), 0, axis, 100))
        EXPECT_LT(p.theta_rad, 1e-6);
}

}  // namespace
}  // namespace omma::test
