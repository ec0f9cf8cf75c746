// Air between surfaces against L = T L_0 + (1 - T) J: on the way to the eye by distance, azimuth and
// band, from lamps and between surfaces, past panes, and in a white furnace.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "light/check_light.h"
#include "light_maps.h"
#include "world_tests.h"

namespace omma::test {
namespace {

// m^-1, of three bands: fog, haze, clear.
const std::vector<double> extinction = {0.4, 0.05, 0};
// Single precision, some roundings and those of exp.
constexpr double rounding = 3e-6;

Material matter(float reflectance) {
  Material material;
  material.specular = 0;
  material.double_sided = true;
  material.base_color = {1, 1, 1, 1};
  const auto r = static_cast<double>(reflectance);
  material.reflectance = {{200, 800}, {r, r}};
  material.spectral_luminance = 1;
  return material;
}

Material shining(double radiance) {
  Material material = matter(0);
  material.emissive = {1, 1, 1};
  material.emission = {{200, 800}, {radiance, radiance}};
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

// The sky at the horizon by azimuth, and by band.
double horizon(double azimuth_rad, int band) {
  return 1 + 0.5 * std::cos(azimuth_rad) + band;
}

Lighting in_air(double sky, int depth, bool is_clear = false) {
  Lighting lighting;
  lighting.light.bands = narrow_bands(3);
  lighting.light.unit = LightUnit::watts;
  if (!is_clear) lighting.light.extinction_per_m = extinction;
  lighting.depth = depth;
  if (sky > 0)
    lighting.light.sky = made_sky(4, 2, 1, 3, [&](int, int, int, int, int) { return sky; });
  return lighting;
}

World made_world(Scene scene, const Lighting& lighting) {
  return World(std::make_shared<const Scene>(std::move(scene)),
               {.backend = backend_under_test, .lighting = lighting});
}

// What 8 scrambles of so many rays bring.
Result rendered(const World& world, const Eye& eye, int rays) {
  return render(Renderer(world, eye, {.sampling = Fixed{rays}}), std::vector<Mat4>(1), true);
}

Eye ahead(int count = 1) {
  return make_eye(std::vector<Vec3d>(static_cast<std::size_t>(count), Vec3d{0, 0, -1}), 0);
}

// A level ray's, of each band.
template <typename Expected>
void expect_ahead(const World& world, const Expected& expected) {
  const std::vector<float> found = seen(world, ahead(20));
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double wanted = expected(extinction[i % 3]);
    EXPECT_NEAR(static_cast<double>(found[i]), wanted, rounding * wanted) << "band " << i % 3;
  }
}

// Koschmieder: of black, white and middling things the contrast to the horizon falls by exp(-σ d).
TEST(Air, TakesContrastWithDistance) {
  for (const double distance : {0.5, 3.0, 20.0, 400.0})
    for (const double own : {0.0, 0.75, 4.0}) {
      Scene scene;
      add_wall(scene, distance, 10, shining(own));
      const double sky = 0.75;
      expect_ahead(made_world(scene, in_air(sky, 0)), [&](double sigma) {
        return sky + (own - sky) * std::exp(-sigma * distance);
      });
    }
}

TEST(Air, IsNotBeforeWhatIsAfar) {
  expect_ahead(made_world({}, in_air(0.75, 0)), [](double) { return 0.75; });
}

// Black all around, 2 m away at least: each ray has the horizon of its own azimuth, up and down.
TEST(Air, ShowsTheHorizonOfEachAzimuth) {
  Lighting lighting = in_air(0, 0);
  lighting.light.sky = made_sky(72, 5, 1, 3, [&](int, int row, int column, int, int band) {
    return row == 0 ? horizon(2 * pi * column / 72, band) : 100.0;
  });
  Scene scene;
  scene.materials = {matter(0)};
  scene.meshes = {cube_seen_from_inside(2, 0)};
  scene.instances.emplace_back().mesh = 0;
  const World world = made_world(scene, lighting);
  const std::vector<Vec3d> directions = sphere_directions(500);
  const std::vector<float> found = seen(world, make_eye(directions, 0));
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const Vec3d& d = directions[i];
    const double distance = 2 / std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
    for (int b = 0; b < 3; ++b) {
      const double j = horizon(std::atan2(d.x, -d.z), b);
      const double sigma = extinction[static_cast<std::size_t>(b)];
      // Between columns the map is linear: within (5 deg)^2 / 8 of a cosine of height 0.5.
      EXPECT_NEAR(static_cast<double>(found[3 * i + static_cast<std::size_t>(b)]),
                  j * (1 - std::exp(-sigma * distance)), 5e-4);
    }
  }
}

// In deep water black things fade to what lies below in their own direction, and above the horizon
// still to the horizon.
TEST(Air, ShowsWhatIsBelowWhereItIsBottomless) {
  Lighting lighting = in_air(0, 0);
  lighting.light.bottomless = true;
  // Each half by its row and band: nodes every 22.5 degrees, linear between.
  const auto node = [](int half, int row, int band) {
    return row == 0 ? 2.0 : half == 0 ? 100.0 : 2.0 - 0.3 * row + band;
  };
  lighting.light.sky = made_sky(
      8, 5, 1, 3, [&](int half, int row, int, int, int band) { return node(half, row, band); });
  Scene scene;
  scene.materials = {matter(0)};
  scene.meshes = {cube_seen_from_inside(2, 0)};
  scene.instances.emplace_back().mesh = 0;
  const World world = made_world(scene, lighting);
  const std::vector<Vec3d> directions = sphere_directions(500);
  const std::vector<float> found = seen(world, make_eye(directions, 0));
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const Vec3d& d = directions[i];
    const double distance = 2 / std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
    const double at = std::asin(std::min(1.0, std::max(0.0, -d.y))) / (pi / 8);
    const int row = std::min(3, static_cast<int>(at));
    for (int b = 0; b < 3; ++b) {
      const double j = node(1, row, b) + (at - row) * (node(1, row + 1, b) - node(1, row, b));
      const double sigma = extinction[static_cast<std::size_t>(b)];
      const double wanted = j * (1 - std::exp(-sigma * distance));
      // Angles are found within 2e-7 rad, and single precision.
      EXPECT_NEAR(static_cast<double>(found[3 * i + static_cast<std::size_t>(b)]), wanted, 1e-5);
    }
  }
}

