// Gaussian splats along rays against closed forms and against a slow reference in double precision
// that sorts all splats: one from outside and inside, two in both orders, fields, before, behind
// and between surfaces, placed by transforms, as ground truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "omma/error.h"
#include "physics/lanes/powers.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

constexpr double band_0 = 0.28209479177387814;  // 1 / (2 √π)

double linear_of(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

// A splat of one colour, in the space of its cloud.
void add_splat(SplatCloud& cloud, Vec3d at, double scale_m, double opacity, Vec3d color) {
  cloud.positions.push_back(to_float(at));
  const auto s = static_cast<float>(scale_m);
  cloud.scales.push_back({s, s, s});
  cloud.rotations.push_back({0, 0, 0, 1});
  cloud.opacities.push_back(static_cast<float>(opacity));
  for (const double c : {color.x, color.y, color.z})
    cloud.harmonics.push_back(static_cast<float>((c - 0.5) / band_0));
}

// Splats of all shapes and colours around the origin, of degree 3.
SplatCloud random_cloud(std::uint64_t seed, int count, double size_m) {
  Random random{seed};
  SplatCloud cloud;
  cloud.terms = 16;
  for (int i = 0; i < count; ++i) {
    cloud.positions.push_back(to_float(random.direction() * random.uniform(0.3, 3)));
    const auto scale = [&] { return static_cast<float>(size_m * std::exp(random.uniform(-1, 1))); };
    cloud.scales.push_back({scale(), scale(), scale()});
    const Vec3d axis = random.direction();
    const double half = random.uniform(0, pi / 2), s = std::sin(half);
    cloud.rotations.push_back({static_cast<float>(axis.x * s), static_cast<float>(axis.y * s),
                               static_cast<float>(axis.z * s), static_cast<float>(std::cos(half))});
    cloud.opacities.push_back(static_cast<float>(random.uniform(0, 1)));
    for (int k = 0; k < 48; ++k)
      cloud.harmonics.push_back(static_cast<float>(random.uniform(-0.3, 0.3)));
  }
  return cloud;
}

// Real harmonics by their definition, from associated Legendre functions (Abramowitz and Stegun
// 8.6.6): Y_l^m of the order m = -l to l, without the Condon-Shortley phase but with the signs
// (-1)^m that splats have.
double harmonic(int l, int m, Vec3d d) {
  const int order = std::abs(m);
  const double phi = std::atan2(d.y, d.x);
  double factor = (2 * l + 1) / (4 * pi);
  for (int k = l - order + 1; k <= l + order; ++k) factor /= k;
  const double legendre =
      std::assoc_legendre(static_cast<unsigned>(l), static_cast<unsigned>(order), d.z);
  const double y = std::sqrt(factor) * legendre;
  if (m == 0) return y;
  const double sign = order % 2 == 0 ? 1 : -1;
  return sign * std::sqrt(2.0) * y * (m > 0 ? std::cos(order * phi) : std::sin(order * phi));
}

Vec3d color_of(const SplatCloud& cloud, std::size_t splat, Vec3d along) {
  const Mat4& m = cloud.world_from_splats;
  // Without translation, by Cramer's rule: along = A d.
  const auto column = [&](int c) { return Vec3d{m.m[0][c], m.m[1][c], m.m[2][c]}; };
  const Vec3d a = column(0), b = column(1), c = column(2);
  const double det = dot(a, cross(b, c));
  const Vec3d d = normalize(Vec3d{dot(along, cross(b, c)) / det, dot(a, cross(along, c)) / det,
                                  dot(a, cross(b, along)) / det});
  double sum[3] = {0.5, 0.5, 0.5};
  int k = 0;
  for (int l = 0; k < cloud.terms; ++l)
    for (int order = -l; order <= l; ++order, ++k)
      for (std::size_t i = 0; i < 3; ++i)
        sum[i] +=
            harmonic(l, order, d) *
            static_cast<double>(cloud.harmonics[3 * (splat * static_cast<std::size_t>(cloud.terms) +
                                                     static_cast<std::size_t>(k)) +
                                                i]);
  return {std::max(sum[0], 0.0), std::max(sum[1], 0.0), std::max(sum[2], 0.0)};
}

struct Seen {
  double rgb[3] = {0, 0, 0};
  double transmittance = 1, weighted_m = 0, half_m = std::numeric_limits<double>::infinity();
};

// Along one ray, up to far_m: every splat whitened by solving for its own axes, all sorted.
Seen reference(const std::vector<SplatCloud>& clouds, Vec3d origin, Vec3d direction,
               double far_m = std::numeric_limits<double>::infinity()) {
  struct Met {
    double t, alpha;
    Vec3d color;
  };
  std::vector<Met> met;
  for (const SplatCloud& cloud : clouds)
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
      const Vec4 q = cloud.rotations[i];
      const Vec3d axis{static_cast<double>(q.x), static_cast<double>(q.y),
                       static_cast<double>(q.z)};
      const double sine = length(axis);
      const Mat4 turned =
          sine > 0 ? rotation(axis * (1 / sine), 2 * std::atan2(sine, static_cast<double>(q.w)))
                   : Mat4{};
      const Mat4 splat = cloud.world_from_splats * translation(to_double(cloud.positions[i])) *
                         turned * scaling(to_double(cloud.scales[i]));
      const auto column = [&](int c) { return Vec3d{splat.m[0][c], splat.m[1][c], splat.m[2][c]}; };
      const Vec3d a = column(0), b = column(1), c = column(2), middle = column(3);
      const double det = dot(a, cross(b, c));
      const auto whiten = [&](Vec3d v) {
        return Vec3d{dot(v, cross(b, c)) / det, dot(a, cross(v, c)) / det,
                     dot(a, cross(b, v)) / det};
      };
      const Vec3d o = whiten(origin - middle), d = whiten(direction);
      const double t = -dot(o, d) / dot(d, d);
      const Vec3d closest = o + d * t;
      const double alpha = std::min(
          0.99, static_cast<double>(cloud.opacities[i]) * std::exp(-dot(closest, closest) / 2));
      if (alpha < 1.0 / 255 || t <= 0 || t > far_m) continue;
      met.push_back(
          {t, alpha,
           color_of(cloud, i,
                    cloud.direction == SplatDirection::ray ? direction : middle - origin)});
    }
  std::sort(met.begin(), met.end(), [](const Met& p, const Met& q) { return p.t < q.t; });
  Seen seen;
  for (const Met& one : met) {
    if (seen.transmittance < 1e-4) break;
    const double weight = seen.transmittance * one.alpha;
    seen.rgb[0] += weight * one.color.x;
    seen.rgb[1] += weight * one.color.y;
    seen.rgb[2] += weight * one.color.z;
    seen.weighted_m += weight * one.t;
    seen.transmittance *= 1 - one.alpha;
    if (seen.transmittance <= 0.5) seen.half_m = std::min(seen.half_m, one.t);
  }
  const double covered = 1 - seen.transmittance;
  if (clouds.front().color_space == SplatColor::srgb && covered > 0)
    for (double& c : seen.rgb) c = covered * linear_of(c / covered);
  return seen;
}

