// Samplers against their densities, integrated here on their own.
#include "physics/surface/microfacet.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <tuple>

#include "scatter_checks.h"

namespace omma::test {
namespace {

constexpr int radius_bins = 20, azimuth_bins = 12, samples = 100000;

LocalDirection<float> viewer(double cosine, double azimuth) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {static_cast<float>(sine * std::cos(azimuth)),
          static_cast<float>(sine * std::sin(azimuth)), static_cast<float>(cosine)};
}

// Which cell a half vector lies in: by t = r^2 / (1 + r^2), r its slope over alpha, and its
// azimuth.
int cell_of(double x, double y, double z, double alpha) {
  const double r = std::hypot(x, y) / (z * alpha), t = r / (1 + r);
  const double turn = std::atan2(y, x) / (2 * pi);
  const int a =
      std::min(static_cast<int>((turn - std::floor(turn)) * azimuth_bins), azimuth_bins - 1);
  return std::min(static_cast<int>(t * radius_bins), radius_bins - 1) * azimuth_bins + a;
}

// Integrals of the density of mirrored directions over cells of half vectors, and over those that
// lie above the horizon: the midpoint rule, with dw = 4 (o.h) dh and dh = h_z^3 alpha^2 r dr dphi.
struct Expected {
  std::vector<double> share = std::vector<double>(radius_bins * azimuth_bins, 0.0);
  double sum = 0, above = 0;
};

Expected integrate(const LocalDirection<float>& o, float alpha) {
  constexpr int radii = radius_bins * 40, azimuths = azimuth_bins * 40;
  const float root_o = smith_root(o.z, alpha);
  Expected expected;
  for (int i = 0; i < radii; ++i)
    for (int j = 0; j < azimuths; ++j) {
      const double t = (i + 0.5) / radii, r = t / (1 - t) * static_cast<double>(alpha);
      const double phi = 2 * pi * (j + 0.5) / azimuths;
      const double z = 1 / std::sqrt(1 + r * r), x = r * z * std::cos(phi),
                   y = r * z * std::sin(phi);
      const double along = o.x * x + o.y * y + o.z * z;
      if (along <= 0) continue;
      const LocalDirection<float> w{static_cast<float>(2 * along * x - o.x),
                                    static_cast<float>(2 * along * y - o.y),
                                    static_cast<float>(2 * along * z - o.z)};
      const double density = microfacet_pdf(half_vector(o, w, alpha).density, o.z, root_o);
      const double alpha2 = static_cast<double>(alpha) * static_cast<double>(alpha);
      const double mass = density * 4 * along * z * z * z * alpha2 * t / std::pow(1 - t, 3) /
                          radii * (2 * pi / azimuths);
      expected.share[static_cast<std::size_t>(cell_of(x, y, z, alpha))] += mass;
      expected.sum += mass;
      if (w.z > 0) expected.above += mass;
    }
  return expected;
}

TEST(PhysicsMicrofacet, MirroredDirectionsFollowTheirDensity) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0, 1);
  for (const float roughness : {0.0f, 0.1f, 0.3f, 0.6f, 1.0f})
    for (const double cosine : {1.0, 0.7, 0.3, 0.05, 0.005}) {
      SCOPED_TRACE("roughness " + std::to_string(roughness) + ", cosine " + std::to_string(cosine));
      const float alpha = microfacet_alpha(roughness);
      const LocalDirection<float> o = viewer(cosine, 0.4);
      Expected expected = integrate(o, alpha);
      // The rule's error, where grazing views cut through its cells.
      EXPECT_NEAR(expected.sum, 1, 2e-3);
      EXPECT_LE(expected.above, 1 + 2e-3);
      std::vector<double> count(expected.share.size(), 0.0);
      int above = 0;
      for (int i = 0; i < samples; ++i) {
        const float u0 = unit(random), u1 = unit(random);
        const auto w = sample_microfacet(o, alpha, u0, u1);
        ASSERT_NEAR(std::hypot(w.x, w.y, w.z), 1, 2e-6);
        ++count[static_cast<std::size_t>(cell_of(o.x + w.x, o.y + w.y, o.z + w.z, alpha))];
        above += w.z > 0;
      }
      for (double& x : expected.share) x *= samples / expected.sum;
      EXPECT_LT(chi_square_ratio(count, expected.share), 1);
      // 4.4 standard deviations, exceeded once in 1e5, and the rule's error.
      const double share = expected.above / expected.sum;
      EXPECT_NEAR(
          above, samples * share,
          4.4 * std::sqrt(samples * share * (1 - std::min(share, 1.0)) + 1) + samples * 1e-3);
    }
}

