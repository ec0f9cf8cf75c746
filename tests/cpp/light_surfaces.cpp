// Surfaces that shine: closed forms of how much of them is seen, by sampling.
#include <gtest/gtest.h>

#include "light_scenes.h"

namespace omma {
namespace {

using namespace test;

struct Estimate {
  double mean = 0, error = 0;
};

// Irradiance over pi at places that place(random) gives, facing `normal`.
template <typename Place>
Estimate form_factor(const LitScene& lit, Vec3d normal, int samples, std::uint64_t seed,
                     const Place& place) {
  Random random{seed};
  double sum = 0, squares = 0;
  for (int i = 0; i < samples; ++i) {
    const LightSample sample = light_at(lit, {to_float(place(random)), {}}, random);
    if (!(sample.pdf > 0)) continue;
    const double cosine = std::max(dot(to_double(sample.direction), normal), 0.0);
    const double x = radiance_of(lit, sample) * cosine / pi / static_cast<double>(sample.pdf);
    sum += x;
    squares += x * x;
  }
  const double mean = sum / samples;
  return {mean, std::sqrt((squares / samples - mean * mean) / samples)};
}

TEST(ShiningSquare, AtADistanceOfItsSide) {
  const auto lit = lit_scene(shining_square(), watts_alone());
  const Estimate found = form_factor(*lit, {0, 0, -1}, 1000000, 1, [](Random& random) {
    return Vec3d{random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 1};
  });
  EXPECT_LT(found.error / found.mean, 1e-3);
  EXPECT_NEAR(found.mean, 0.19982, 3 * found.error + 5e-6);
}

TEST(ShiningSquare, WithACommonEdge) {
  const auto lit = lit_scene(shining_square(), watts_alone());
  const Estimate found = form_factor(*lit, {0, 1, 0}, 2000000, 2, [](Random& random) {
    return Vec3d{random.uniform(-0.5, 0.5), -0.5, random.uniform(0, 1)};
  });
  EXPECT_LT(found.error / found.mean, 1e-3);
  EXPECT_NEAR(found.mean, 0.20004, 3 * found.error + 5e-6);
}

// A rectangle of sides a, b, parallel to a small surface that faces its corner at distance c
// (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-4).
double corner_factor(double a, double b, double c) {
  const double x = a / c, y = b / c;
  return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
          y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
         (2 * pi);
}

TEST(ShiningSquare, WhereItIsMovedTurnedScaledAndMirrored) {
  Random random{3};
  const auto lit = lit_scene(shining_square(), watts_alone());
  for (const double mirror : {1.0, -1.0}) {
    // 3 m by 0.4 m, and small enough that places are sampled by area.
    for (const double size : {1.0, 0.01}) {
      const Mat4 turn = random_rotation(random);
      const Vec3d middle{2, -1, 4};
      Mat4 placed = translation(middle) * turn * scaling({3 * size * mirror, 0.4 * size, 2});
      lit->place({placed});
      // Before its corner; mirrored, the front stays the side towards +z of its own frame.
      const double c = 0.7;
      const Vec3d front = normalize(transform_vector(turn, {0, 0, 1}));
      const Vec3d at = transform_point(placed, {-0.5, -0.5, 0}) + front * c;
      const auto place = [&](Random&) { return at; };
      const Estimate found = form_factor(*lit, front * -1.0, 400000, 4, place);
      const double exact = corner_factor(3 * size, 0.4 * size, c);
      EXPECT_LT(found.error / found.mean, 2e-3);
      // Corners 5 m from the origin are rounded by 2.4e-7 m, the short side is 0.4 m or 4 mm.
      const double rounding = 2.4e-7 / (0.4 * size);
      EXPECT_NEAR(found.mean / exact, 1, 3 * found.error / exact + rounding)
          << mirror << " " << size;
      // Nothing behind.
      const Vec3d behind = at - front * (2 * c);
      EXPECT_EQ(form_factor(*lit, front, 1000, 5, [&](Random&) { return behind; }).mean, 0);
    }
  }
}

// Of a square its left half black, its right half at 2.
Scene half_shining_square() {
  Scene scene = shining_square();
  Image image;
  image.width = 64, image.height = 64;
  for (int i = 0; i < 64 * 64; ++i) {
    const float x = i % 64 < 32 ? 0.0f : 2.0f;
    image.rgba_linear.insert(image.rgba_linear.end(), {x, x, x, 1});
  }
  Texture texture;
  texture.image = 0;
  scene.images = {image};
  scene.textures = {texture};
  scene.materials[0].emissive_texture.texture = 0;
  return scene;
}

TEST(Subtriangles, AreNumberedAsTheyAreFound) {
  Random random{2};
  for (int divisions = 1; divisions <= 9; ++divisions) {
    for (int number = 0; number < divisions * divisions; ++number) {
      const Subtriangle sub = subtriangle(number, divisions);
      EXPECT_EQ(subtriangle_at(sub.u + sub.scale / 3, sub.v + sub.scale / 3, divisions), number);
    }
    for (int i = 0; i < 1000; ++i) {
      double u = random.uniform(), v = random.uniform();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const auto [x, y, scale] = subtriangle(
          subtriangle_at(static_cast<float>(u), static_cast<float>(v), divisions), divisions);
      const double a = (u - to_double({x, 0, 0}).x) / static_cast<double>(scale);
      const double b = (v - to_double({y, 0, 0}).x) / static_cast<double>(scale);
      EXPECT_GT(std::min({a, b, 1 - a - b}), -1e-5);
    }
  }
}

class SquareThatRaysMeet : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(ByTexture, SquareThatRaysMeet, testing::Bool());

TEST_P(SquareThatRaysMeet, DensityIsThatOfSampling) {
  Scene scene = GetParam() ? half_shining_square() : shining_square();
  scene.materials[0].double_sided = true;
  Instance second = scene.instances[0];
  second.world_from_mesh = translation({0, 3, 0}) * scaling({0.2, 0.3, -1});
  scene.instances.push_back(second);
  PunctualLight lamp;
  lamp.world_from_light = translation({5, 0, 0});
  scene.lights = {lamp};
  Light light = watts_alone();
  light.sky = made_sky(4, 2, 1, 1, [](int, int, int, int, int) { return 1; });
  const auto lit = lit_scene(scene, light);
  const LightView& view = lit->light->view;
  Random random{6};
  int of_surface[2] = {}, of_lamp = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 position = to_float(random.direction() * random.uniform(0.3, 6));
    const Vec3 normal = i % 2 == 0 ? Vec3{} : to_float(random.direction());
    const LightKinds kinds = choose_kinds(view, {position, normal});
    EXPECT_NEAR(kinds.far + kinds.lamp + kinds.surface, 1, 1e-6);
    EXPECT_GT(kinds.far, 0.06);
    const LightSample sample = light_at(*lit, {position, normal}, random);
    if (sample.kind == LightKind::dark) continue;
    if (sample.kind == LightKind::lamp) {
      ++of_lamp;
      EXPECT_TRUE(sample.is_delta);
      EXPECT_FLOAT_EQ(sample.pdf, kinds.lamp);
    } else {
      ASSERT_EQ(sample.kind, LightKind::surface);
      ++of_surface[sample.index];
      if (!(sample.pdf > 0)) continue;
      EmissiveView whole = view.emissive[view.emissive_of_instance[sample.index]];
      EXPECT_EQ(whole.divisions > 1, GetParam());
      // Beside the edge of a subtriangle rounding may find the next one.
      const Subtriangle sub =
          subtriangle(subtriangle_at(sample.u, sample.v, whole.divisions), whole.divisions);
      const float a = (sample.u - sub.u) / sub.scale, b = (sample.v - sub.v) / sub.scale;
      if (GetParam() && std::min({a, b, 1 - a - b}) < 1e-4f) continue;
      EXPECT_NEAR(
          kinds.surface *
              met_light_pdf(lit->view, view,
                            {sample.index, sample.triangle, sample.distance_m, sample.u, sample.v},
                            {position, normal}, sample.direction) /
              sample.pdf,
          1, 1e-5);
      // The place on the triangle is where the direction leads.
      whole.divisions = 1;
      const LightTriangle seen = see_triangle(lit->view, whole, sample.triangle, position);
      const Vec3 at = seen.corner[0] * (1 - sample.u - sample.v) + seen.corner[1] * sample.u +
                      seen.corner[2] * sample.v;
      const Vec3 off = at - sample.direction * sample.distance_m;
      EXPECT_LT(std::sqrt(dot(off, off)), 1e-4f * sample.distance_m);
    }
  }
  EXPECT_GT(of_lamp, 500);
  EXPECT_GT(of_surface[0], of_surface[1]);
  EXPECT_GT(of_surface[1], 0);
}

// As much as all at 1 from afar, and places count by what they send: chosen evenly, the black half
// would make the estimate scatter by its mean.
TEST(ShiningSquare, TexturesAreReadWhereTheyAreSampled) {
  const auto lit = lit_scene(half_shining_square(), watts_alone());
  const Estimate found = form_factor(*lit, {0, 0, -1}, 1000000, 7, [](Random&) {
    return Vec3d{0, 0, 20};
  });
  const double exact = 4 * corner_factor(0.5, 0.5, 20);
  EXPECT_NEAR(found.mean / exact, 1, 3 * found.error / exact + 1e-5);
  EXPECT_LT(found.error * 1000, 0.4 * exact);
}

TEST(ShiningSquare, CutOutsAndCoverageCount) {
  for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
    Scene scene = shining_square();
    scene.materials[0].base_color.w = 0.25f;
    scene.materials[0].alpha_mode = mode;
    const auto lit = lit_scene(scene, watts_alone());
    const Estimate found = form_factor(*lit, {0, 0, -1}, 20000, 8, [](Random&) {
      return Vec3d{0, 0, 2};
    });
    const double whole = 4 * corner_factor(0.5, 0.5, 2);
    EXPECT_NEAR(found.mean / whole, mode == AlphaMode::mask ? 0 : 0.25, 3 * found.error / whole);
  }
}

TEST(Emission, CandelasAndSpectra) {
  Light light = watts_alone();
  Material material;
  EXPECT_TRUE(make_emission_matrix(light, material).empty());
  material.emissive = {2, 0, 0};
  material.unlit = true;
  EXPECT_TRUE(make_emission_matrix(light, material).empty());
  material.unlit = false;
  // 500 nm is green and blue to equal parts, about.
  const auto candelas = make_emission_matrix(light, material);
  ASSERT_EQ(candelas.size(), 3u);
  EXPECT_EQ(candelas[0], 0);
  EXPECT_GT(candelas[1], 0);
  material.emission = {{400, 700}, {3, 3}};
  const auto spectrum = make_emission_matrix(light, material);
  EXPECT_NEAR(spectrum[0] + spectrum[1] + spectrum[2], 3, 1e-6);
  EXPECT_NEAR(spectrum[1], 3 * 0.7152, 1e-6);
  light.unit = LightUnit::photons;
  EXPECT_NEAR(make_emission_matrix(light, material)[1] / (3 * 0.7152 * 500 * 5.0341166e15), 1,
              1e-6);
}

}  // namespace
}  // namespace omma
