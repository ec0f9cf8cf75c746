// The brightest scenes that are taken: responses and their errors stay finite and right.
#include <gtest/gtest.h>

#include <algorithm>

#include "test_scenes.h"

namespace omma::test {
namespace {

constexpr float most = 1e15f;

// A white half of the view, as bright as is allowed, before a black one.
Scene half_bright() {
  Scene scene;
  add_quad(scene, {-50, 0, -1}, {50, 0, 0}, {0, 100, 0}, add_color(scene, {most, most, most}));
  return scene;
}

void expect_half(const Result& result, double tolerance) {
  for (const float value : result.response) {
    EXPECT_TRUE(std::isfinite(value));
    EXPECT_NEAR(value / most, 0.5, tolerance);
  }
  for (const float value : result.standard_error) {
    EXPECT_TRUE(std::isfinite(value)) << value;
    EXPECT_LT(value / most, 0.5);
  }
}

TEST(Bright, ResponsesAndErrorsAreFinite) {
  const Eye eye = make_eye(Vec3d{0, 0, -1}, 5 * degree, 30);
  // The share of a half plane: a few of some hundred rays fall on the other side.
  for (const int samples : {4, 8, 16, 100, 1024})
    expect_half(render(half_bright(), eye, {.sampling = Fixed{samples}}, {}, true), 0.15);
  // Never reached: all rays are spent.
  const RenderSettings to_error{.sampling = ToError{0.01, 8, 4096}};
  expect_half(render(half_bright(), eye, to_error, {}, true), 0.02);
  const RenderSettings shared{.sampling = Shared{16}};
  const Result result =
      render(half_bright(), make_eye(sphere_directions(2000), 5 * degree), shared, {}, true);
  for (const float value : result.response) EXPECT_TRUE(std::isfinite(value));
  for (const float value : result.standard_error) EXPECT_TRUE(std::isfinite(value));
}

// The sun as an image has it.
TEST(Bright, BackgroundsAreFinite) {
  Scene scene;
  scene.background = image_background(make_image(64, 32, [](int column, int row) {
    return column == 32 && row == 16 ? Vec4{most, most, most, 1} : Vec4{0, 0, 0, 1};
  }));
  const Result result = render(scene, make_eye(sphere_directions(200), 20 * degree),
                               {.sampling = Fixed{64}}, {}, true);
  for (const float value : result.response) EXPECT_TRUE(std::isfinite(value));
  for (const float value : result.standard_error) EXPECT_TRUE(std::isfinite(value));
  EXPECT_GT(*std::max_element(result.response.begin(), result.response.end()), 1e10f);
}

}  // namespace
}  // namespace omma::test
