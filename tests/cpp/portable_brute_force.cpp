// The portable search against trying every triangle in double precision, in sixteen lanes and one,
// closest and occluded, on what is hard for a builder: soups, grids, degenerate triangles,
// triangles that cannot be told apart, scales from 1e-6 to 1e12.
#include <gtest/gtest.h>

#include "portable_rays.h"

namespace omma::test {
namespace {

Mesh soup(Random& random, int triangles, double spread_m, double size_m) {
  Mesh mesh;
  const auto place = [&](double s) {
    return Vec3d{random.uniform(-s, s), random.uniform(-s, s), random.uniform(-s, s)};
  };
  for (int t = 0; t < triangles; ++t) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const Vec3d centre = place(spread_m);
    for (int i = 0; i < 3; ++i) mesh.positions.push_back(to_float(centre + place(size_m)));
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

Scene scene_of(Mesh mesh) {
  Scene scene;
  mesh.material = add_color(scene, {1, 1, 1});
  add_instance(scene, add_mesh(scene, std::move(mesh)));
  return scene;
}

// Rays in packets that look anywhere, that look almost the same way from one place, that look so from
// places a little apart, and that start anywhere, as paths that were scattered; some end early, some
// begin late, some run along an axis.
std::vector<TestRay> rays_about(Random& random, int packets, double size_m) {
  std::vector<TestRay> rays;
  const auto place = [&](double s) {
    return Vec3d{random.uniform(-s, s), random.uniform(-s, s), random.uniform(-s, s)};
  };
  for (int p = 0; p < packets; ++p) {
    const Vec3d origin = place(1.5 * size_m), towards = random.direction();
    const double cone = p % 4 == 0 ? 2 : p % 4 == 1 ? 0.3 : 0.03;
    for (int l = 0; l < 16; ++l) {
      TestRay ray;
      Vec3d from = origin;
      if (p % 3 == 0) from = from + place(0.02 * size_m);
      if (p % 9 == 8) from = place(1.5 * size_m);
      Vec3d direction = normalize(towards + random.direction() * (cone * random.uniform()));
      if (p % 7 == 6) direction = {0, l % 2 == 0 ? 1.0 : -1.0, 0};
      if (p % 14 == 13) direction = normalize(direction + random.direction() * 1e-12);
      ray.origin = to_float(from);
      ray.direction = to_float(direction);
      if (p % 5 == 4) ray.t_near_m = static_cast<float>(random.uniform(0, size_m));
      if (p % 6 == 5) ray.t_far_m = static_cast<float>(random.uniform(0, 2 * size_m));
      rays.push_back(ray);
    }
  }
  rays.resize(rays.size() - 5);  // the last packet is not full
  return rays;
}

TEST(PortableBruteForce, SoupsOfEverySize) {
  Random random{1};
  std::size_t met = 0;
  for (const int triangles : {1, 2, 3, 4, 5, 8, 9, 33, 100, 1000})
    for (const double size : {0.03, 0.3}) {
      const TracedScene traced(scene_of(soup(random, triangles, 1, size)));
      met += expect_as_brute_force(*traced.tracer, rays_about(random, 100, 1));
    }
  EXPECT_GT(met, 1000u);
}

TEST(PortableBruteForce, SmallAndLargeScales) {
  Random random{2};
  for (const double scale : {1e-6, 1e-3, 1e3, 1e6, 1e9, 1e12}) {
    Mesh mesh = soup(random, 400, 1, 0.2);
    for (Vec3& p : mesh.positions) p = p * static_cast<float>(scale / 1.3);
    const TracedScene traced(scene_of(mesh));
    SCOPED_TRACE(scale);
    const std::size_t met = expect_as_brute_force(*traced.tracer, rays_about(random, 100, scale));
    EXPECT_GT(met, 50u);
  }
}

// Small things seen from far away, and far things of large coordinates seen from near them.
TEST(PortableBruteForce, FarFromTheRays) {
  Random random{3};
  const TracedScene traced(scene_of(soup(random, 300, 1, 0.5)));
  std::vector<TestRay> rays;
  for (const double distance : {1e2, 1e4, 1e6})
    for (int i = 0; i < 800; ++i) {
      const Vec3d away = random.direction(), to = random.direction() * random.uniform(0, 1.5);
      const Vec3d from = away * distance;
      rays.push_back({to_float(from), to_float(normalize(to - from))});
    }
  EXPECT_GT(expect_as_brute_force(*traced.tracer, rays), 200u);
}

TEST(PortableBruteForce, FlatGrids) {
  Random random{4};
  for (int axis = 0; axis < 3; ++axis) {
    Mesh mesh;
    constexpr int n = 24;
    const auto at = [&](double x, double y) {
      const double p[3] = {x, y, 0.25};
      return to_float({p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]});
    };
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) mesh.positions.push_back(at(2.0 * i / n - 1, 2.0 * j / n - 1));
    for (std::uint32_t j = 0; j < n; ++j)
      for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
      }
    const TracedScene traced(scene_of(mesh));
    EXPECT_GT(expect_as_brute_force(*traced.tracer, rays_about(random, 100, 1)), 100u);
  }
}

