// Haze against exp(-sigma d): on what surfaces send to the eye, from lamps and shining surfaces to
// others, past panes, and where there is no light.
#include <gtest/gtest.h>

#include <cmath>

#include "light_maps.h"
#include "world_tests.h"

namespace omma::test {
namespace {

constexpr double sigma = 0.4;
// Single precision, some roundings and those of exp.
constexpr double rounding = 2e-6;

Material matter(float reflectance) {
  Material material;
  material.specular = 0;
  material.double_sided = true;
  material.base_color = {reflectance, reflectance, reflectance, 1};
  material.reflectance = {{200, 800}, {1, 1}};
  material.reflectance.value = {static_cast<double>(reflectance), static_cast<double>(reflectance)};
  material.spectral_luminance = 1;
  return material;
}

Material shining(float radiance) {
  Material material = matter(0);
  material.emissive = {1, 1, 1};
  material.emission = {{200, 800}, {static_cast<double>(radiance), static_cast<double>(radiance)}};
  return material;
}

// A square across -z, so far away.
void add_wall(Scene& scene, double distance_m, double half_m, const Material& material) {
  Mesh mesh;
  mesh.material = static_cast<int>(scene.materials.size());
  const auto z = static_cast<float>(-distance_m), a = static_cast<float>(half_m);
  mesh.positions = {{-a, -a, z}, {a, -a, z}, {a, a, z}, {-a, a, z}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.materials.push_back(material);
  Instance instance;
  instance.mesh = static_cast<int>(scene.meshes.size());
  scene.meshes.push_back(mesh);
  scene.instances.push_back(instance);
}

Scene hazy(double extinction_per_m = sigma) {
  Scene scene;
  scene.extinction_per_m = extinction_per_m;
  return scene;
}

World lit(Scene scene, double sky = 0, int depth = 0) {
  Lighting lighting;
  lighting.light.bands = narrow_bands(3);
  lighting.light.unit = LightUnit::watts;
  lighting.depth = depth;
  if (sky > 0)
    lighting.light.sky = made_sky(4, 2, 1, 3, [&](int, int, int, int, int) { return sky; });
  return World(std::make_shared<const Scene>(std::move(scene)),
               {.backend = backend_under_test, .lighting = lighting});
}

World unlit(Scene scene) {
  return World(std::make_shared<const Scene>(std::move(scene)), {.backend = backend_under_test});
}

Eye ahead(int count = 1) {
  return make_eye(std::vector<Vec3d>(static_cast<std::size_t>(count), Vec3d{0, 0, -1}), 0);
}

void expect_each(const World& world, double expected) {
  for (const float found : seen(world, ahead(20)))
    EXPECT_NEAR(static_cast<double>(found), expected, rounding * expected);
}

TEST(Haze, OnTheWayToTheEye) {
  for (const double distance : {0.5, 3.0, 20.0}) {
    Scene scene = hazy();
    add_wall(scene, distance, 10, shining(2));
    expect_each(lit(scene), 2 * std::exp(-sigma * distance));
  }
}

TEST(Haze, NotBeforeWhatIsAfar) {
  expect_each(lit(hazy(), 0.75), 0.75);
  Scene scene = hazy();
  scene.background.color = {0.25f, 0.25f, 0.25f};
  expect_each(unlit(scene), 0.25);
}

TEST(Haze, OfUnlitColours) {
  Scene scene = hazy();
  Material material;
  material.base_color = {0.5f, 0.5f, 0.5f, 1};
  material.double_sided = true;
  add_wall(scene, 3, 10, material);
  expect_each(unlit(scene), 0.5 * std::exp(-3 * sigma));
}

// A lamp of 1 W sr^-1 beside the eye lights a white wall: rho I / (pi d^2), there and back.
TEST(Haze, FromALampAndBack) {
  Scene scene = hazy();
  add_wall(scene, 2, 20, matter(1));
  PunctualLight lamp;
  lamp.spectrum = {{200, 800}, {1, 1}};
  scene.lights = {lamp};
  expect_each(lit(scene, 0, 1), std::exp(-4 * sigma) / (4 * pi));
}

// Behind a pane that covers half, and in front of it: each by its own way, the sky by none.
TEST(Haze, PastPanes) {
  Material pane = shining(1);
  pane.base_color.w = 0.5f;
  pane.alpha_mode = AlphaMode::blend;
  const double far_sky = 0.75;
  for (const bool has_wall : {false, true}) {
    Scene scene = hazy();
    add_wall(scene, 1, 10, pane);
    add_wall(scene, 2, 10, pane);
    if (has_wall) add_wall(scene, 4, 10, shining(2));
    const double behind = has_wall ? 2 * std::exp(-4 * sigma) : far_sky;
    const double expected = 0.5 * std::exp(-sigma) + 0.25 * std::exp(-2 * sigma) + 0.25 * behind;
    const World world = lit(scene, far_sky);
    const Result result =
        render(Renderer(world, ahead(), {.sampling = Fixed{1 << 16}}), std::vector<Mat4>(1));
    // Which surface a path meets is chosen by chance: a spread of at most 1 by 2^16 paths.
    EXPECT_NEAR(static_cast<double>(result.response[0]), expected, 3.0 / 256);
  }
  Scene scene = hazy();
  Material sheet;
  sheet.base_color = {1, 1, 1, 0.5f};
  sheet.alpha_mode = AlphaMode::blend;
  sheet.double_sided = true;
  add_wall(scene, 1, 10, sheet);
  add_wall(scene, 2, 10, sheet);
  scene.background.color = {0.75f, 0.75f, 0.75f};
  expect_each(unlit(scene), 0.5 * std::exp(-sigma) + 0.25 * std::exp(-2 * sigma) + 0.25 * 0.75);
}

// From a shining square, found by light samples and by paths, to a wall and to the eye. Small
// beside its distance: E = L A / d^2, to A / d^2.
TEST(Haze, BetweenSurfaces) {
  const auto response = [](double extinction) {
    Scene scene = hazy(extinction);
    add_wall(scene, 2, 20, matter(1));
    add_wall(scene, -2, 0.02, shining(1000));  // behind the eye
    const Result result = render(Renderer(lit(scene, 0, 1), ahead(), {.sampling = Fixed{4096}}),
                                 std::vector<Mat4>(1));
    return static_cast<double>(result.response[0]);
  };
  // Both are of the same paths but for the haze, which is known to the square's size over 8 d.
  EXPECT_NEAR(response(sigma) / response(0), std::exp(-sigma * (2 + 4)),
              2e-3 * std::exp(-6 * sigma));
}

TEST(Haze, IsCheckedAndTold) {
  EXPECT_THROW(validate_scene(hazy(-1)), Error);
  EXPECT_THROW(validate_scene(hazy(NAN)), Error);
  EXPECT_THROW(validate_scene(hazy(2e6)), Error);
  EXPECT_FALSE(hazy(0) == hazy(sigma));
}

}  // namespace
}  // namespace omma::test
