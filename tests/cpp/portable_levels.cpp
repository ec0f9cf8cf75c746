// Two levels: meshes that are placed several times, turned, stretched, mirrored, or that move,
// against trying every triangle where it is in the world, and against copies of them.
#include <gtest/gtest.h>

#include "portable_rays.h"

namespace omma::test {
namespace {

// A closed bumpy ball about the origin, its triangles counter-clockwise from outside.
Mesh ball(std::uint32_t n, double bumps, int material) {
  Mesh mesh;
  mesh.material = material;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i < 2 * n; ++i) {
      const double theta = pi * j / n, phi = pi * i / n;
      const double r = 1 + bumps * std::sin(5 * phi) * std::sin(theta) * std::sin(4 * theta);
      mesh.positions.push_back(to_float({r * std::sin(theta) * std::cos(phi), r * std::cos(theta),
                                         -r * std::sin(theta) * std::sin(phi)}));
    }
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < 2 * n; ++i) {
      const std::uint32_t next = (i + 1) % (2 * n);
      const std::uint32_t a = j * 2 * n + i, b = j * 2 * n + next, c = a + 2 * n, d = b + 2 * n;
      mesh.triangles.push_back({a, c, b});
      mesh.triangles.push_back({b, c, d});
    }
  return mesh;
}

Mat4 any_transform(Random& random, double spread_m) {
  const Vec3d place{random.uniform(-spread_m, spread_m), random.uniform(-spread_m, spread_m),
                    random.uniform(-spread_m, spread_m)};
  const auto factor = [&] { return random.uniform(0.3, 1.5); };
  const Vec3d size{factor() * (random.index(3) == 0 ? -1 : 1), factor(), factor()};
  return translation(place) * random_rotation(random) * scaling(size) * random_rotation(random);
}

std::vector<TestRay> rays_from_all_round(Random& random, int packets, double size_m) {
  std::vector<TestRay> rays;
  for (int p = 0; p < packets; ++p) {
    const Vec3d origin = random.direction() * random.uniform(0, 1.5 * size_m);
    const Vec3d towards = normalize(random.direction() * (0.7 * size_m) - origin);
    for (int l = 0; l < 16; ++l)
      rays.push_back(
          {to_float(origin),
           to_float(normalize(towards + random.direction() * (p % 2 == 0 ? 0.05 : 0.8)))});
  }
  return rays;
}

std::vector<std::int32_t> all_of(const Scene& scene) {
  std::vector<std::int32_t> instances(scene.instances.size());
  for (std::size_t i = 0; i < instances.size(); ++i) instances[i] = static_cast<std::int32_t>(i);
  return instances;
}

Scene many_balls(Random& random, int instances) {
  Scene scene;
  const int white = add_color(scene, {1, 1, 1});
  Material one_sided;
  const int front_only = add_material(scene, one_sided);
  add_mesh(scene, ball(8, 0.2, white));
  add_mesh(scene, ball(6, 0, front_only));
  add_mesh(scene, quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, white));
  for (int i = 0; i < instances; ++i) add_instance(scene, i % 3, any_transform(random, 4));
  return scene;
}

// Without single-sided meshes, of which the slow search knows nothing.
void use_one_material(Scene& scene) {
  for (Mesh& mesh : scene.meshes) mesh.material = 0;
}

TEST(PortableLevels, PlacedMeshesAreWhereTheyAre) {
  Random random{1};
  Scene scene = many_balls(random, 40);
  use_one_material(scene);
  TracedScene traced(scene);
  const std::vector<TestRay> rays = rays_from_all_round(random, 120, 6);
  std::size_t shared = 0;
  for (const PlacedInstance& i : traced.tracer->layout.instances) shared += i.is_shared;
  EXPECT_GT(shared, 5u);  // the mirrored ones
  EXPECT_LT(shared, 40u);
  EXPECT_GT(expect_as_brute_force(*traced.tracer, rays, 8e-6), 1000u);

  // The same, every one of them shared, at the top of its own tree.
  std::vector<Mat4> transforms;
  for (const Instance& instance : traced.scene.instances)
    transforms.push_back(instance.world_from_mesh);
  const std::vector<TestHit> copies = hits_of(*traced.tracer, rays);
  traced.move(all_of(traced.scene), transforms);
  EXPECT_EQ(traced.tracer->trees.size(), 40u);
  EXPECT_GT(expect_as_brute_force(*traced.tracer, rays, 8e-6), 1000u);
  const std::vector<TestHit> moved = hits_of(*traced.tracer, rays);
  std::size_t differ = 0;
  for (std::size_t i = 0; i < rays.size(); ++i)
    differ += copies[i].placed != moved[i].placed || copies[i].triangle != moved[i].triangle;
  // Rays that pass an edge within rounding, which differs between the frames.
  EXPECT_LE(differ, rays.size() / 500);
}

