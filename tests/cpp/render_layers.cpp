// Surfaces that let light through, lying in one place or nearly so: n layers of opacity alpha let
// (1 - alpha)^n of what lies behind through, wherever they lie and however the ray meets them.
#include <gtest/gtest.h>

#include <algorithm>

#include "test_scenes.h"

namespace omma::test {
namespace {

Material glass(float alpha, Vec3 color = {0, 0, 0}) {
  Material material;
  material.base_color = {color.x, color.y, color.z, alpha};
  material.alpha_mode = AlphaMode::blend;
  material.double_sided = true;
  return material;
}

// Rays ahead, all over a patch of the view that layers of half side 1 at distance 1 fill; the first
// is exactly along the axis, where the diagonals of quads are.
Eye view_ahead(int rays = 300) {
  Random random{17};
  std::vector<Vec3d> axes{{0, 0, -1}};
  for (int i = 1; i < rays; ++i)
    axes.push_back({random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), -1});
  return make_eye(axes, 0);
}

// Floats: a product of eight, each rounded, times a radiance of 1.
constexpr double tolerance = 1e-6;

void expect_through(const Scene& scene, double expected, const std::string& what,
                    const Mat4& pose = {}, int rays = 300) {
  const Eye eye = view_ahead(rays);
  const Result result = render(scene, eye, {.sampling = Fixed{1}}, pose);
  int wrong = 0;
  for (std::size_t i = 0; i < eye.size(); ++i)
    if (!(std::fabs(result.at(i) - expected) <= tolerance) && ++wrong <= 3)
      ADD_FAILURE() << what << ", ray " << i << ": found " << result.at(i) << ", expected "
                    << expected;
  EXPECT_EQ(wrong, 0) << what << ", of " << eye.size();
}

enum class Placed { meshes, one_mesh, instances, mirrored };

constexpr Placed ways[] = {Placed::meshes, Placed::one_mesh, Placed::instances, Placed::mirrored};

std::string name_of(Placed placed) {
  switch (placed) {
    case Placed::meshes:
      return "meshes";
    case Placed::one_mesh:
      return "one mesh";
    case Placed::instances:
      return "instances";
    case Placed::mirrored:
      return "mirrored instances";
  }
  return "";
}

// `count` layers across the view at `distance`, `apart` from one another, before a white surround.
Scene layered(int count, double distance, double apart, float alpha, Placed placed) {
  Scene scene;
  scene.background = constant_background({1, 1, 1});
  const int material = add_material(scene, glass(alpha));
  const auto layer = [&](int k) {
    return quad({0, 0, -distance - k * apart}, {distance, 0, 0}, {0, distance, 0}, material);
  };
  if (placed == Placed::meshes)
    for (int k = 0; k < count; ++k) add_instance(scene, add_mesh(scene, layer(k)));
  if (placed == Placed::one_mesh) {
    Mesh all;
    all.material = material;
    for (int k = 0; k < count; ++k) {
      const auto first = static_cast<std::uint32_t>(all.positions.size());
      const Mesh one = layer(k);
      all.positions.insert(all.positions.end(), one.positions.begin(), one.positions.end());
      for (const auto& t : one.triangles)
        all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    add_instance(scene, add_mesh(scene, all));
  }
  if (placed == Placed::instances || placed == Placed::mirrored) {
    const int mesh = add_mesh(scene, layer(0));
    for (int k = 0; k < count; ++k)
      add_instance(scene, mesh,
                   translation({0, 0, -k * apart}) *
                       scaling({placed == Placed::mirrored ? -1.0 : 1.0, 1, 1}));
  }
  return scene;
}

TEST(Layers, InOnePlaceAllCount) {
  for (const Placed placed : ways)
    for (const int count : {1, 2, 3, 8})
      for (const double distance : {1e-6, 1e-3, 0.3, 5.0, 1e3})
        expect_through(layered(count, distance, 0, 0.3f, placed), std::pow(0.7, count),
                       name_of(placed) + ", " + std::to_string(count) + " layers at " +
                           std::to_string(distance) + " m");
}

// Closer together than hits are computed: in the order of distance or not, each counts once.
TEST(Layers, AlmostInOnePlaceAllCount) {
  for (const Placed placed : ways)
    for (const int count : {2, 3, 8})
      for (const double apart : {1e-8, 1e-7, 1e-6, 1e-5, 1e-4})
        expect_through(layered(count, 5, apart, 0.3f, placed), std::pow(0.7, count),
                       name_of(placed) + ", " + std::to_string(count) + " layers " +
                           std::to_string(apart) + " m apart");
}

// The same from poses where no number is round, seen aslant, and with meshes as Embree instances.
TEST(Layers, CountFromAnywhere) {
  Random random{5};
  for (const Placed placed : ways)
    for (int k = 0; k < 12; ++k) {
      const Mat4 place =
          translation(random.direction() * random.uniform(0, 20)) * random_rotation(random);
      const Mat4 tilt = translation({0, 0, -5}) * rotation({1, 0, 0}, random.uniform(-1, 1)) *
                        translation({0, 0, 5});
      Scene scene = layered(3, 5, 0, 0.3f, placed);
      // Seen aslant: larger, so that the view is still filled.
      for (Instance& instance : scene.instances)
        instance.world_from_mesh = place * tilt * scaling({4, 4, 1}) * instance.world_from_mesh;
      expect_through(scene, 0.343, name_of(placed) + " at place " + std::to_string(k), place);
      // Beyond a million triangles of copies meshes become instances (render_reference.cpp).
      Mesh many;
      many.positions = {{0, 1e3f, -1}, {0, 1e3f, 1}};
      many.triangles.assign(600'000, {0, 1, 0});
      const int index = add_mesh(scene, many);
      for (int copy = 0; copy < 2; ++copy) add_instance(scene, index);
      if (k % 4 == 0) expect_through(scene, 0.343, name_of(placed) + " in a large scene", place);
    }
}

// Another mesh of the same shape, cut into triangles along the other diagonal, and one into many.
TEST(Layers, OfOtherTrianglesCountToo) {
  Scene scene;
  scene.background = constant_background({1, 1, 1});
  const int material = add_material(scene, glass(0.3f));
  Mesh one = quad({0, 0, -5}, {5, 0, 0}, {0, 5, 0}, material), other = one;
  other.triangles = {{0, 1, 3}, {1, 2, 3}};
  add_instance(scene, add_mesh(scene, one));
  add_instance(scene, add_mesh(scene, other));
  expect_through(scene, 0.49, "two diagonals");
  Mesh fine;
  fine.material = material;
  constexpr std::uint32_t n = 64;  // even: corners of triangles lie in the middle of the view
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i)
      fine.positions.push_back(
          {-5 + 10.0f * static_cast<float>(i) / n, -5 + 10.0f * static_cast<float>(j) / n, -5});
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      fine.triangles.push_back({a, a + 1, a + n + 2});
      fine.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  Scene alone = scene;
  alone.instances.clear();
  add_instance(alone, add_mesh(alone, fine));
  expect_through(alone, 0.7, "one of many triangles");
  add_instance(scene, add_mesh(scene, fine));
  expect_through(scene, 0.343, "three kinds");
}

// Rays that meet edges and corners exactly: all the triangles about them are one surface.
TEST(Layers, CountOnceAtEdgesAndCorners) {
  for (const int layers : {1, 2, 3}) {
    Scene scene;
    scene.background = constant_background({1, 1, 1});
    Mesh grid;
    grid.material = add_material(scene, glass(0.3f));
    constexpr std::uint32_t n = 8;
    for (int layer = 0; layer < layers; ++layer) {
      const auto first = static_cast<std::uint32_t>(grid.positions.size());
      for (std::uint32_t j = 0; j <= n; ++j)
        for (std::uint32_t i = 0; i <= n; ++i)
          grid.positions.push_back(
              {static_cast<float>(i) - n / 2, static_cast<float>(j) - n / 2, -8});
      for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
          const std::uint32_t a = first + j * (n + 1) + i;
          grid.triangles.push_back({a, a + 1, a + n + 2});
          grid.triangles.push_back({a, a + n + 2, a + n + 1});
        }
    }
    add_instance(scene, add_mesh(scene, grid));
    std::vector<Vec3d> axes;
    std::vector<Vec3> positions;
    // Straight ahead through corners, middles of edges and diagonals, all exact in floats.
    for (int j = -6; j <= 6; ++j)
      for (int i = -6; i <= 6; ++i) {
        axes.push_back({0, 0, -1});
        positions.push_back({0.5f * static_cast<float>(i), 0.5f * static_cast<float>(j), 0});
      }
    Eye eye = make_eye(axes, 0);
    eye.position_m = positions;
    const Result result = render(scene, eye, {.sampling = Fixed{1}});
    for (std::size_t i = 0; i < eye.size(); ++i)
      EXPECT_NEAR(result.at(i), std::pow(0.7, layers), tolerance)
          << layers << " layers, at " << positions[i].x << ' ' << positions[i].y;
  }
}

// More than can be remembered in one place, and opaque ones among them: rays come to an end, and
// nothing is seen through what is opaque. Which of two in one place is in front stays open.
TEST(Layers, ManyAndOpaqueOnesEnd) {
  expect_through(layered(60, 5, 0, 0.01f, Placed::meshes), std::pow(0.99, 60), "60 layers");
  const Scene many = layered(200, 5, 0, 0.01f, Placed::meshes);
  const Result result = render(many, view_ahead(), {.sampling = Fixed{1}});
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_LE(result.at(i), std::pow(0.99, 60));
    EXPECT_GE(result.at(i), std::pow(0.99, 200));
  }
  for (const double apart : {0.0, 1e-6}) {
    Scene scene = layered(2, 5, apart, 0.3f, Placed::meshes);
    const int gray = add_color(scene, {0.5f, 0.5f, 0.5f});
    add_instance(scene, add_mesh(scene, quad({0, 0, -5}, {5, 0, 0}, {0, 5, 0}, gray)));
    const Result seen = render(scene, view_ahead(), {.sampling = Fixed{1}});
    for (std::size_t i = 0; i < 300; ++i) {
      const double layers_before = std::log(seen.at(i) / 0.5) / std::log(0.7);
      EXPECT_NEAR(layers_before, std::round(layers_before), 1e-5) << seen.at(i);
      EXPECT_LE(std::round(layers_before), 2);
      EXPECT_GE(std::round(layers_before), 0);
    }
  }
}