Scene scene_of(std::vector<SplatCloud> clouds, Vec3 behind = {0.2f, 0.4f, 0.8f}) {
  Scene scene;
  scene.splats = std::move(clouds);
  scene.background = constant_background(behind);
  return scene;
}

constexpr RenderSettings one_ray{.sampling = Fixed{1}};

TEST(Splats, PowersOfLanes) {
  for (int i = 0; i <= 4000; ++i) {
    const double x = -20 + 0.01 * i;
    const auto as_float = static_cast<float>(x);
    EXPECT_NEAR(
        static_cast<double>(exp2_lanes(as_float)) / std::exp2(static_cast<double>(as_float)), 1,
        3e-7);
    const auto positive = static_cast<float>(std::exp2(x));
    EXPECT_NEAR(static_cast<double>(log2_lanes(positive)), std::log2(static_cast<double>(positive)),
                3e-7 * std::max(1.0, std::fabs(x)));
    const auto value = static_cast<float>(i * 1e-3);
    EXPECT_NEAR(static_cast<double>(linear_of_srgb(value)), linear_of(static_cast<double>(value)),
                1e-6 * std::max(1.0, linear_of(i * 1e-3)));
  }
}

TEST(Splats, OneFromOutside) {
  for (const SplatColor space : {SplatColor::linear, SplatColor::srgb}) {
    SplatCloud cloud;
    cloud.color_space = space;
    add_splat(cloud, {0, 0, -3}, 0.5, 0.8, {0.7, 0.3, 0.1});
    std::vector<Vec3d> axes;
    for (int i = 0; i < 60; ++i) axes.push_back(from_azimuth_elevation(0.01 * i, 0));
    const Eye eye = make_eye(axes, 0);
    const Result result = render(scene_of({cloud}, {0.2f, 0.4f, 0.8f}), eye, one_ray);
    for (std::size_t i = 0; i < eye.size(); ++i) {
      const double off = 3 * std::sin(0.01 * static_cast<double>(i)) / 0.5;
      double alpha = 0.8 * std::exp(-off * off / 2);
      if (alpha < 1.0 / 255) alpha = 0;
      const double color[3] = {0.7, 0.3, 0.1}, behind[3] = {0.2, 0.4, 0.8};
      for (int c = 0; c < 3; ++c) {
        const double own = space == SplatColor::srgb ? linear_of(color[c]) : color[c];
        EXPECT_NEAR(result.at(i, c), alpha * own + (1 - alpha) * behind[c], 2e-6) << i;
      }
    }
  }
}