// What moves is seen where it is; what never moved stays a copy; coming back gives the same hits.
TEST(PortableLevels, Moving) {
  Random random{2};
  Scene scene = many_balls(random, 30);
  use_one_material(scene);
  TracedScene traced(scene);
  const std::vector<TestRay> rays = rays_from_all_round(random, 60, 6);
  const std::vector<std::int32_t> movers{3, 11, 17, 28};
  std::vector<TestHit> first;
  for (int step = 0; step < 4; ++step) {
    std::vector<Mat4> to;
    for (const std::int32_t i : movers) {
      const Mat4& t = scene.instances[static_cast<std::size_t>(i)].world_from_mesh;
      to.push_back(step == 3 ? translation({0.5, 0, 0.1}) * t
                             : translation({0.5 + step, 0, 0.1}) * t);
    }
    const TriangleQuad* blocks = traced.tracer->quads.data();
    traced.move(movers, to);
    EXPECT_TRUE(step == 0 || traced.tracer->quads.data() == blocks) << "trees were built again";
    SCOPED_TRACE(step);
    EXPECT_GT(expect_as_brute_force(*traced.tracer, rays, 8e-6), 300u);
    if (step == 0) first = hits_of(*traced.tracer, rays);
  }
  EXPECT_TRUE(hits_of(*traced.tracer, rays) == first);
}

// Many copies of a large mesh are shared from the start.
TEST(PortableLevels, LargeScenesShareTheirMeshes) {
  Random random{4};
  Scene scene;
  add_mesh(scene, ball(90, 0.2, add_color(scene, {1, 1, 1})));  // 32,400 triangles
  for (int i = 0; i < 40; ++i) add_instance(scene, 0, any_transform(random, 5));
  const TracedScene traced(std::move(scene));
  EXPECT_EQ(traced.tracer->trees.size(), 40u);
  EXPECT_LT(traced.tracer->quads.size(), 32400u);
  const std::vector<TestRay> rays = rays_from_all_round(random, 4, 6);
  EXPECT_GT(expect_as_brute_force(*traced.tracer, rays, 8e-6), 5u);
}

// A mirrored mesh shows its front on the same side as the one it mirrors (glTF 2.0, 3.7.4), a copy
// or not: the nearest side of a ball seen from outside, the furthest from inside none.
TEST(PortableLevels, FrontsStayFrontsWhateverTheTransform) {
  Random random{5};
  Scene scene;
  Material front_only;
  add_mesh(scene, ball(12, 0, add_material(scene, front_only)));
  for (int i = 0; i < 8; ++i)
    add_instance(scene, 0,
                 translation({i * 10.0, 0, 0}) * random_rotation(random) *
                     scaling({i % 2 == 0 ? 1.0 : -1.0, 1, i % 3 == 0 ? 0.5 : 1}));
  TracedScene traced(std::move(scene));
  for (const bool moving : {false, true}) {
    if (moving) {
      std::vector<Mat4> transforms;
      for (const Instance& i : traced.scene.instances) transforms.push_back(i.world_from_mesh);
      traced.move(all_of(traced.scene), transforms);
    }
    std::vector<TestRay> from_outside, from_inside;
    for (int i = 0; i < 8; ++i)
      for (int k = 0; k < 50; ++k) {
        const Vec3d centre{i * 10.0, 0, 0}, away = random.direction();
        const float short_m = 3;
        from_outside.push_back({to_float(centre + away * 3.0), to_float(away * -1.0), 0, short_m});
        from_inside.push_back({to_float(centre), to_float(away), 0, short_m});
      }
    const auto seen = [&](const std::vector<TestRay>& rays) {
      std::size_t count = 0;
      for (const TestHit& hit : hits_of(*traced.tracer, rays)) count += hit.placed != none;
      return count;
    };
    EXPECT_EQ(seen(from_outside), from_outside.size());
    EXPECT_EQ(seen(from_inside), 0u);
  }
}

}  // namespace
}  // namespace omma::test
