// The shadow map of the sun against closed forms and against shadow rays.
#include "backend/make_sun_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "backend/backend.h"
#include "backend/shading_data.h"
#include "physics/path/path.h"
#include "test_scenes.h"
#include "threads/arena.h"
#include "threads/parallel.h"

namespace omma::test {
namespace {

constexpr std::size_t mib = std::size_t{1} << 20;

// A scene with what traces it, as a World has it.
struct SunScene {
  Scene scene;
  std::unique_ptr<ShadingData> shading;
  Placement placement;
  Acceleration acceleration;
  Launches launches;

  explicit SunScene(Scene from)
      : scene(std::move(from)), shading(make_shading_data(scene)), placement(placement_of(scene)) {
    const Backend& backend = find_backend(backend_under_test);
    acceleration = backend.build(scene, shading->view, placement, {}, nullptr);
    launches = backend.launches({});
  }

  SunMapData map(Vec3d towards, const SunMapSettings& settings = {},
                 const WorkPart& work = {}) const {
    return make_sun_map({launches.closest, acceleration.tracer.get()}, scene, placement,
                        to_float(towards), settings, work);
  }

  // Whether a ray from a place of the world to the middle of the sun meets nothing.
  bool sees_sun(Vec3d position, Vec3d normal, Vec3d towards) const {
    RayPacket<16> rays{};
    clear<Lanes<16, 1>>(rays);
    const double side = dot(normal, towards) < 0 ? -1 : 1;
    const Vec3 from = to_float(position - placement.origin_m + normal * (side * 2e-5));
    const Vec3 along = to_float(towards);
    for (int l = 0; l < 16; ++l) {
      store_vector(rays.origin, l, vector_of(from));
      store_vector(rays.direction, l, vector_of(along));
      rays.t_far_m[l] = INFINITY;
    }
    launches.closest({&rays, 1}, acceleration.tracer.get());
    return rays.geometry[0] == none;
  }