// What counts is where the response is greatest: before the eye all of it, behind it nothing.
TEST(Splats, OneFromInside) {
  SplatCloud cloud;
  cloud.color_space = SplatColor::linear;
  add_splat(cloud, {0, 0, -0.1}, 0.5, 0.8, {1, 1, 1});
  const Scene scene = scene_of({cloud}, {0, 0, 0});
  const std::vector<Vec3d> axes{{0, 0, -1}, {0, 0, 1}, {0.6, 0, -0.8}, {0.6, 0, 0.8}};
  const Result result = render(scene, make_eye(axes, 0), one_ray);
  EXPECT_NEAR(result.at(0), 0.8, 1e-6);
  EXPECT_EQ(result.at(1), 0);
  EXPECT_NEAR(result.at(2), 0.8 * std::exp(-0.5 * std::pow(0.1 * 0.6 / 0.5, 2)), 1e-6);
  EXPECT_EQ(result.at(3), 0);
}

// As surfaces are: what is nearer than the focal offset along a ray is within the eye.
TEST(Splats, WithinTheEyeAreNotSeen) {
  for (const double at : {0.05, 0.15}) {
    SplatCloud cloud;
    cloud.color_space = SplatColor::linear;
    add_splat(cloud, {0, 0, -at}, 0.01, 0.5, {1, 1, 1});
    Eye eye = make_eye(Vec3d{0, 0, -1}, 0);
    eye.position_m[0] = {0, 0, -0.1f};
    eye.focal_offset_m[0] = 0.1f;
    EXPECT_NEAR(render(scene_of({cloud}, {0, 0, 0}), eye, one_ray).at(0), at > 0.1 ? 0.5 : 0.0,
                1e-6);
  }
}

// What is behind them keeps its light.
TEST(Splats, OfAnotherWhite) {
  SplatCloud cloud;
  cloud.white = {10, 2, 0.5f};
  add_splat(cloud, {0, 0, -3}, 0.5, 0.8, {0.7, 0.3, 0.1});
  const Result result =
      render(scene_of({cloud}, {0.2f, 0.4f, 0.8f}), make_eye(Vec3d{0, 0, -1}, 0), one_ray);
  EXPECT_NEAR(result.at(0, 0), 10 * 0.8 * linear_of(0.7) + 0.2 * 0.2, 1e-5);
  EXPECT_NEAR(result.at(0, 1), 2 * 0.8 * linear_of(0.3) + 0.2 * 0.4, 1e-6);
  EXPECT_NEAR(result.at(0, 2), 0.5 * 0.8 * linear_of(0.1) + 0.2 * 0.8, 1e-6);
}

TEST(Splats, TwoInBothOrders) {
  for (const double nearer : {1.0, 3.0}) {
    SplatCloud cloud;
    cloud.color_space = SplatColor::linear;
    add_splat(cloud, {0, 0, -nearer}, 0.3, 0.6, {1, 0, 0.5});
    add_splat(cloud, {0, 0, -2}, 0.3, 0.5, {0, 1, 0.5});
    const Result result =
        render(scene_of({cloud}, {0, 0, 1}), make_eye(Vec3d{0, 0, -1}, 0), one_ray);
    const bool first = nearer < 2;
    EXPECT_NEAR(result.at(0, 0), first ? 0.6 : 0.5 * 0.6, 1e-6);
    EXPECT_NEAR(result.at(0, 1), first ? 0.4 * 0.5 : 0.5, 1e-6);
    EXPECT_NEAR(result.at(0, 2), 0.8 * 0.5 + 0.2, 1e-6);
  }
}

// A field of one colour has that colour, whatever is in the way and however it is put together:
// splats by the hundred along a ray, more than any buffer holds.
TEST(Splats, FieldsGiveTheirColor) {
  Random random{3};
  for (const double opacity : {0.02, 0.3, 1.0}) {
    SplatCloud cloud;
    for (int i = 0; i < 4000; ++i)
      add_splat(cloud, {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)}, 0.3,
                opacity, {0.8, 0.5, 0.25});
    const std::vector<Vec3d> axes = sphere_directions(200);
    const Result result = render(scene_of({cloud}, {0, 0, 0}), make_eye(axes, 0), one_ray);
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const Seen seen = reference({cloud}, {0, 0, 0}, axes[i]);
      EXPECT_NEAR(result.at(i, 0), (1 - seen.transmittance) * linear_of(0.8), 3e-6) << i;
      EXPECT_NEAR(result.at(i, 1), (1 - seen.transmittance) * linear_of(0.5), 3e-6) << i;
      EXPECT_NEAR(result.at(i, 2), (1 - seen.transmittance) * linear_of(0.25), 3e-6) << i;
    }
  }
}

