// The table of how much a rough boundary reflects, against integrals done here in other variables.
#include "physics/surface/specular_albedo.h"

#include <gtest/gtest.h>

#include <limits>

#include "backend/albedo_tables.h"
#include "physics/surface/fresnel.h"
#include "scatter_checks.h"

namespace omma::test {
namespace {

// Over all microfacets by the slope and azimuth of their normals, with Walter's D, Smith's G2 and
// Fresnel's laws of sines and tangents.
double integrate_albedo(double ior, double alpha, double cos_o) {
  constexpr int radii = 600, azimuths = 300;
  const double sin_o = std::sqrt(1 - cos_o * cos_o);
  const auto lambda = [&](double c) {
    return 0.5 * (std::sqrt(1 + alpha * alpha * (1 - c * c) / (c * c)) - 1);
  };
  double sum = 0;
  for (int i = 0; i < radii; ++i)
    for (int j = 0; j < azimuths; ++j) {
      const double t = (i + 0.5) / radii, slope = alpha * t / (1 - t);
      const double phi = pi * (j + 0.5) / azimuths;
      const double hz = 1 / std::sqrt(1 + slope * slope), hx = slope * hz * std::cos(phi);
      const double along = sin_o * hx + cos_o * hz, cos_w = 2 * along * hz - cos_o;
      if (along <= 0 || cos_w <= 0) continue;
      const double d =
          std::pow(alpha / (alpha * alpha + slope * slope), 2) / (pi * std::pow(hz, 4));
      const double g = 1 / (1 + lambda(cos_o) + lambda(cos_w));
      const double a = std::acos(std::min(along, 1.0)), b = std::asin(std::sin(a) / ior);
      const double s = a < 1e-6 ? (ior - 1) / (ior + 1) : std::sin(a - b) / std::sin(a + b);
      const double p = a < 1e-6 ? s : std::tan(a - b) / std::tan(a + b);
      // d G F / (4 cos_o cos_w) cos_w dw, dw = 4 along dh, dh = hz^3 slope dslope dphi; both
      // halves.
      sum += 0.5 * (s * s + p * p) * d * g / cos_o * along * hz * hz * hz * slope * alpha /
             std::pow(1 - t, 2) / radii * (2 * pi / azimuths);
    }
  return sum;
}

TEST(PhysicsSpecularAlbedo, QuadratureIsRight) {
  for (const double ior : {1.05, 1.5, 2.5})
    for (const double roughness : {0.1, 0.4, 1.0})
      for (const double cosine : {0.01, 0.1, 0.5, 1.0})
        // 2e-4 as stated; the sum here has a third of it.
        EXPECT_NEAR(specular_albedo(ior, roughness, cosine).all,
                    integrate_albedo(ior, roughness * roughness, cosine), 2.5e-4)
            << ior << ' ' << roughness << ' ' << cosine;
}

// The error that energy is kept within: where E is largest at grazing angles and for smooth
// surfaces too.
TEST(PhysicsSpecularAlbedo, TableIsWithinAThousandth) {
  for (const double ior : {1.0, 1.05, 1.33, 1.5, 2.0, 3.0}) {
    const std::vector<float> table = make_specular_albedo(ior);
    ASSERT_EQ(table.size(), static_cast<std::size_t>(albedo_floats));
    for (std::uint32_t i = 0; i < 4000; ++i) {
      const Vec2 u = square_point(i);
      // Every other among the smooth and grazing.
      const float roughness = i % 2 == 0 ? u.x : u.x * u.x * u.x;
      const float cosine = i % 4 < 2 ? u.y : u.y * u.y * u.y + 1e-5f;
      const AlbedoRow<float> row = find_albedo_row(roughness, 0);
      const Albedo right =
          specular_albedo(ior, static_cast<double>(roughness), static_cast<double>(cosine));
      EXPECT_NEAR(eval_albedo(table.data(), row, cosine), right.all, ior <= 2 ? 1e-3 : 1.4e-3)
          << ior << ' ' << roughness << ' ' << cosine;
      EXPECT_NEAR(eval_albedo(table.data(), row, cosine, first_polarized_albedo), right.polarized,
                  ior <= 2 ? 1e-3 : 1.4e-3)
          << ior << ' ' << roughness << ' ' << cosine;
    }
  }
}

// Of a white metal, whose albedo is that of the facets' hiding alone.
TEST(PhysicsSpecularAlbedo, TableOfWhiteMetal) {
  const double white = std::numeric_limits<double>::infinity();
  const std::vector<float> table = make_specular_albedo(white);
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const Vec2 u = square_point(i);
    const float roughness = i % 2 == 0 ? u.x : u.x * u.x * u.x;
    const float cosine = i % 4 < 2 ? u.y : u.y * u.y * u.y + 1e-5f;
    EXPECT_NEAR(eval_albedo(table.data(), find_albedo_row(roughness, 0), cosine),
                specular_albedo(white, static_cast<double>(roughness), static_cast<double>(cosine)).all,
                4e-3)
        << roughness << ' ' << cosine;
  }
}

// The mean is that of what is looked up, so that the base keeps its energy: at rows exactly;
// between them the cosines of nodes move, which makes up to 2e-4.
TEST(PhysicsSpecularAlbedo, MeanIsThatOfTheTable) {
  for (const double ior : {1.05, 1.5, 3.0}) {
    const std::vector<float> table = make_specular_albedo(ior);
    for (int r = 0; r <= 300; ++r) {
      const AlbedoRow<float> row = find_albedo_row(static_cast<float>(r) / 300.0f, 0);
      constexpr int steps = 2000;
      double mean = 0;
      for (int i = 0; i < steps; ++i) {
        const double c = std::pow((i + 0.5) / steps, 2), dc = 2 * (i + 0.5) / steps / steps;
        mean +=
            2 * static_cast<double>(eval_albedo(table.data(), row, static_cast<float>(c))) * c * dc;
      }
      EXPECT_NEAR(eval_mean_albedo(table.data(), row), mean, 2e-4) << ior << ' ' << r;
    }
  }
}

TEST(PhysicsSpecularAlbedo, SmoothIsFresnelAndIorOneIsNothing) {
  const std::vector<float> glass = make_specular_albedo(1.5), none = make_specular_albedo(1);
  const AlbedoRow<float> smooth = find_albedo_row(0.0f, 0);
  for (int i = 1; i <= 50; ++i) {
    const float cosine = 0.02f * static_cast<float>(i);
    // Tails of the lobe of what counts as a mirror, and the table's error.
    const Mueller<float> mirror = mueller_of(fresnel_dielectric(cosine, 1.5f));
    EXPECT_NEAR(eval_albedo(glass.data(), smooth, cosine), mirror.a, 2e-3) << cosine;
    EXPECT_NEAR(eval_albedo(glass.data(), smooth, cosine, first_polarized_albedo), mirror.b, 2e-3)
        << cosine;
  }
  for (const float x : none) EXPECT_EQ(x, 0);
}

TEST(PhysicsSpecularAlbedo, EndsAreInside) {
  const std::vector<float> table = make_specular_albedo(1.5);
  for (const float roughness : {-1.0f, 0.0f, 0.0224f, 0.0226f, 1.0f})
    for (const float cosine : {0.0f, 1e-9f, 1.0f}) {
      const float e = eval_albedo(table.data(), find_albedo_row(roughness, 0), cosine);
      EXPECT_GT(e, 0) << roughness << ' ' << cosine;
      EXPECT_LE(e, 1) << roughness << ' ' << cosine;
    }
}

// Lanes of different tables and the same, one at a time.
TEST(PhysicsSpecularAlbedo, LanesAgree) {
  std::vector<float> tables = make_specular_albedo(1.33);
  const std::vector<float> other = make_specular_albedo(2);
  tables.insert(tables.end(), other.begin(), other.end());
  for (std::uint32_t first = 0; first < 100; ++first) {
    Floats roughness{}, cosine{};
    Ints table{};
    for (int l = 0; l < lane_width; ++l) {
      const Vec2 u = square_point(first * 16 + static_cast<std::uint32_t>(l));
      roughness[l] = u.x;
      cosine[l] = u.y;
      table[l] = l % 2;
    }
    const AlbedoRow<Floats> row = find_albedo_row(roughness, table);
    const Floats e = eval_albedo(tables.data(), row, cosine);
    const Floats mean = eval_mean_albedo(tables.data(), row);
    for (int l = 0; l < lane_width; ++l) {
      const AlbedoRow<float> one = find_albedo_row(float{roughness[l]}, 0);
      const float* own = l % 2 == 0 ? tables.data() : other.data();
      EXPECT_EQ(eval_albedo(own, one, float{cosine[l]}), e[l]);
      EXPECT_EQ(eval_mean_albedo(own, one), mean[l]);
    }
  }
}

}  // namespace
}  // namespace omma::test