  float visible(const SunMapData& map, Vec3d position, Vec3d normal) const {
    const Vec3 p = to_float(position - placement.origin_m), n = to_float(normal);
    const Vector3<float> at = vector_of(p);
    return eval_sun_map(map.view, find_on_sun_map(map.view, at), at, vector_of(n));
  }
};

// In the xz plane around `centre`; its rim is off a circle by less than 2e-5 of the radius.
Mesh disc(Vec3d centre, double radius_m, int material) {
  constexpr std::uint32_t sides = 512;
  Mesh mesh;
  mesh.material = material;
  mesh.positions.push_back(to_float(centre));
  for (std::uint32_t k = 0; k < sides; ++k) {
    const double a = 2 * pi * k / sides;
    mesh.positions.push_back(
        to_float(centre + Vec3d{std::cos(a) * radius_m, 0, std::sin(a) * radius_m}));
    mesh.triangles.push_back({0, 1 + k, 1 + (k + 1) % sides});
  }
  return mesh;
}

Scene ground_of(double half_m) {
  Scene scene;
  add_quad(scene, {0, 0, 0}, {half_m, 0, 0}, {0, 0, -half_m}, add_color(scene, {1, 1, 1}));
  return scene;
}

TEST(SunMap, ADiscCastsItsShadow) {
  constexpr double radius = 0.5, height = 1, texel = 0.01;
  const Vec3d up{0, 1, 0};
  Scene scene = ground_of(5);
  add_instance(scene, add_mesh(scene, disc({0, height, 0}, radius, 0)));
  const SunScene lit(std::move(scene));
  for (const double elevation_deg : {30.0, 60.0, 90.0}) {
    SCOPED_TRACE(elevation_deg);
    const Vec3d sun = from_azimuth_elevation(0.7, elevation_deg * degree);
    const SunMapData map = lit.map(sun, {texel});
    const Vec3d centre = Vec3d{sun.x, 0, sun.z} * (-height / sun.y);
    // On the ground texels are longer by this along the azimuth of the sun.
    const double longest = texel / sun.y;
    for (int line = 0; line < 12; ++line) {
      const double azimuth = line * pi / 6;
      const Vec3d out{std::cos(azimuth), 0, std::sin(azimuth)};
      constexpr double length = 1;
      constexpr int points = 4000;
      double lit_m = 0;
      for (int k = 0; k < points; ++k) {
        const double r = (k + 0.5) / points * length;
        const double seen = static_cast<double>(lit.visible(map, centre + out * r, up));
        lit_m += seen * length / points;
        // The four rays about a place are within a texel of it, along each axis.
        if (std::fabs(r - radius) > 1.5 * longest) {
          ASSERT_EQ(seen, r > radius ? 1 : 0) << r;
        }
      }
      EXPECT_NEAR(lit_m, length - radius, longest) << azimuth;
      EXPECT_EQ(lit.visible(map, Vec3d{0, height, 0} + out * (0.999 * radius), up), 1.0f);
    }
  }
}

// Sheets at a slope to a sun in the zenith, so far above each other, meshes in that order.
SunScene sheets(double slope_deg, double azimuth_rad, std::vector<double> ups_m, Vec3d at,
                double half_m) {
  const Vec3d across = {std::cos(azimuth_rad), 0, std::sin(azimuth_rad)};
  const Vec3d level = {-across.z, 0, across.x};
  const double s = slope_deg * degree;
  const Vec3d along = across * std::cos(s) + Vec3d{0, 1, 0} * std::sin(s);
  const Vec3d normal = cross(along, level);
  Scene scene;
  const int color = add_color(scene, {1, 1, 1});
  for (const double up : ups_m)
    add_quad(scene, at + normal * (up * (normal.y < 0 ? -1 : 1)), along * half_m, level * half_m,
             color);
  return SunScene(std::move(scene));
}

struct Place {
  Vec3d position, normal;
};

// Anywhere on a triangle.
Place place_on(const Mesh& mesh, int triangle, Random& random) {
  const auto& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  const Vec3d a = to_double(mesh.positions[t[0]]);
  const Vec3d e1 = to_double(mesh.positions[t[1]]) - a, e2 = to_double(mesh.positions[t[2]]) - a;
  double u = random.uniform(), v = random.uniform();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return {to_double(to_float(a + e1 * u + e2 * v)), normalize(cross(e1, e2))};
}

// Places on a sheet, but for a margin of it, with the normal of their triangle.
template <typename Body>
void for_places(const SunScene& lit, std::size_t mesh, Random& random, double margin,
                const Body& body) {
  const Mesh& sheet = lit.scene.meshes[mesh];
  const Vec3d middle = (to_double(sheet.positions[0]) + to_double(sheet.positions[2])) * 0.5;
  for (int k = 0; k < 2000; ++k) {
    const Place place = place_on(sheet, random.index(2), random);
    body(to_double(to_float(middle + (place.position - middle) * (1 - margin))), place.normal);
  }
}

TEST(SunMap, ASlopeDoesNotShadeItself) {
  Random random{11};
  for (const double slope_deg : {0.0, 5.0, 30.0, 60.0, 75.0, 80.0, 85.0, -85.0})
    for (const double azimuth : {0.0, 0.4, 2.2})
      for (const double texel : {0.05, 0.005})
        for (const double away_m : {0.0, 300.0}) {
          SCOPED_TRACE(testing::Message()
                       << slope_deg << ' ' << azimuth << ' ' << texel << ' ' << away_m);
          SunScene lit = sheets(slope_deg, azimuth, {0}, {away_m, 0.3 * away_m, 0}, 1);
          if (away_m > 0) {  // and something elsewhere, so that all is traced from there
            Scene scene = lit.scene;
            add_quad(scene, {-away_m, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
            lit = SunScene(std::move(scene));
          }
          const SunMapData map = lit.map({0, 1, 0}, {texel});
          int shaded = 0;
          for_places(lit, 0, random, 0,
                     [&](Vec3d p, Vec3d normal) { shaded += lit.visible(map, p, normal) < 1; });
          EXPECT_EQ(shaded, 0);
        }
}

TEST(SunMap, SheetsFiveMillimetresApartShadeEachOther) {
  Random random{12};
  for (const double slope_deg : {0.0, 30.0, 60.0, 80.0, 85.0})
    for (const double azimuth : {0.0, 0.4}) {
      SCOPED_TRACE(testing::Message() << slope_deg << ' ' << azimuth);
      const SunScene lit = sheets(slope_deg, azimuth, {0, 0.005}, {0, 0, 0}, 0.5);
      const SunMapData map = lit.map({0, 1, 0}, {0.001});
      EXPECT_EQ(map.finest_texel_m, 0.001);
      // At 85 degrees the upper one stands over 57 mm less of the lower one.
      for_places(lit, 0, random, 0.15,
                 [&](Vec3d p, Vec3d normal) { ASSERT_EQ(lit.visible(map, p, normal), 0.0f); });
      for_places(lit, 1, random, 0,
                 [&](Vec3d p, Vec3d normal) { ASSERT_EQ(lit.visible(map, p, normal), 1.0f); });
    }
}

// Leaves of a few centimetres that stand all ways.
Scene thicket(std::uint64_t seed, int leaves) {
  Random random{seed};
  Scene scene = ground_of(1);
  Mesh mesh;
  mesh.material = 0;
  for (int t = 0; t < leaves; ++t) {
    const Vec3d centre{random.uniform(-0.9, 0.9), random.uniform(0.05, 0.6),
                       random.uniform(-0.9, 0.9)};
    for (int c = 0; c < 3; ++c)
      mesh.positions.push_back(to_float(centre + random.direction() * 0.06));
    const auto first = static_cast<std::uint32_t>(3 * t);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  add_instance(scene, add_mesh(scene, std::move(mesh)));
  return scene;
}

// Points are wrong within about a texel of an edge's shadow, so that errors fall with the texel (by
// less where leaves are no wider than some texels); and they are of both signs, so that the mean is
// closer: to 0.7 %, of which 0.1 % is the standard error of so many points.
TEST(SunMap, ErrorsFallWithTheTexel) {
  constexpr int leaves = 1500, points = 60000;
  const SunScene lit(thicket(13, leaves));
  const Vec3d sun = from_azimuth_elevation(0.3, 50 * degree);
  double wrong_before = 1;
  for (const double texel : {0.02, 0.01, 0.005}) {
    SCOPED_TRACE(texel);
    Random random{14};
    const SunMapData map = lit.map(sun, {texel});
    double wrong = 0, mean = 0, mean_exact = 0;
    for (int k = 0; k < points; ++k) {
      const Place place = place_on(lit.scene.meshes[1], random.index(leaves), random);
      const double exact = lit.sees_sun(place.position, place.normal, sun) ? 1 : 0;
      const auto seen = static_cast<double>(lit.visible(map, place.position, place.normal));
      wrong += std::fabs(seen - exact) / points;
      mean += seen / points;
      mean_exact += exact / points;
    }
    EXPECT_NEAR(mean, mean_exact, 0.007 * mean_exact);
    EXPECT_LT(wrong, 0.7 * wrong_before);
    wrong_before = wrong;
  }
}

// The ground of a kilometre, and something small on it: that gets the fine texels.
TEST(SunMap, MemoryGoesWhereTrianglesAre) {
  Scene scene = thicket(15, 1500);
  add_quad(scene, {400, -0.01, -300}, {500, 0, 0}, {0, 0, -500}, 0);
  const SunScene lit(std::move(scene));
  const Vec3d sun = from_azimuth_elevation(0.3, 50 * degree);
  for (const std::size_t most_bytes : {64 * mib, 4 * mib, mib / 4}) {
    SCOPED_TRACE(most_bytes);
    const SunMapData map = lit.map(sun, {0, most_bytes});
    EXPECT_LE(map.bytes(), most_bytes);
    EXPECT_GT(map.coarsest_texel_m, 15 * map.finest_texel_m);
    const auto texel_at = [&](Vec3d p) {
      const Vec3 at = to_float(p - lit.placement.origin_m);
      return map.view.pages[find_on_sun_map(map.view, vector_of(at)).page].texel_m;
    };
    EXPECT_EQ(texel_at({0, 0.3, 0}), static_cast<float>(map.finest_texel_m));
    EXPECT_GT(texel_at({700, 0, -500}), 15 * static_cast<float>(map.finest_texel_m));
    // Whatever the texels, and across all edges of pages, what nothing shades is lit.
    Random random{16};
    for (int k = 0; k < 5000; ++k) {
      const Vec3d p{random.uniform(-100, 900), -0.01, random.uniform(-800, 200)};
      if (std::hypot(p.x, p.z) < 2 + 8 * map.coarsest_texel_m) continue;
      ASSERT_EQ(lit.visible(map, p, {0, 1, 0}), 1.0f) << p.x << ' ' << p.z;
    }
  }
  EXPECT_LE(lit.map(sun, {0, 0}).bytes(), sizeof(SunTile) + sizeof(SunPage));
  EXPECT_EQ(lit.map(sun, {1, 64 * mib}).finest_texel_m, 1);
}

TEST(SunMap, CutOutsAndBackFacesShadeAsTheyAreSeen) {
  Scene scene = ground_of(2);
  Material leaf;
  leaf.alpha_mode = AlphaMode::mask;
  leaf.double_sided = true;
  leaf.base_color_texture.texture =
      add_texture(scene,
                  make_image(2, 1,
                             [](int column, int) {
                               return Vec4{1, 1, 1, column == 0 ? 1.0f : 0};
                             }),
                  Texture{0, Wrap::clamp_to_edge, Wrap::clamp_to_edge, Filter::nearest});
  Material one_side;
  one_side.double_sided = false;
  const Vec3d x{0.25, 0, 0}, z{0, 0, -0.25};
  add_quad(scene, {-1, 1, 0}, x, z, add_material(scene, leaf));
  const int plain = add_material(scene, one_side);
  add_quad(scene, {0, 1, 0}, x, z, plain);         // its front to the sun
  add_quad(scene, {1, 1, 0}, x * -1.0, z, plain);  // its back
  const SunScene lit(std::move(scene));
  const SunMapData map = lit.map({0, 1, 0}, {0.01});
  EXPECT_TRUE(may_have_sun_map(lit.shading->view));
  const auto below = [&](double at) { return lit.visible(map, {at, 0, 0}, {0, 1, 0}); };
  EXPECT_EQ(below(-1.1), 0.0f);  // where the leaf is
  EXPECT_EQ(below(-0.9), 1.0f);
  EXPECT_EQ(below(0), 0.0f);
  EXPECT_EQ(below(1), 1.0f);
}

TEST(SunMap, NotWhereLightPassesInPart) {
  Scene scene = ground_of(1);
  Material veil;
  veil.alpha_mode = AlphaMode::blend;
  add_quad(scene, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}, add_material(scene, veil));
  EXPECT_FALSE(may_have_sun_map(make_shading_data(scene)->view));
}

TEST(SunMap, OfNothingAllIsLit) {
  const SunScene lit{Scene{}};
  const SunMapData map = lit.map({0, 1, 0});
  for (const double x : {0.0, 1e-3, -1.0, 1e6})
    EXPECT_EQ(lit.visible(map, {x, 0, x}, {0, 1, 0}), 1);
}

// As many lanes at once as there are, and one: the same bits; also of places that are outside, or
// nowhere.
TEST(SunMap, TheSameBitsInAnyNumberOfLanes) {
  const SunScene lit(thicket(17, 500));
  const SunMapData map = lit.map(from_azimuth_elevation(2, 0.5), {0.01});
  Random random{18};
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const float strange[] = {nan, INFINITY, -INFINITY, 1e30f, -1e30f, 1e-40f};
  int between = 0;
  for (int k = 0; k < 2000; ++k) {
    HitGeometry<Lanes<16, lane_width>> many;
    HitGeometry<Lanes<16, 1>> one;
    const double spread = k % 4 == 0 ? 10 : 0.6;
    for (int l = 0; l < 16; ++l) {
      const Vec3d normal = random.direction() * (random.index(10) == 0 ? 0.0 : 1.0);
      const float n[3] = {static_cast<float>(normal.x), static_cast<float>(normal.y),
                          static_cast<float>(normal.z)};
      for (int r = 0; r < 3; ++r) {
        one.position[r][l] = many.position[r][l] =
            random.index(50) == 0 ? strange[random.index(6)]
                                  : static_cast<float>(random.uniform(-spread, spread));
        one.normal[r][l] = many.normal[r][l] = n[r];
      }
    }
    alignas(64) float of_many[16], of_one[16];
    eval_sun_map(map.view, many, of_many);
    eval_sun_map(map.view, one, of_one);
    ASSERT_EQ(std::memcmp(of_many, of_one, sizeof of_one), 0);
    for (const float visible : of_one) {
      ASSERT_TRUE(visible >= 0 && visible <= 1) << visible;
      between += visible > 0 && visible < 1;
    }
  }
  EXPECT_GT(between, 100);
}

TEST(SunMap, TheSameBitsFromAnyNumberOfThreads) {
  const SunScene lit(thicket(19, 800));
  std::vector<SunMapData> maps;
  for (const int threads : {1, 2, 5})
    run_in_arena(*make_thread_arena(threads), [&] {
      maps.push_back(lit.map(from_azimuth_elevation(2, 0.5), {0.002, 2 * mib}));
    });
  for (const SunMapData& map : maps) {
    ASSERT_EQ(map.bytes(), maps[0].bytes());
    EXPECT_EQ(
        std::memcmp(map.tiles.data(), maps[0].tiles.data(), map.tiles.size() * sizeof(SunTile)), 0);
    EXPECT_EQ(
        std::memcmp(map.pages.data(), maps[0].pages.data(), map.pages.size() * sizeof(SunPage)), 0);
  }
}

TEST(SunMap, TellsItsProgressAndCanBeEnded) {
  const SunScene lit(thicket(20, 100));
  WorkState state;
  lit.map({0, 1, 0}, {}, {&state, 0.25, 0.75});
  EXPECT_DOUBLE_EQ(state.fraction, 0.75);
  state.cancelled = true;
  EXPECT_THROW(lit.map({0, 1, 0}, {}, {&state}), Cancelled);
}

// What rays are asked for besides: only between their ends.
TEST(SunMap, ClosestHitsLieBetweenTheEndsOfRays) {
  const SunScene lit(sheets(0, 0, {0, 1, 2}, {0, 0, 0}, 1));
  RayPacket<16> rays{};
  clear<Lanes<16, 1>>(rays);
  for (int l = 0; l < 16; ++l) {
    rays.origin[0][l] = rays.origin[2][l] = 0.1f;
    rays.origin[1][l] = 3;
    rays.direction[1][l] = -1;
    rays.t_near_m[l] = 0.25f + 0.5f * static_cast<float>(l % 8);  // to 3.75
    rays.t_far_m[l] = l < 8 ? INFINITY : 2.5f;
  }
  lit.launches.closest({&rays, 1}, lit.acceleration.tracer.get());
  for (int l = 0; l < 16; ++l) {
    SCOPED_TRACE(l);
    const float next = std::ceil(0.25f + 0.5f * static_cast<float>(l % 8));
    const bool is_met = next <= (l < 8 ? 3.0f : 2.5f);
    ASSERT_EQ(rays.geometry[l] != none, is_met);
    if (is_met) {
      EXPECT_NEAR(rays.t_far_m[l], next, 1e-5f);
    }
  }
}

}  // namespace
}  // namespace omma::test