// Layers a way off from one another are met front to back, whatever lies between.
TEST(Layers, ColoursComeFrontToBack) {
  Scene scene;
  scene.background = constant_background({1, 1, 1});
  const Vec3 colors[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double expected[3] = {0.125, 0.125, 0.125};
  for (int k = 0; k < 3; ++k) {
    const int material = add_material(scene, glass(0.5f, colors[k]));
    const double z = 5 + 1e-3 * k;
    add_instance(scene, add_mesh(scene, quad({0, 0, -z}, {5, 0, 0}, {0, 5, 0}, material)));
    expected[k] += std::pow(0.5, k + 1);
  }
  const Result result = render(scene, view_ahead(), {.sampling = Fixed{1}});
  for (std::size_t i = 0; i < 300; ++i)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(result.at(i, c), expected[c], tolerance);
}

// An eye in the very surface of a layer, and beyond it by less than a float can tell.
TEST(Layers, AnEyeInALayerSeesOn) {
  const Scene scene = layered(2, 1, 0, 0.3f, Placed::meshes);
  for (const double z : {-1.0, -1 - 1e-9, -1 - 1e-7}) {
    const Result result =
        render(scene, view_ahead(), {.sampling = Fixed{1}}, translation({0, 0, z}));
    for (std::size_t i = 0; i < 300; ++i) {
      const double layers = std::log(result.at(i)) / std::log(0.7);
      EXPECT_NEAR(layers, std::round(layers), 1e-5) << result.at(i);
    }
  }
}

}  // namespace
}  // namespace omma::test