// All shapes, colours and transforms against the reference. A splat at the edge of what counts
// changes its ray by up to 1/255 where roundings differ: such rays are few.
TEST(Splats, AsTheReference) {
  for (const SplatDirection direction : {SplatDirection::center, SplatDirection::ray})
    for (const double size_m : {0.02, 0.1, 0.4}) {
      std::vector<SplatCloud> clouds{random_cloud(1, 300, size_m), random_cloud(2, 200, size_m)};
      clouds[1].direction = direction;
      clouds[1].world_from_splats =
          translation({0.3, 0.1, -0.2}) * rotation({0.6, 0.8, 0}, 1) * scaling({1.5, -0.8, 1});
      const std::vector<Vec3d> axes = sphere_directions(800);
      const Vec3d from{0.05, -0.1, 0.02};
      const Result result = render(scene_of(clouds), make_eye(axes, 0), one_ray, translation(from));
      const double behind[3] = {static_cast<double>(0.2f), static_cast<double>(0.4f),
                                static_cast<double>(0.8f)};
      int wrong = 0;
      for (std::size_t i = 0; i < axes.size(); ++i) {
        const Seen seen = reference(clouds, from, axes[i]);
        for (int c = 0; c < 3; ++c) {
          const double expected = seen.rgb[c] + seen.transmittance * behind[c];
          if (std::fabs(result.at(i, c) - expected) > 2e-5) ++wrong;
          EXPECT_NEAR(result.at(i, c), expected, 0.01) << "ray " << i;
        }
      }
      EXPECT_LE(wrong, 6) << size_m;
    }
}

// Surfaces before and behind splats, panes between them: light of each in its order.
TEST(Splats, BetweenSurfaces) {
  SplatCloud cloud;
  cloud.color_space = SplatColor::linear;
  for (const double z : {1.0, 3.0, 5.0}) add_splat(cloud, {0, 0, -z}, 0.2, 0.5, {z / 10, 0.5, 1});
  Scene scene = scene_of({cloud}, {0, 0, 0});
  const int wall = add_color(scene, {0.9f, 0.1f, 0.3f}),
            pane = add_color(scene, {0.2f, 0.6f, 0.4f});
  scene.materials[static_cast<std::size_t>(pane)].alpha_mode = AlphaMode::blend;
  scene.materials[static_cast<std::size_t>(pane)].base_color.w = 0.25f;
  add_quad(scene, {0, 0, -4}, {1, 0, 0}, {0, 1, 0}, wall);
  const Eye eye = make_eye(Vec3d{0, 0, -1}, 0);
  EXPECT_NEAR(render(scene, eye, one_ray).at(0), 0.5 * 0.1 + 0.25 * 0.3 + 0.25 * 0.9, 1e-6);
  add_quad(scene, {0, 0, -2}, {1, 0, 0}, {0, 1, 0}, pane);
  EXPECT_NEAR(render(scene, eye, one_ray).at(0),
              0.5 * 0.1 + 0.5 * (0.25 * 0.2 + 0.75 * (0.5 * 0.3 + 0.5 * 0.9)), 1e-6);
}

// Things that move change what splats are traced from; splats stay where they are.
TEST(Splats, StayWhereThingsMove) {
  SplatCloud cloud = random_cloud(5, 100, 0.2);
  cloud.world_from_splats = translation({4096, 0, -8192});
  Scene scene = scene_of({cloud});
  add_quad(scene, {4096, 0, -8192 - 5}, {1, 0, 0}, {0, 1, 0}, add_color(scene, {1, 0, 0}));
  const World world = make_world(scene);
  const std::vector<Vec3d> axes = sphere_directions(100);
  const Renderer renderer(world, make_eye(axes, 0), one_ray);
  const Mat4 pose = translation({4096, 0, -8192});
  const Result before = render(renderer, std::span(&pose, 1));
  const int instance = 0;
  const Mat4 away = translation({0, 0, 300000});
  World(world).set_transforms(std::span(&instance, 1), std::span(&away, 1));
  const Result after = render(renderer, std::span(&pose, 1));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (axes[i].z < -0.9) continue;  // the quad was there
    EXPECT_NEAR(after.at(i), before.at(i), 1e-4) << i;
  }
}

