// CompoundRay's rule for colours: textures and vertex colours to the power 2.2 after interpolation,
// vertex colours in place of the rest.
#include <gtest/gtest.h>

#include "test_scenes.h"

namespace omma::test {
namespace {

// The table is linear between 4,097 nodes: within 2e-8 of the power; the rest is rounding.
constexpr double tolerance = 1e-6;

// What one ray at (x, y) of a square from -1 to 1 sees, 5 m ahead.
Vec3 seen(const Scene& scene, double x, double y) {
  const Result result =
      render(scene, make_eye(normalize(Vec3d{x, y, -5}), 0), {.sampling = Fixed{1}});
  return {result.response[0], result.response[1], result.response[2]};
}

// Two texels, 0.2 and 0.8 in code values, over the square; factor 0.5, 1, 2.
Scene textured_square() {
  Scene scene;
  scene.color_rule = ColorRule::compoundray;
  Image image;
  image.width = 2, image.height = 1;
  image.rgba_srgb8 = {51, 51, 51, 0, 204, 204, 204, 255};
  Material material;
  material.base_color = {0.5f, 1, 2, 1};
  material.double_sided = true;
  material.base_color_texture.texture = add_texture(scene, std::move(image));
  add_quad(scene, {0, 0, -5}, {1, 0, 0}, {0, 1, 0}, add_material(scene, material));
  return scene;
}

TEST(CompoundRayColors, TextureIsRaisedAfterFiltering) {
  const Scene scene = textured_square();
  // Across the two texel centres at x = -0.5 and 0.5 the code value goes from 0.2 to 0.8.
  for (const double x : {-0.5, -0.25, 0.0, 0.3, 0.5}) {
    const double value = std::pow(0.5 + 0.6 * x, 2.2);
    const Vec3 color = seen(scene, x, 0.1);
    EXPECT_NEAR(color.x, 0.5 * value, tolerance) << x;
    EXPECT_NEAR(color.y, value, tolerance) << x;
    EXPECT_NEAR(color.z, 2 * value, 2 * tolerance) << x;
  }
}

TEST(CompoundRayColors, VertexColorsReplace) {
  Scene scene = textured_square();
  scene.meshes[0].colors = {{0, 0.25f, 1, 1}, {0, 0.25f, 1, 1}, {1, 0.75f, 1, 1}, {1, 0.75f, 1, 1}};
  for (const double x : {-0.75, 0.0, 0.4, 0.75}) {
    const double share = 0.5 + 0.5 * x;
    const Vec3 color = seen(scene, x, 0.1);
    EXPECT_NEAR(color.x, std::pow(share, 2.2), tolerance) << x;
    EXPECT_NEAR(color.y, std::pow(0.25 + 0.5 * share, 2.2), tolerance) << x;
    EXPECT_NEAR(color.z, 1, tolerance) << x;
  }
}

TEST(CompoundRayColors, FactorAloneIsLinear) {
  Scene scene;
  scene.color_rule = ColorRule::compoundray;
  add_quad(scene, {0, 0, -5}, {1, 0, 0}, {0, 1, 0}, add_color(scene, {0.3f, 0, 4}));
  const Vec3 color = seen(scene, 0.1, 0.1);
  EXPECT_EQ(color.x, 0.3f);
  EXPECT_EQ(color.z, 4);
}

// A mesh without a material is white from both sides.
TEST(CompoundRayColors, NoMaterialIsSeenFromBehind) {
  Scene scene;
  add_quad(scene, {0, 0, -5}, {-1, 0, 0}, {0, 1, 0}, -1);
  EXPECT_EQ(seen(scene, 0, 0).x, 0);
  scene.color_rule = ColorRule::compoundray;
  EXPECT_EQ(seen(scene, 0, 0).x, 1);
}

}  // namespace
}  // namespace omma::test