// A lamp of 1 W sr^-1 beside the eye lights a white wall: rho I / (pi d^2), there and back.
TEST(Air, DimsLamps) {
  Scene scene;
  add_wall(scene, 2, 20, matter(1));
  PunctualLight lamp;
  lamp.spectrum = {{200, 800}, {1, 1}};
  scene.lights = {lamp};
  expect_ahead(made_world(scene, in_air(0, 1)),
               [](double sigma) { return std::exp(-4 * sigma) / (4 * pi); });
}

// From a shining square, found by light samples and by paths, to a wall and to the eye. Small
// beside its distance: E = L A / d^2, to A / d^2.
TEST(Air, DimsWhatShinesOnSurfaces) {
  const auto response = [](bool is_clear) {
    Scene scene;
    add_wall(scene, 2, 20, matter(1));
    add_wall(scene, -2, 0.02, shining(1000));  // behind the eye
    const World world = made_world(scene, in_air(0, 1, is_clear));
    return rendered(world, ahead(), 1024).response;
  };
  const std::vector<float> found = response(false), clear = response(true);
  for (std::size_t b = 0; b < 3; ++b) {
    const double left = std::exp(-extinction[b] * (2 + 4));
    // Both are of the same paths but for the air, which is known to the square's size over 8 d.
    EXPECT_NEAR(static_cast<double>(found[b] / clear[b]), left, 2e-3 * left);
  }
}

