// Where a scene is traced from, and what is told of vertices that single precision has moved.
#include <gtest/gtest.h>

#include "model/scene_place.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

Bounds box(Vec3d middle, double half) {
  const Vec3d h{half, 0.5 * half, 0.1 * half};
  return {middle - h, middle + h, false};
}

bool same(Vec3d a, Vec3d b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

TEST(ScenePlace, OrdinaryScenesStayWhereTheyAre) {
  for (const double half : {1e-6, 1.0, 1e3, 1e9})
    for (const Vec3d middle : {Vec3d{0, 0, 0}, {1, -1, 0}, {0, 4, 0}, {-3.9, 3.9, 3.9}})
      EXPECT_TRUE(same(origin_near(box(middle * half, half)), {}));
  EXPECT_TRUE(same(origin_near({}), {}));
  for (const std::uint64_t seed : {1u, 2u, 3u})
    EXPECT_TRUE(same(origin_near(rough_scene_bounds(random_scene(seed))), {}));
}

TEST(ScenePlace, FarOnesHaveAnOriginOfFewDigitsWithinThem) {
  Random random{4};
  for (int i = 0; i < 200; ++i) {
    const double half = std::exp2(random.uniform(-10, 10));
    const Vec3d middle = random.direction() * (half * std::exp2(random.uniform(4, 20)));
    const Vec3d origin = origin_near(box(middle, half));
    EXPECT_LE(std::fabs(origin.x - middle.x), half);
    EXPECT_LE(std::fabs(origin.y - middle.y), half);
    EXPECT_LE(std::fabs(origin.z - middle.z), half);
    // A float in the box, less the origin, is a float.
    const Vec3 vertex = to_float(middle);
    const Vec3d from_origin = to_double(vertex) - origin;
    EXPECT_TRUE(same(to_double(to_float(from_origin)), from_origin));
  }
  // A single point.
  EXPECT_NEAR(origin_near(box({1e6, 2, 3}, 0)).x, 1e6, 1);
}

TEST(ScenePlace, RoughBoundsAreAroundTheExactOnes) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const Scene scene = random_scene(seed);
    const Bounds exact = scene_bounds(scene), rough = rough_scene_bounds(scene);
    EXPECT_LE(rough.lower.x, exact.lower.x + 1e-9);
    EXPECT_LE(rough.lower.y, exact.lower.y + 1e-9);
    EXPECT_GE(rough.upper.z, exact.upper.z - 1e-9);
    EXPECT_LE(half_size_m(rough), 2 * half_size_m(exact));
  }
  EXPECT_TRUE(rough_scene_bounds(Scene{}).empty);
}

TEST(ScenePlace, RoundedVerticesAreTold) {
  EXPECT_TRUE(place_warnings(Scene{}).empty());
  EXPECT_TRUE(place_warnings(random_scene(2)).empty());
  const auto quad_at = [](Vec3d middle, const Mat4& placed) {
    Scene scene;
    add_instance(scene, add_mesh(scene, quad(middle, {10, 0, 0}, {0, 10, 0}, -1)), placed);
    return scene;
  };
  EXPECT_TRUE(place_warnings(quad_at({0, 0, 0}, translation({5e6, 0, 0}))).empty());
  const auto told = place_warnings(quad_at({5e6, 0, 0}, {}));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].find("1 of 1 placed meshes"), std::string::npos) << told[0];
  EXPECT_NE(told[0].find("up to 0.3 m, in a scene of 20 m"), std::string::npos) << told[0];
  EXPECT_EQ(place_warnings(quad_at({5e6, 0, 0}, translation({-5e6, 0, 0}))).size(), 1u);
  // A dome around the origin is large, but not off its own origin.
  Scene dome;
  add_instance(dome, add_mesh(dome, cube_seen_from_inside(1e6, -1)));
  EXPECT_TRUE(place_warnings(dome).empty());
}

TEST(ScenePlace, WhatIsTooFarAwayIsTold) {
  Scene scene;
  add_instance(scene, add_mesh(scene, cube_seen_from_inside(1, -1)));
  scene.instances[0].name = "near";
  EXPECT_TRUE(place_warnings(scene).empty());
  add_instance(scene, 0, scaling({1e19, 1e19, 1e19}));
  scene.instances[1].name = "heavens";
  ASSERT_EQ(place_warnings(scene).size(), 1u);
  EXPECT_NE(place_warnings(scene)[0].find("node \"heavens\""), std::string::npos);
}

}  // namespace
}  // namespace omma::test