// The test above can fail: a lobe wider by a twenty-fifth is found.
TEST(PhysicsMicrofacet, WrongDensityIsCaught) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(0, 1);
  const float alpha = microfacet_alpha(0.3f);
  const LocalDirection<float> o = viewer(0.3, 0.4);
  std::vector<double> count(radius_bins * azimuth_bins, 0.0);
  for (int i = 0; i < samples; ++i) {
    const float u0 = unit(random), u1 = unit(random);
    const auto w = sample_microfacet(o, alpha * 1.04f, u0, u1);
    ++count[static_cast<std::size_t>(cell_of(o.x + w.x, o.y + w.y, o.z + w.z, alpha))];
  }
  Expected expected = integrate(o, alpha);
  for (double& x : expected.share) x *= samples / expected.sum;
  EXPECT_GT(chi_square_ratio(count, expected.share), 1);
}

TEST(PhysicsMicrofacet, IsReciprocal) {
  for (const float roughness : {0.0f, 0.2f, 1.0f})
    for (std::uint32_t i = 0; i < 200; ++i) {
      const Vec2 u = square_point(i), v = square_point(i + 1000);
      const float alpha = microfacet_alpha(roughness);
      const auto o = sample_cosine(u.x, u.y), w = sample_cosine(v.x, v.y);
      const auto eval = [&](const auto& to, const auto& from) {
        return eval_microfacet(half_vector(to, from, alpha).density, to.z, smith_root(to.z, alpha),
                               from.z, alpha) /
               from.z;
      };
      EXPECT_NEAR(eval(o, w) / eval(w, o), 1, 1e-5);
    }
}

// Of what is mirrored, G2 / G1 at most counts.
TEST(PhysicsMicrofacet, NeverWeighsMoreThanOne) {
  for (const float roughness : {0.0f, 0.2f, 0.5f, 1.0f})
    for (const double cosine : {1.0, 0.5, 0.1, 0.001})
      for (std::uint32_t i = 0; i < 1000; ++i) {
        const float alpha = microfacet_alpha(roughness);
        const auto o = viewer(cosine, 0);
        const Vec2 u = square_point(i);
        const auto w = sample_microfacet(o, alpha, u.x, u.y);
        if (w.z <= 0) continue;
        const float root = smith_root(o.z, alpha), d = half_vector(o, w, alpha).density;
        const float weight =
            eval_microfacet(d, o.z, root, w.z, alpha) / microfacet_pdf(d, o.z, root);
        ASSERT_TRUE(std::isfinite(weight)) << roughness << ' ' << cosine;
        ASSERT_LE(weight, 1 + 1e-6f);
      }
}

TEST(PhysicsDiffuse, FollowsTheCosine) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0, 1);
  constexpr int bins = 16;
  std::vector<double> count(bins * bins, 0.0);
  for (int i = 0; i < samples; ++i) {
    const float u0 = unit(random), u1 = unit(random);
    const auto w = sample_cosine(u0, u1);
    ASSERT_NEAR(std::hypot(w.x, w.y, w.z), 1, 2e-6);
    const double turn = std::atan2(w.y, w.x) / (2 * pi) + 0.5;
    // As much in each cell of z^2: 2 cos sin dtheta = d(z^2).
    const int p = std::min(static_cast<int>(w.z * w.z * bins), bins - 1);
    ++count[static_cast<std::size_t>(p * bins + std::min(static_cast<int>(turn * bins), bins - 1))];
  }
  EXPECT_LT(chi_square_ratio(count, std::vector<double>(bins * bins, 1.0 * samples / bins / bins)),
            1);
  EXPECT_FLOAT_EQ(cosine_pdf(0.5f), static_cast<float>(0.5 / pi));
  EXPECT_EQ(cosine_pdf(-0.5f), 0);
}

TEST(PhysicsMicrofacet, LanesAgree) {
  for (std::uint32_t first = 0; first < 100; ++first) {
    LocalDirection<Floats> o{};
    Floats alpha{}, u0{}, u1{};
    const auto put = [](LocalDirection<Floats>& all, int l, const LocalDirection<float>& d) {
      all.x[l] = d.x;
      all.y[l] = d.y;
      all.z[l] = d.z;
    };
    for (int l = 0; l < lane_width; ++l) {
      const Vec2 u = square_point(first * 16 + static_cast<std::uint32_t>(l));
      put(o, l, viewer(0.01 + 0.98 * static_cast<double>(u.x), 1));
      alpha[l] = microfacet_alpha(u.y);
      u0[l] = u.y;
      u1[l] = u.x;
    }
    const auto lanes = sample_microfacet(o, alpha, u0, u1);
    const auto half = half_vector(o, lanes, alpha);
    for (int l = 0; l < lane_width; ++l) {
      const LocalDirection<float> one_o{o.x[l], o.y[l], o.z[l]};
      const auto one = sample_microfacet(one_o, float{alpha[l]}, float{u0[l]}, float{u1[l]});
      EXPECT_EQ(one.x, lanes.x[l]);
      EXPECT_EQ(one.y, lanes.y[l]);
      EXPECT_EQ(one.z, lanes.z[l]);
      EXPECT_EQ(half_vector(one_o, one, float{alpha[l]}).density, half.density[l]);
    }
  }
}

}  // namespace
}  // namespace omma::test