// Panes that cover nothing are not there, at any distance, before the sky and before a wall.
TEST(Air, IsNotChangedByPanesThatCoverNothing) {
  Material pane = shining(1);
  pane.base_color.w = 0;
  pane.alpha_mode = AlphaMode::blend;
  for (const bool has_wall : {false, true}) {
    Scene scene;
    add_wall(scene, 1, 10, pane);
    add_wall(scene, 3, 10, pane);
    if (has_wall) add_wall(scene, 4, 10, shining(2));
    expect_ahead(made_world(scene, in_air(0.75, 2)), [&](double sigma) {
      return has_wall ? 0.75 + 1.25 * std::exp(-4 * sigma) : 0.75;
    });
  }
}

// Of glass that lets tau straight through, at 1 m: what is before it is seen whole, what lies
// behind by tau of itself,
//
//   (1 - T_1) J + tau (L - (1 - T_1) J),
//
// L what would be seen without the pane; glass of no boundary gives no light back.
TEST(Air, IsSeenBeforeGlassAndBehindIt) {
  const double tau = 0.5, sky = 0.75;
  Material glass = matter(static_cast<float>(tau));
  glass.transmission = 1;
  for (const bool has_wall : {false, true}) {
    Scene scene;
    add_wall(scene, 1, 10, glass);
    if (has_wall) add_wall(scene, 4, 10, shining(2));
    const World world = made_world(scene, in_air(sky, 4));
    const Result result = rendered(world, ahead(), 1024);
    for (std::size_t b = 0; b < 3; ++b) {
      const double sigma = extinction[b];
      const double behind = has_wall ? sky + (2 - sky) * std::exp(-4 * sigma) : sky;
      const double before = (1 - std::exp(-sigma)) * sky;
      EXPECT_NEAR(static_cast<double>(result.response[b]), before + tau * (behind - before),
                  1e-5);
    }
  }
}

// Where all is white and the sky is even, all shows the sky's radiance, through any air: what it
// takes it gives back. Balls on a floor and a pane of glass, to the standard error.
TEST(Air, KeepsAWhiteFurnace) {
  Scene scene;
  add_wall(scene, 3, 4, matter(1));
  add_wall(scene, -2, 1.5, matter(1));
  Material glass = matter(1);
  glass.transmission = 1;
  add_wall(scene, 1, 0.5, glass);
  // So deep that no path ends before its time: at most four of 1e4 scatter so often.
  const World world = made_world(scene, in_air(0.75, 60));
  const Result result = rendered(world, make_eye(sphere_directions(60), 0.3), 128);
  double chi = 0;
  std::size_t noisy = 0;
  for (std::size_t i = 0; i < result.response.size(); ++i) {
    const double error = static_cast<double>(result.standard_error[i]);
    const double off = static_cast<double>(result.response[i]) - 0.75;
    EXPECT_NEAR(off, 0, 6 * error + 1e-5);
    if (error < 1e-5) continue;
    chi += off * off / (error * error);
    ++noisy;
  }
  ASSERT_GT(noisy, 20u);
  // Of 8 replicates: Student's t of 7 degrees has a variance of 1.4; five times its spread here.
  const double mean = chi / static_cast<double>(noisy);
  EXPECT_LT(mean, 1.4 * (1 + 5 * std::sqrt(4.0 / static_cast<double>(noisy))));
}

TEST(Air, IsChecked) {
  const auto refused = [](std::vector<double> values) {
    Light light = in_air(1, 0).light;
    light.extinction_per_m = std::move(values);
    EXPECT_THROW(validate_light(light, 0), Error);
  };
  refused({1, 1});
  refused({1, -1e-9, 1});
  refused({1, std::numeric_limits<double>::quiet_NaN(), 1});
  refused({1, 1, 1001});
}

}  // namespace
}  // namespace omma::test
