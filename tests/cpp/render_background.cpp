// What a ray sees that meets no surface: each background at directions with known values.
#include <gtest/gtest.h>

#include "test_scenes.h"

namespace omma::test {
namespace {

Vec3 seen(const Background& background, Vec3d direction, const Mat4& pose = {}) {
  Scene scene;
  scene.background = background;
  const Result result = render(scene, make_eye(direction, 0), {.sampling = Fixed{1}}, pose);
  return {result.response[0], result.response[1], result.response[2]};
}

void expect_color(Vec3 found, Vec3d expected, double tolerance = 1e-6) {
  EXPECT_NEAR(found.x, expected.x, tolerance);
  EXPECT_NEAR(found.y, expected.y, tolerance);
  EXPECT_NEAR(found.z, expected.z, tolerance);
}

TEST(Background, NoneIsBlack) {
  expect_color(seen(Background{}, {0, 1, 0}), {0, 0, 0});
}

TEST(Background, ConstantIsNotClipped) {
  expect_color(seen(constant_background({0.5f, 3, 0}), {0, 0, -1}), {0.5, 3, 0});
}

TEST(Background, SimpleSky) {
  Background sky;
  sky.type = BackgroundType::simple_sky;
  const Vec3d horizon = Vec3d{143, 179, 203} * (0.8 / 255),
              zenith = Vec3d{1, 31, 117} * (1 / 255.0);
  for (const double elevation_deg : {-90.0, -40.0, -1.0, 0.0, 10.0, 45.0, 80.0, 90.0})
    for (const double azimuth_deg : {0.0, 77.0, -130.0, 180.0}) {
      const double up = std::max(0.0, elevation_deg / 90);
      // asin in float is off by 2e-4 rad at worst near the zenith, which is 1e-4 of the span.
      expect_color(seen(sky, from_azimuth_elevation(azimuth_deg * degree, elevation_deg * degree)),
                   horizon * (1 - up) + zenith * up, 1e-4);
    }
}

TEST(Background, SkyStaysWithTheWorld) {
  Background sky;
  sky.type = BackgroundType::simple_sky;
  // The head pitched up by a quarter looks at the zenith.
  expect_color(seen(sky, {0, 0, -1}, rotation({1, 0, 0}, pi / 2)), Vec3d{1, 31, 117} * (1 / 255.0),
               1e-4);
}

TEST(Background, TestPattern) {
  Background pattern;
  pattern.type = BackgroundType::test_pattern;
  for (const Vec3d d : {normalize(Vec3d{1, 1, 1}), normalize(Vec3d{-1, 0.5, 2}),
                        normalize(Vec3d{0.3, -0.8, -1}), normalize(Vec3d{-2, 0.1, -0.4})})
    expect_color(seen(pattern, d),
                 {(std::atan2(d.z, d.x) + pi) / (2 * pi), (std::asin(d.y) + pi / 2) / pi, 0}, 1e-5);
  // A black border along the planes of the axes, on both sides.
  for (const double side : {-0.009, 0.0, 0.009}) {
    expect_color(seen(pattern, normalize(Vec3d{side, 0.6, 0.8})), {0, 0, 0});
    expect_color(seen(pattern, normalize(Vec3d{0.6, side, -0.8})), {0, 0, 0});
    expect_color(seen(pattern, normalize(Vec3d{-0.6, 0.8, side})), {0, 0, 0});
  }
  EXPECT_GT(seen(pattern, normalize(Vec3d{0.011, 0.6, 0.8})).x, 0);
}

// Forward in the middle, +X to its right, +Y at the top: columns show -180 to 180 degrees.
TEST(Background, ImageOrientation) {
  const Background columns = image_background(make_image(8, 4, [](int column, int row) {
    return Vec4{static_cast<float>(column), static_cast<float>(row), 0.5f, 1};
  }));
  for (int column = 0; column < 8; ++column)
    for (int row = 0; row < 4; ++row) {
      const double azimuth = (-180 + 45 * (column + 0.5)) * degree;
      const double elevation = (90 - 45 * (row + 0.5)) * degree;
      expect_color(seen(columns, from_azimuth_elevation(azimuth, elevation)),
                   {static_cast<double>(column), static_cast<double>(row), 0.5}, 1e-4);
    }
  // Between pixels it is bilinear, round the back too, and the poles show the last rows.
  expect_color(seen(columns, {0, 0, -1}), {3.5, 1.5, 0.5}, 1e-4);
  expect_color(seen(columns, {1, 0, 0}), {5.5, 1.5, 0.5}, 1e-4);
  expect_color(seen(columns, {0, 0, 1}), {3.5, 1.5, 0.5}, 1e-4);  // between 7 and 0
  EXPECT_NEAR(seen(columns, {0, 1, 0}).y, 0, 1e-4);
  EXPECT_NEAR(seen(columns, {0, -1, 0}).y, 3, 1e-4);
}

TEST(Background, EightBitImagesAreDecodedFromSrgb) {
  Image image;
  image.width = image.height = 1;
  image.rgba_srgb8 = {0, 128, 255, 255};
  // IEC 61966-2-1: ((128/255 + 0.055) / 1.055)^2.4
  expect_color(seen(image_background(image), {0.6, 0, -0.8}),
               {0, std::pow((128 / 255.0 + 0.055) / 1.055, 2.4), 1}, 1e-5);
}

TEST(Background, TheCallersOverridesTheScenes) {
  Scene scene;
  scene.background = constant_background({1, 0, 0});
  RenderSettings settings{.sampling = Fixed{1}};
  settings.background = constant_background({0, 1, 0});
  const Eye eye = make_eye(Vec3d{0, 0, -1}, 0);
  EXPECT_EQ(render(scene, eye, settings).at(0, 1), 1);
  EXPECT_EQ(render(scene, eye, settings).at(0, 0), 0);
  // ... but no surface.
  add_quad(scene, {0, 0, -2}, {1, 0, 0}, {0, 1, 0}, add_color(scene, {0, 0, 1}));
  EXPECT_EQ(render(scene, eye, settings).at(0, 2), 1);
}

}  // namespace
}  // namespace omma::test
