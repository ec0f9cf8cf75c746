// Points inside hit boxes, and their bounds.
#include <gtest/gtest.h>

#include <cmath>

#include "omma/omma.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

HitBox box_of(const Mesh& mesh, const Mat4& world_from_mesh = {}) {
  return {"box", mesh.positions, mesh.triangles, world_from_mesh};
}

TEST(HitBox, CubeAgainstItsClosedForm) {
  const Mat4 pose =
      translation({3, -1, 2}) * rotation(normalize(Vec3d{1, 2, -1}), 0.7) * scaling({2, 0.5, -1});
  const HitBox cube = box_of(cube_seen_from_inside(1, -1), pose);
  Random random{1};
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3d local{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
    const bool expected =
        std::max({std::fabs(local.x), std::fabs(local.y), std::fabs(local.z)}) < 1;
    EXPECT_EQ(is_inside(cube, transform_point(pose, local)), expected);
    inside += expected;
  }
  EXPECT_GT(inside, 1000);
}

// A ray through corners and along edges and faces is counted once or not at all: nothing slips
// between the triangles that meet there.
TEST(HitBox, RaysThroughEdgesAndCorners) {
  const HitBox cube = box_of(cube_seen_from_inside(1, -1));
  const double inner[] = {-0.5, 0, 0.25, 0.5};
  for (const double x : inner)
    for (const double y : inner)
      for (const double z : inner) {
        EXPECT_TRUE(is_inside(cube, {x, y, z}));
        EXPECT_FALSE(is_inside(cube, {x - 5, y, z}));
        EXPECT_FALSE(is_inside(cube, {x + 5, y, z}));
      }
  // In line with the faces' planes, edges and corners, but outside.
  for (const double y : {-1.0, 0.0, 1.0})
    for (const double z : {-1.0, 0.0, 1.0}) {
      EXPECT_FALSE(is_inside(cube, {-2, y, z})) << y << " " << z;
      EXPECT_FALSE(is_inside(cube, {2, y, z})) << y << " " << z;
    }
}

TEST(HitBox, HollowShellIsOutsideInItsMiddle) {
  Mesh shell = cube_seen_from_inside(2, -1);
  const Mesh hole = cube_seen_from_inside(1, -1);
  const auto first = static_cast<std::uint32_t>(shell.positions.size());
  shell.positions.insert(shell.positions.end(), hole.positions.begin(), hole.positions.end());
  for (const auto& t : hole.triangles)
    shell.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  const HitBox box = box_of(shell);
  EXPECT_FALSE(is_inside(box, {0.1, 0.2, 0.3}));
  EXPECT_TRUE(is_inside(box, {1.5, 0.2, 0.3}));
  EXPECT_TRUE(is_inside(box, {0.1, 0.2, -1.5}));
  EXPECT_FALSE(is_inside(box, {0.1, 2.2, -1.5}));
}

TEST(HitBox, Bounds) {
  const HitBox cube =
      box_of(cube_seen_from_inside(1, -1), translation({5, 0, 0}) * scaling({1, 2, 3}));
  const Bounds bounds = hit_box_bounds(cube);
  EXPECT_FALSE(bounds.empty);
  EXPECT_EQ(bounds.lower.x, 4);
  EXPECT_EQ(bounds.upper.y, 2);
  EXPECT_EQ(bounds.upper.z, 3);
  EXPECT_TRUE(hit_box_bounds({}).empty);
  EXPECT_FALSE(is_inside({}, {0, 0, 0}));
}

}  // namespace
}  // namespace omma::test
