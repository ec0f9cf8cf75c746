// Radiance of the sky and of discs by direction.
#include <gtest/gtest.h>

#include <array>

#include "light_maps.h"
#include "test_scenes.h"

namespace omma {
namespace {

using namespace test;

TEST(Sky, AnglesAreWithinTwoTenMillionths) {
  double worst = 0;
  for (int i = 0; i <= 200000; ++i) {
    const double angle = pi / 2 * i / 200000;
    const auto x = static_cast<float>(std::cos(angle)), y = static_cast<float>(std::sin(angle));
    const double exact = std::atan2(static_cast<double>(y), static_cast<double>(x));
    worst = std::max(worst, std::fabs(static_cast<double>(angle_in_quadrant(x, y)) - exact));
  }
  EXPECT_LT(worst, 2e-7);
  EXPECT_EQ(angle_in_quadrant(1.0f, 0.0f), 0);
  EXPECT_FLOAT_EQ(angle_in_quadrant(0.0f, 1.0f), static_cast<float>(pi / 2));
  EXPECT_EQ(angle_in_quadrant(0.0f, 0.0f), 0);
}

// A map of the direction's own numbers, against their bilinear mixture found in doubles.
TEST(Sky, NodesAreWhereTheySayAndMixedBilinearly) {
  const auto value = [](int half, int row, int column, int channel) {
    return 1 + channel + 0.1 * row + 0.01 * column * column + 3 * half;
  };
  Light light;
  light.bands = narrow_bands(3);
  light.sky = made_sky(12, 7, 1, 3, [&](int half, int row, int column, int, int channel) {
    return value(half, row, column, channel);
  });
  const auto data = light_alone(light);
  Random random{1};
  for (int i = 0; i < 2000; ++i) {
    const double column = random.uniform(0, 12), row = random.uniform(0, 6);
    const int half = random.index(2);
    const Vec3d d = direction_of(2 * pi * column / 12, (half == 0 ? 1 : -1) * pi / 2 * row / 6);
    const int c = static_cast<int>(column), r = std::min(static_cast<int>(row), 5);
    const double fc = column - c, fr = row - r;
    const std::vector<float> found = far_at(*data, to_float(d));
    for (int k = 0; k < 3; ++k) {
      const double expected =
          (value(half, r, c, k) * (1 - fc) + value(half, r, (c + 1) % 12, k) * fc) * (1 - fr) +
          (value(half, r + 1, c, k) * (1 - fc) + value(half, r + 1, (c + 1) % 12, k) * fc) * fr;
      // Near the zenith a column is narrower than what floats resolve of the direction; values
      // differ by 1.4 at most between neighbours.
      const double level = std::hypot(d.x, d.z);
      EXPECT_NEAR(static_cast<double>(found[static_cast<std::size_t>(k)]), expected,
                  1e-5 + 1e-6 / std::max(level, 1e-6));
    }
  }
  // North, east, south, west.
  EXPECT_FLOAT_EQ(far_at(*data, {0, 0, -1})[0], 1.0f);
  EXPECT_NEAR(far_at(*data, {1, 0, 0})[0], 1 + 0.09, 1e-5);
  EXPECT_NEAR(far_at(*data, {0, 0, 1})[0], 1 + 0.36, 1e-5);
  EXPECT_NEAR(far_at(*data, {-1, 0, 0})[0], 1 + 0.81, 1e-5);
}

TEST(Sky, HorizonIsASharpJumpAndPolesAreWhole) {
  Light light;
  light.bands = narrow_bands(1);
  light.sky = made_sky(8, 9, 1, 1, [](int half, int row, int, int, int) {
    return half == 0 ? 2 + row : 100.0 + row;
  });
  const auto data = light_alone(light);
  EXPECT_EQ(far_at(*data, {0.6f, 0, 0.8f})[0], 2);
  EXPECT_NEAR(far_at(*data, {0.6f, 1e-7f, 0.8f})[0], 2, 1e-5);
  EXPECT_NEAR(far_at(*data, {0.6f, -1e-7f, 0.8f})[0], 100, 1e-3);
  EXPECT_EQ(far_at(*data, {0, 1, 0})[0], 10);
  EXPECT_EQ(far_at(*data, {0, -1, 0})[0], 108);
  EXPECT_NEAR(far_at(*data, {1e-7f, 1, -1e-7f})[0], 10, 1e-5);
}

// The frame of omma/light.h.
struct Axes {
  Vec3d up, right;
};
Axes axes_at(double azimuth_rad, double elevation_rad) {
  const Vec3d d = direction_of(azimuth_rad, elevation_rad);
  const Vec3d up = direction_of(azimuth_rad, elevation_rad + pi / 2);
  return {up, cross(d, up)};
}

// Light with its electric vector as near to the world's x as can be, degree 0.5, as I, Q, U.
std::array<double, 3> polarised_along_x(double azimuth_rad, double elevation_rad) {
  const Axes axes = axes_at(azimuth_rad, elevation_rad);
  const double psi = std::atan2(axes.right.x, axes.up.x);
  return {1, 0.5 * std::cos(2 * psi), 0.5 * std::sin(2 * psi)};
}

TEST(Sky, OnePolarisationAboutTheZenithStaysWhole) {
  for (const int half : {0, 1}) {
    Light light;
    light.bands = narrow_bands(2);
    light.sky = made_sky(16, 31, 3, 2, [&](int h, int row, int column, int component, int) {
      SkyMap like;
      like.columns = 16, like.rows = 31;
      return polarised_along_x(azimuth_of_column(like, column),
                               elevation_of_row(like, h, row))[static_cast<std::size_t>(component)];
    });
    const auto data = light_alone(light);
    for (const double from_pole : {1e-4, 0.01, 0.03})
      for (int i = 0; i < 100; ++i) {
        const double azimuth = 2 * pi * (i + 0.37) / 100;
        const double elevation = (half == 0 ? 1 : -1) * (pi / 2 - from_pole);
        const auto exact = polarised_along_x(azimuth, elevation);
        const auto found = far_at(*data, to_float(direction_of(azimuth, elevation)), 3);
        // What is left is that circles of elevation are not straight: 22.5 deg times 1 - sin(e),
        // 2e-4 rad. Mixed without turning, half way between columns 7.6 % would be lost.
        for (std::size_t s = 0; s < 3; ++s)
          EXPECT_NEAR(static_cast<double>(found[2 * s]), exact[s], 1e-3)
              << from_pole << " " << azimuth;
      }
  }
}

TEST(Sky, PolarisationIsZeroWhereTheMapHasNone) {
  Light light;
  light.bands = narrow_bands(2);
  light.sky = made_sky(4, 2, 1, 2, [](int, int, int, int, int) { return 3; });
  EXPECT_EQ(far_at(*light_alone(light), {0, 0.6f, 0.8f}, 3),
            (std::vector<float>{3, 3, 0, 0, 0, 0}));
  light.sky = nullptr;
  EXPECT_EQ(far_at(*light_alone(light), {0, 0.6f, 0.8f}, 3), std::vector<float>(6, 0.0f));
}

TEST(Sky, ChannelsBecomeBandsByTheMatrix) {
  Light light;
  light.bands = narrow_bands(2);
  auto sky =
      std::make_shared<SkyMap>(*made_sky(4, 2, 3, 3, [](int, int, int, int component, int channel) {
        return component == 0 ? 4 + channel : component == 1 ? 1 + channel : 0;
      }));
  sky->band_from_channel = {1, 0, 2, 0, 0.5, 0};
  light.sky = sky;
  const std::vector<float> found = far_at(*light_alone(light), {0, 0, -1}, 3);
  EXPECT_EQ(found, (std::vector<float>{16, 2.5f, 7, 1, 0, 0}));
}

// CIE overcast sky: 7 pi / 9 of the zenith's radiance on the horizontal.
TEST(Sky, OvercastLightsTheGroundAsItShould) {
  Light light;
  light.bands = narrow_bands(1);
  light.sky = made_sky(4, 1025, 1, 1, [](int half, int row, int, int, int) {
    return half == 1 ? 0 : (1 + 2 * std::sin(pi / 2 * row / 1024)) / 3;
  });
  const auto data = light_alone(light);
  double horizontal = 0;
  constexpr int steps = 20000;
  for (int i = 0; i < steps; ++i) {
    const double e = (i + 0.5) / steps * pi / 2;
    horizontal += static_cast<double>(far_at(*data, to_float(direction_of(0.3, e)))[0]) *
                  std::sin(e) * std::cos(e) * (pi / 2 / steps) * 2 * pi;
  }
  EXPECT_NEAR(horizontal / (7 * pi / 9), 1, 1e-5);
}

TEST(Disc, HasAnEdgeAndItsMeanRadiance) {
  for (const double radius : {0.00465, 0.03, 0.09}) {
    Light light;
    light.bands = narrow_bands(3);
    Disc disc;
    disc.direction = to_float(normalize(Vec3d{0.3, 0.5, -0.8}));
    disc.angular_radius_rad = radius;
    disc.radiance = {100, 200, 300};
    disc.limb_darkening = {0, 0.5, 1};
    light.discs = {disc};
    const auto data = light_alone(light);
    const Vec3d axis = normalize(to_double(disc.direction));
    // The mean over the disc, by rings: the limb is 0.6 % of a ring's width off by floats.
    std::array<double, 3> mean{};
    double all = 0;
    constexpr int rings = 20000;
    for (int i = 0; i < rings; ++i) {
      const double theta = radius * (i + 0.5) / rings;
      const double weight = std::sin(theta);
      all += weight;
      const auto found = far_at(*data, to_float(direction_about(axis, theta, 2.4 * i)));
      for (std::size_t b = 0; b < 3; ++b) mean[b] += weight * static_cast<double>(found[b]);
    }
    for (std::size_t b = 0; b < 3; ++b)
      EXPECT_NEAR(mean[b] / all / disc.radiance[b], 1, 2e-4) << radius << " " << b;
    const auto at = [&](double part) {
      return far_at(*data, to_float(direction_about(axis, radius * part, 1.0)))[0];
    };
    EXPECT_FLOAT_EQ(at(0.999), 100);
    EXPECT_EQ(at(1.001), 0);
    EXPECT_EQ(far_at(*data, to_float(axis * -1.0))[0], 0);
  }
}

}  // namespace
}  // namespace omma