// Triangles without a surface are never met, whatever the builder makes of them; those among them
// that have one are.
TEST(PortableBruteForce, DegenerateTriangles) {
  Random random{5};
  Mesh mesh = soup(random, 200, 1, 0.3);
  for (std::uint32_t t = 0; t < 200; t += 2) {
    Vec3* corner = mesh.positions.data() + 3 * t;
    if (t % 6 == 0) corner[1] = corner[2] = corner[0];
    if (t % 6 == 2) corner[2] = corner[1];
    if (t % 6 == 4) corner[2] = corner[0] + (corner[1] - corner[0]) * 0.5f;
  }
  const TracedScene traced(scene_of(mesh));
  EXPECT_GT(expect_as_brute_force(*traced.tracer, rays_about(random, 100, 1)), 100u);
  Mesh nothing = mesh;
  for (auto& t : nothing.triangles) t[2] = t[1];
  const TracedScene empty(scene_of(nothing));
  EXPECT_EQ(empty.tracer->view.top_nodes, nullptr);
  EXPECT_EQ(expect_as_brute_force(*empty.tracer, rays_about(random, 10, 1)), 0u);
}

// All middles in one place: no plane divides them, the tree must be made all the same, and be no
// deeper than the search has room for.
TEST(PortableBruteForce, TrianglesAboutOneMiddle) {
  Random random{6};
  Mesh mesh;
  for (std::uint32_t t = 0; t < 3000; ++t) {
    const double size = 1 + 1e-3 * static_cast<double>(t / 4);  // four of each size
    const Vec3d corner[3] = {{-size, -size, -size}, {size, size, -size}, {-size, size, size}};
    for (const Vec3d& p : corner) mesh.positions.push_back(to_float(p));
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  const TracedScene traced(scene_of(mesh));
  EXPECT_GT(expect_as_brute_force(*traced.tracer, rays_about(random, 40, 1)), 50u);
}

// Sizes that double: a heuristic alone would cut off one triangle at a time.
TEST(PortableBruteForce, SizesThatGrowWithoutEnd) {
  Random random{7};
  Mesh mesh;
  for (std::uint32_t t = 0; t < 2000; ++t) {
    const double size = std::exp2(0.04 * t - 40);
    for (int i = 0; i < 3; ++i)
      mesh.positions.push_back(to_float(Vec3d{size, 0, 0} + random.direction() * (0.3 * size)));
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  const TracedScene traced(scene_of(mesh));
  std::vector<TestRay> rays;
  for (int i = 0; i < 600; ++i)
    rays.push_back({{0, 0, 0}, to_float(normalize(Vec3d{1, 0, 0} + random.direction() * 0.2))});
  EXPECT_GT(expect_as_brute_force(*traced.tracer, rays), 100u);
}

TEST(PortableBruteForce, NothingAtAll) {
  Random random{8};
  const TracedScene traced{Scene{}};
  EXPECT_EQ(expect_as_brute_force(*traced.tracer, rays_about(random, 3, 1)), 0u);
}

// Of surfaces in exactly one place the first counts, in whatever order the search meets them: of
// placed meshes, and of triangles in one.
TEST(PortableBruteForce, CoincidentSurfacesCountInTheirOrder) {
  Random random{9};
  const Mesh one = soup(random, 60, 1, 0.5);
  Mesh many = one;
  for (int copy = 1; copy < 7; ++copy)
    many.triangles.insert(many.triangles.end(), one.triangles.begin(), one.triangles.end());
  Scene scene = scene_of(many);
  for (int copy = 0; copy < 3; ++copy) add_instance(scene, 0);
  const TracedScene traced(std::move(scene));
  std::size_t met = 0;
  for (const TestHit& hit : hits_of(*traced.tracer, rays_about(random, 200, 1))) {
    if (hit.placed == none) continue;
    ++met;
    EXPECT_LT(hit.triangle, 60u);
    EXPECT_EQ(hit.placed, 0u);
  }
  EXPECT_GT(met, 300u);
}

}  // namespace
}  // namespace omma::test
