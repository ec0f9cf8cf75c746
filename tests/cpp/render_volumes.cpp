// Volumes that rays bend into, water and glass, against Snell, Fresnel, Beer and Lambert: what lies
// below a level surface and how it is polarised, the window that opens from below, the light that
// gets to the bottom, and white furnaces.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "light_maps.h"
#include "world_tests.h"

namespace omma::test {
namespace {

constexpr double water = 1.34;
// m^-1, of three bands, and as a spectrum.
const std::vector<double> absorption = {0, 0.7, 0.7};
const Spectrum absorption_per_m = {{490, 505, 505.001, 530}, {0, 0, 0.7, 0.7}};
// Of the tables of what boundaries reflect (specular_albedo.h).
constexpr double of_tables = 1e-3;

Material matter(double reflectance) {
  Material material;
  material.specular = 0;
  material.double_sided = true;
  material.reflectance = {{200, 800}, {reflectance, reflectance}};
  return material;
}

Material shining(double radiance) {
  Material material = matter(0);
  material.emissive = {1, 1, 1};
  material.emission = {{200, 800}, {radiance, radiance}};
  return material;
}

Material volume(double ior, bool absorbs = false) {
  Material material = matter(1);
  material.specular = 1;
  material.roughness = 0;
  material.ior = static_cast<float>(ior);
  material.transmission = 1;
  material.thickness_m = 1;
  if (absorbs) material.absorption_per_m = absorption_per_m;
  return material;
}

// A level square about (x, y, 0), seen from above.
void add_level(Scene& scene, double x, double y, double half_x, const Material& material) {
  constexpr double half_z = 50;
  add_quad(scene, {x, y, 0}, {half_x, 0, 0}, {0, 0, -half_z}, add_material(scene, material));
}

World made_world(Scene scene, double sky, int depth) {
  Lighting lighting;
  lighting.light.bands = narrow_bands(3);
  lighting.light.unit = LightUnit::watts;
  lighting.depth = depth;
  if (sky > 0)
    lighting.light.sky = made_sky(4, 2, 1, 3, [&](int, int, int, int, int) { return sky; });
  return World(std::make_shared<const Scene>(std::move(scene)),
               {.backend = backend_under_test, .lighting = lighting});
}

Eye looking(double theta_rad) {
  return make_eye({std::sin(theta_rad), -std::cos(theta_rad), 0}, 0.0);
}

Result rendered(const World& world, const Eye& eye, const Mat4& pose, int rays) {
  return render(Renderer(world, eye, {.sampling = Fixed{rays}}), std::vector<Mat4>{pose}, true);
}

// Reflectances of a boundary across the plane of incidence and in it (Born and Wolf 1.5.2).
struct Fresnel {
  double s, p;
  double through() const { return 1 - (s + p) / 2; }
};

Fresnel fresnel(double theta_rad, double ior) {
  const double c = std::cos(theta_rad), sine = std::sin(theta_rad) / ior;
  if (sine >= 1) return {1, 1};
  const double t = std::sqrt(1 - sine * sine);
  const double s = (c - ior * t) / (c + ior * t), p = (ior * c - t) / (ior * c + t);
  return {s * s, p * p};
}

// The part of light from all sides that a level surface lets in: 2 ∫ T(θ) cos θ sin θ dθ.
double let_in(double ior) {
  constexpr int steps = 20000;
  double sum = 0;
  for (int k = 0; k < steps; ++k) {
    const double theta = (k + 0.5) * pi / 2 / steps;
    sum += fresnel(theta, ior).through() * std::sin(2 * theta) * pi / 2 / steps;
  }
  return sum;
}

// The bottom shines from some place on: rays meet it where Snell says, to a millimetre.
TEST(Volumes, BendBySnell) {
  const double height = 1, depth = 2;
  for (const double theta : {0.0, 0.3, 0.8, 1.2, -0.6}) {
    const double below = std::asin(std::sin(theta) / water);
    const double x = height * std::tan(theta) + depth * std::tan(below);
    for (const double off : {-1e-3, 1e-3}) {
      Scene scene;
      add_level(scene, 0, 0, 50, volume(water));
      add_level(scene, x + off + 20, -depth, 20, shining(1));
      const Result found =
          rendered(made_world(scene, 0, 4), looking(theta), translation({0, height, 0}), 64);
      EXPECT_EQ(found.response[0] > 0.2f, off < 0) << theta;
    }
  }
}

// Facets of a rough boundary, seen straight on, slope by more than s with probability
// a^2 / (s^2 + a^2), a the square of the roughness, to all sides alike (Walter et al. 2007,
// equation 35); rays bend at each by its own angle. How many meet the bottom beyond x:
TEST(Volumes, BendAtTheFacetsOfWaves) {
  const double depth = 1, alpha = 0.2;
  const auto beyond = [&](double x) {
    constexpr int slopes = 4000, turns = 720;
    double sum = 0;
    for (int i = 0; i < slopes; ++i) {
      const double u = (i + 0.5) / slopes, slope = alpha * std::sqrt(u / (1 - u));
      const double tilt = std::atan(slope), turned = tilt - std::asin(std::sin(tilt) / water);
      for (int k = 0; k < turns; ++k)
        sum += depth * std::tan(turned) * std::cos(2 * pi * (k + 0.5) / turns) > x ? 1 : 0;
    }
    return sum / (slopes * turns);
  };
  Material rough = volume(water);
  rough.roughness = static_cast<float>(std::sqrt(alpha));
  const auto seen_from = [&](double x) {
    Scene scene;
    add_level(scene, 0, 0, 50, rough);
    add_level(scene, x + 20, -depth, 20, shining(1));
    return rendered(made_world(scene, 0, 4), looking(0), translation({0, 1, 0}), 1 << 14);
  };
  const double all = static_cast<double>(seen_from(-20).response[0]);
  for (const double x : {0.0, 0.03, 0.06, 0.1}) {
    const Result found = seen_from(x);
    EXPECT_NEAR(found.response[0] / all, beyond(x),
                5 * static_cast<double>(found.standard_error[0]) / all + 1e-3)
        << x;
  }
}

// L = T / n^2 exp(-a d) of what shines below, at the distance d along the bent ray.
TEST(Volumes, DimByFresnelAndWhatTheyAbsorb) {
  const double depth = 1.5;
  for (const double theta : {0.0, 0.5, 1.0, 1.3}) {
    Scene scene;
    add_level(scene, 0, 0, 50, volume(water, true));
    add_level(scene, 0, -depth, 50, shining(3));
    const Result found =
        rendered(made_world(scene, 0, 4), looking(theta), translation({0, 1, 0}), 1 << 14);
    const double way = depth / std::cos(std::asin(std::sin(theta) / water));
    for (std::size_t b = 0; b < 3; ++b) {
      const double wanted = 3 * fresnel(theta, water).through() / (water * water) *
                            std::exp(-absorption[b] * way);
      EXPECT_NEAR(found.response[b], wanted,
                  5 * static_cast<double>(found.standard_error[b]) + of_tables * wanted)
          << theta << " band " << b;
    }
  }
}

// From below the whole sky is in a window of asin(1 / n), n^2 times as bright less what is
// reflected; outside of it all is reflected.
TEST(Volumes, OpenAWindowFromBelow) {
  Scene scene;
  add_level(scene, 0, 0, 50, volume(water));
  add_level(scene, 0, -3, 50, matter(0));
  const World world = made_world(scene, 2, 4);
  for (const double theta : {0.0, 0.4, 0.7, 0.83, 0.86, 1.2}) {
    const Eye up = make_eye({std::sin(theta), std::cos(theta), 0}, 0.0);
    const Result found = rendered(world, up, translation({0, -1, 0}), 1 << 12);
    const double sine = water * std::sin(theta);
    const double wanted =
        sine < 1 ? 2 * water * water * fresnel(std::asin(sine), water).through() : 0;
    // Near the edge the tables are read where they are steepest.
    EXPECT_NEAR(found.response[0], wanted,
                5 * static_cast<double>(found.standard_error[0]) + 4 * of_tables * wanted + 1e-6)
        << theta;
  }
}

// What gets to the bottom of an even sky, and of a disc, counted once: the flux that gets through
// the surface, dimmed along the bent way.
TEST(Volumes, LightTheirBottom) {
  const double depth = 1, reflectance = 0.5;
  Scene scene;
  add_level(scene, 0, 0, 50, volume(water, true));
  add_level(scene, 0, -depth, 50, matter(reflectance));
  const Eye down = make_eye({0, -1, 0}, 0.0);
  const Mat4 below = translation({0, -0.5, 0});

  const Result of_sky = rendered(made_world(scene, 2, 1), down, below, 1 << 14);
  const double wanted = 2 * reflectance * let_in(water);
  EXPECT_NEAR(of_sky.response[0], wanted,
              5 * static_cast<double>(of_sky.standard_error[0]) + 2 * of_tables * wanted);

  Lighting lighting;
  lighting.light.bands = narrow_bands(3);
  lighting.light.unit = LightUnit::watts;
  lighting.depth = 1;
  const double theta = 1;
  lighting.light.discs.push_back({.direction = to_float(Vec3d{std::sin(theta), std::cos(theta), 0}),
                                  .angular_radius_rad = 0.005,
                                  .radiance = {1e4, 1e4, 1e4},
                                  .limb_darkening = {}});
  const World sunny(std::make_shared<const Scene>(scene),
                    {.backend = backend_under_test, .lighting = lighting});
  const Result of_disc = rendered(sunny, down, below, 1 << 12);
  const double flux = 1e4 * pi * std::pow(std::sin(0.005), 2) * std::cos(theta);
  const double way = depth / std::cos(std::asin(std::sin(theta) / water));
  for (std::size_t b = 0; b < 3; ++b) {
    const double sunlit = reflectance / pi * flux * fresnel(theta, water).through() *
                          std::exp(-absorption[b] * way);
    EXPECT_NEAR(of_disc.response[b], sunlit,
                5 * static_cast<double>(of_disc.standard_error[b]) + 2 * of_tables * sunlit)
        << b;
  }
}

// Between bottom and surface light goes to and fro, and is absorbed on each way: of what a bottom
// of reflectance r sends up the part m comes back,
//
//   L = r A / (1 - r m),  A = 2 ∫ T(θ) exp(-a d / cos θ') cos θ sin θ dθ,
//   m = 2 ∫ R(θ') exp(-2 a d / cos θ') cos θ' sin θ' dθ',
//
// under a sky of radiance 1.
TEST(Volumes, AbsorbWhatGoesToAndFro) {
  const double depth = 1, reflectance = 0.5;
  Scene scene;
  add_level(scene, 0, 0, 50, volume(water, true));
  add_level(scene, 0, -depth, 50, matter(reflectance));
  const Result found = rendered(made_world(scene, 1, 0), make_eye({0, -1, 0}, 0.0),
                                translation({0, 0.5, 0}), 1 << 16);
  for (std::size_t b = 0; b < 3; ++b) {
    constexpr int steps = 20000;
    double comes_in = 0, comes_back = 0;
    for (int k = 0; k < steps; ++k) {
      const double theta = (k + 0.5) * pi / 2 / steps;
      const double part = std::sin(2 * theta) * pi / 2 / steps;
      const double inside = std::asin(std::sin(theta) / water);
      comes_in += fresnel(theta, water).through() *
                  std::exp(-absorption[b] * depth / std::cos(inside)) * part;
      comes_back += (1 - fresnel(theta, 1 / water).through()) *
                    std::exp(-2 * absorption[b] * depth / std::cos(theta)) * part;
    }
    const double bottom = reflectance * comes_in / (1 - reflectance * comes_back);
    const double through = fresnel(0, water).through();
    const double wanted =
        1 - through + through / (water * water) * std::exp(-absorption[b] * depth) * bottom;
    EXPECT_NEAR(found.response[b], wanted,
                5 * static_cast<double>(found.standard_error[b]) + 2 * of_tables * wanted)
        << b;
  }
}

// Light comes through panes to the last surface of a path by its own chance too, as it does by that
// of the lights.
TEST(Volumes, LetLightThroughAfterTheLastScattering) {
  const double through = 0.5, reflectance = 0.5;
  Material pane = matter(through);
  pane.transmission = 1;
  Scene scene;
  add_level(scene, 0, 0, 50, pane);
  add_level(scene, 0, -0.1, 50, matter(reflectance));
  const Result found = rendered(made_world(scene, 2, 1), make_eye({0, -1, 0}, 0.0),
                                translation({0, -0.05, 0}), 1 << 14);
  EXPECT_NEAR(found.response[0], 2 * through * reflectance,
              5 * static_cast<double>(found.standard_error[0]) + 1e-4);
}

// Where all is white, nothing absorbs and the sky is even, all shows the sky's radiance: what is
// within a volume, over n^2, too, and where the surface scatters half of what gets through it.
TEST(Volumes, KeepAWhiteFurnace) {
  for (const float transmission : {1.0f, 0.5f}) {
    Material surface = volume(water);
    surface.transmission = transmission;
    Scene pond;
    add_level(pond, 0, 0, 50, surface);
    add_level(pond, 0, -1, 50, matter(1));
    std::vector<Vec3d> directions;
    for (const Vec3d& d : sphere_directions(120))
      if (d.y < -0.1) directions.push_back(d);
    const Eye eye = make_eye(directions, 0.0);
    const Result found = rendered(made_world(pond, 2, 200), eye, translation({0, 1, 0}), 4096);
    for (std::size_t i = 0; i < found.response.size(); ++i)
      EXPECT_NEAR(found.response[i], 2.0,
                  5 * static_cast<double>(found.standard_error[i]) + 4 * of_tables * 2)
          << transmission << ' ' << i;
  }
}

// Nor is a block of glass over a white floor, whose light goes through it at all angles and is
// mirrored within beyond the critical one.
TEST(Volumes, KeepAFurnaceWithABlock) {
  Scene scene;
  add_level(scene, 0, -1, 50, matter(1));
  Mesh block = cube_seen_from_inside(0.5, add_material(scene, volume(1.5)));
  for (auto& triangle : block.triangles) std::swap(triangle[1], triangle[2]);
  add_instance(scene, add_mesh(scene, block), translation({0, -0.4, 0}));
  std::vector<Vec3d> directions;
  for (const double x : {0.0, 0.1, 0.2, 0.3, 0.6}) directions.push_back({x, -1, 0.05});
  const Result found = rendered(made_world(scene, 1, 200), make_eye(directions, 0.0),
                                translation({0, 1, 0}), 1 << 13);
  for (std::size_t i = 0; i < found.response.size(); ++i)
    EXPECT_NEAR(found.response[i], 1.0,
                5 * static_cast<double>(found.standard_error[i]) + 4 * of_tables)
        << i;
}

// A ball of glass in an even sky is not seen.
TEST(Volumes, KeepAFurnaceWithGlass) {
  Scene scene;
  Mesh ball;
  ball.material = add_material(scene, volume(1.5));
  const int rings = 48, around = 96;
  for (int r = 0; r <= rings; ++r)
    for (int k = 0; k < around; ++k) {
      const Vec3d d = from_azimuth_elevation(2 * pi * k / around, pi * (r - rings / 2.0) / rings);
      ball.positions.push_back(to_float(d));
      ball.normals.push_back(to_float(d));
    }
  const auto at = [&](int r, int k) { return static_cast<std::uint32_t>(r * around + k % around); };
  for (int r = 0; r < rings; ++r)
    for (int k = 0; k < around; ++k) {
      ball.triangles.push_back({at(r, k), at(r + 1, k), at(r + 1, k + 1)});
      ball.triangles.push_back({at(r, k), at(r + 1, k + 1), at(r, k + 1)});
    }
  add_instance(scene, add_mesh(scene, ball));
  std::vector<Vec3d> directions;
  for (const double x : {0.0, 0.1, 0.2, 0.25}) directions.push_back({x, 0.03, -1});
  const Result found = rendered(made_world(scene, 1, 200), make_eye(directions, 0.0),
                                translation({0, 0, 3}), 1 << 14);
  for (std::size_t i = 0; i < found.response.size(); ++i)
    EXPECT_NEAR(found.response[i], 1.0,
                5 * static_cast<double>(found.standard_error[i]) + 4 * of_tables)
        << i;
}

// A disc of the sky is not seen straight through a surface from below, but where it is refracted:
// the mean of n^2 T L by the acceptance over the directions that leave into the disc.
TEST(Volumes, BendRaysToDiscs) {
  Scene scene;
  add_level(scene, 0, 0, 50, volume(water));
  add_level(scene, 0, -3, 50, matter(0));
  Lighting lighting;
  lighting.light.bands = narrow_bands(3);
  lighting.light.unit = LightUnit::watts;
  lighting.depth = 4;
  const double radius = 0.02, width = 0.02;
  const Vec3d disc{0.6, 0.8, 0};
  lighting.light.discs.push_back({.direction = to_float(disc),
                                  .angular_radius_rad = radius,
                                  .radiance = {100, 100, 100},
                                  .limb_darkening = {}});
  const World world(std::make_shared<const Scene>(scene),
                    {.backend = backend_under_test, .lighting = lighting});
  const auto along = [](double x) { return Vec3d{x, std::sqrt(1 - x * x), 0}; };
  const auto at = [&](double x) {
    return rendered(world, make_eye(along(x), width), translation({0, -1, 0}), 1 << 14);
  };
  EXPECT_EQ(at(0.6).response[0], 0);

  const double sine = 0.6 / water;
  constexpr int steps = 400;
  double all = 0, through = 0;
  for (int i = 0; i < steps; ++i)
    for (int k = 0; k < steps; ++k) {
      // To 2.5 widths, where a Gaussian is 3e-8 of its middle.
      const double theta = 2.5 * width * (i + 0.5) / steps, phi = 2 * pi * (k + 0.5) / steps;
      const double s =
          std::exp(-4 * std::log(2.0) * theta * theta / (width * width)) * std::sin(theta);
      all += s;
      const Vec3d d = direction_about(along(sine), theta, phi);
      const Vec3d out{water * d.x, std::sqrt(1 - water * water * (d.x * d.x + d.z * d.z)),
                      water * d.z};
      if (dot(out, disc) < std::cos(radius)) continue;
      through += s * water * water * fresnel(std::acos(out.y), water).through();
    }
  const Result image = at(sine);
  const double wanted = 100 * through / all;
  EXPECT_NEAR(image.response[0], wanted,
              5 * static_cast<double>(image.standard_error[0]) + 2 * of_tables * wanted);
}

TEST(Volumes, AreChecked) {
  const auto refused = [](const auto& change) {
    Scene scene;
    Material material = volume(water);
    change(material);
    add_level(scene, 0, 0, 1, material);
    EXPECT_THROW(made_world(scene, 1, 1), Error);
  };
  refused([](Material& m) { m.thickness_m = -1; });
  refused([](Material& m) { m.metallic = 0.5f; });
  refused([](Material& m) { m.clearcoat = 1; });
  refused([](Material& m) { m.attenuation_color = {1, 2, 1}; });
  refused([](Material& m) { m.attenuation_distance_m = 0; });
  refused([](Material& m) { m.absorption_per_m = {{400, 500}, {1, -1}}; });
}

}  // namespace
}  // namespace omma::test