// Ground truth: distance is where half of the light comes from before; a surface behind counts
// where more gets through.
TEST(Splats, AsGroundTruth) {
  SplatCloud thick, thin;
  for (const double z : {2.0, 3.0}) add_splat(thick, {0, 0, -z}, 0.1, 0.4, {1, 1, 1});
  add_splat(thin, {1, 0, -1}, 0.1, 0.4, {1, 1, 1});
  Scene scene = scene_of({thick, thin});
  add_quad(scene, {0, 0, -6}, {9, 0, 0}, {0, 9, 0}, add_color(scene, {1, 0, 0}));
  const World world = make_world(scene);
  const std::vector<Vec3d> axes{{0, 0, -1}, normalize(Vec3d{1, 0, -1}), {0, 0, 1}};
  const Renderer renderer(world, make_eye(axes, 0), one_ray);
  std::vector<float> response(9), distance(3), source(3), met(3), shares(9), normal(9);
  std::vector<double> position(9);
  const std::vector<std::int32_t> groups{0, 1, 2};  // the quad, then the clouds
  RenderCall call;
  call.truth.distance_m = distance;
  call.truth.source_distance_m = source;
  call.truth.met = met;
  call.truth.position_m = position;
  call.truth.normal = normal;
  call.truth.shares = shares;
  call.truth.share_count = 3;
  call.truth.share_of_instance = groups;
  const Mat4 pose;
  renderer.render(std::span(&pose, 1), response, call);
  EXPECT_NEAR(distance[0], 3, 1e-5);  // 0.6 get through the first, 0.36 both
  EXPECT_NEAR(distance[1], 6 * std::sqrt(2.0), 1e-4);
  EXPECT_NEAR(source[0], 0.4 * 2 + 0.24 * 3 + 0.36 * 6, 1e-5);
  EXPECT_NEAR(source[1], (0.4 * 1 + 0.6 * 6) * std::sqrt(2.0), 1e-4);
  EXPECT_EQ(source[2], std::numeric_limits<float>::infinity());
  EXPECT_EQ(met[2], 0);
  EXPECT_NEAR(position[2], -3, 1e-5);
  EXPECT_EQ(normal[2], 0);
  EXPECT_NEAR(normal[5], 1, 1e-6);
  EXPECT_EQ(shares[1], 1);  // of the first ommatidium the first cloud
  EXPECT_EQ(shares[3], 1);  // of the second the quad
}

TEST(Splats, RefusedWhereTheyCannotBeRight) {
  const auto message = [](const SplatCloud& cloud) {
    try {
      validate_scene(scene_of({cloud}));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto changed = [&](auto change) {
    SplatCloud cloud = random_cloud(1, 3, 0.1);
    EXPECT_EQ(message(cloud), "");
    change(cloud);
    return message(cloud);
  };
  const auto expect = [](const std::string& found, const std::string& part) {
    EXPECT_NE(found.find(part), std::string::npos) << found;
  };
  expect(changed([](SplatCloud& c) { c.scales.pop_back(); }), "has 2 scales, expected 3");
  expect(changed([](SplatCloud& c) { c.scales[1].y = 0; }), "splat 1: expected scales from");
  expect(changed([](SplatCloud& c) { c.rotations[2] = {0, 0, 0, 0}; }), "splat 2: expected a rot");
  expect(changed([](SplatCloud& c) { c.opacities[0] = 1.5f; }), "splat 0: expected an opacity");
  expect(changed([](SplatCloud& c) { c.positions[0].x = NAN; }), "splat 0: expected a position");
  expect(changed([](SplatCloud& c) { c.harmonics[50] = NAN; }), "splat 1: expected harmonics");
  expect(changed([](SplatCloud& c) { c.terms = 5; }), "of 1, 4, 9 or 16 terms");
  expect(changed([](SplatCloud& c) {
           c.world_from_splats = scaling({0, 1, 1});
         }),
         "cannot be inverted");
  expect(changed([](SplatCloud& c) {
           c.world_from_splats = scaling({1e40, 1e-20, 1e-20});
         }),
         "stretches by more than 1e12");
  Scene mixed = scene_of({random_cloud(1, 2, 0.1), random_cloud(2, 2, 0.1)});
  mixed.splats[1].color_space = SplatColor::linear;
  EXPECT_THROW(validate_scene(mixed), Error);
  expect(changed([](SplatCloud& c) { c.white[1] = 0; }), "expected a white");
}

}  // namespace
}  // namespace omma::test
