// Scenes far from the world's origin, as georeferenced ones are: moved there by nodes, together
// with the head, they are seen as they are at the origin; what single precision cannot hold is
// told.
#include <gtest/gtest.h>

#include <algorithm>

#include "omma/camera.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

// Not round, so that the numbers use all of their digits.
Vec3d place_at(double distance_m) {
  return {distance_m * 0.8123456789, -17.3 - distance_m * 0.01, -distance_m * 0.5812345678};
}

constexpr double distances[] = {1e5, 5e5, 5e6, 1e7};

Scene moved(Scene scene, const Mat4& by) {
  for (Instance& instance : scene.instances)
    instance.world_from_mesh = by * instance.world_from_mesh;
  return scene;
}

// Meshes placed several times become instances where there are over a million triangles of copies.
Scene with_many_copies(Scene scene) {
  Mesh mesh;
  mesh.positions = {{0, 0, -1}, {0, 0, 1}};
  mesh.triangles.assign(600'000, {0, 1, 0});
  const int index = add_mesh(scene, std::move(mesh));
  add_instance(scene, index);
  add_instance(scene, index, translation({0, 3, 0}));
  return scene;
}

std::vector<Mat4> some_poses() {
  Random random{3};
  return {Mat4{}, translation({0.3, -0.2, 0.1}) * random_rotation(random),
          translation({-0.2, 0.4, 0.3}) * random_rotation(random) * scaling({0.5, 0.5, 0.5})};
}

// Vertices are rounded to floats once more, at metres of distance: by 2^-24 of that. Rays that pass
// edges within it fall on the other side: of 64 rays one or two at most, and few of all.
void expect_alike(const std::vector<float>& found, const std::vector<float>& expected,
                  const std::string& what) {
  ASSERT_EQ(found.size(), expected.size());
  double worst = 0, sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double off = std::fabs(static_cast<double>(found[i]) - static_cast<double>(expected[i]));
    worst = std::max(worst, off);
    sum += off;
  }
  EXPECT_LE(worst, 2.0 / 64) << what;
  EXPECT_LE(sum / static_cast<double>(found.size()), 2e-5) << what;
}

std::vector<float> responses_at(const Scene& scene, const Eye& eye, const Mat4& world,
                                const RenderSettings& settings) {
  std::vector<Mat4> poses;
  for (const Mat4& pose : some_poses()) poses.push_back(world * pose);
  return render(make_renderer(scene, eye, settings), poses).response;
}

TEST(FarScenes, AreSeenAsAtTheOrigin) {
  Eye eye = make_eye(sphere_directions(300), 6 * degree);
  Random random{8};
  for (Vec3& p : eye.position_m) p = to_float(random.direction() * 0.002);
  for (const std::uint64_t seed : {2u, 3u, 5u})
    for (const bool many : {false, true}) {
      const Scene scene = many ? with_many_copies(random_scene(seed)) : random_scene(seed);
      for (const Sampling& sampling : {Sampling(Fixed{64}), Sampling(Shared{64})}) {
        const RenderSettings settings{.sampling = sampling};
        const std::vector<float> expected = responses_at(scene, eye, {}, settings);
        for (const double distance : distances) {
          if (many && distance != 5e6) continue;
          const Mat4 there = translation(place_at(distance));
          expect_alike(responses_at(moved(scene, there), eye, there, settings), expected,
                       "scene " + std::to_string(seed) + " at " + std::to_string(distance));
        }
      }
    }
}

TEST(FarScenes, CamerasAndSingleRaysSeeThemToo) {
  const Scene scene = random_scene(4);
  const Eye eye = make_eye(sphere_directions(50), 6 * degree);
  const auto rays_at = [&](const Scene& s, const Mat4& pose) {
    std::vector<float> responses(50 * rgb_bands), rays(50 * 64 * rgb_bands);
    RenderCall call;
    call.ray_radiance = rays;
    make_renderer(s, eye, {.sampling = Fixed{64}}).render(std::span(&pose, 1), responses, call);
    return rays;
  };
  const auto picture_at = [&](const Scene& s, const Mat4& pose) {
    Camera camera;
    camera.type = CameraType::perspective;
    camera.yfov_rad = 1;
    camera.world_from_camera = pose;
    std::vector<float> picture(48 * 64 * rgb_bands);
    render_camera(make_world(s), camera, {{64, 48}, 64, 1}, picture);
    return picture;
  };
  for (const double distance : distances) {
    const Mat4 there = translation(place_at(distance));
    const std::vector<float> found = rays_at(moved(scene, there), there),
                             expected = rays_at(scene, {});
    std::size_t others = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
      others += std::fabs(found[i] - expected[i]) > 1e-3f;
    EXPECT_LE(others, found.size() / 1000) << distance;
    expect_alike(picture_at(moved(scene, there), there), picture_at(scene, {}),
                 "picture at " + std::to_string(distance));
  }
}

// Coordinates far away in the file itself, exact there: a box whose corners are whole metres, seen
// from within, placed by nothing, by a node that brings it home, and mirrored, which is an
// instance.
TEST(FarScenes, CoordinatesFarAwayInTheFileLoseNothingMore) {
  const Vec3d away{5'000'000, 16, -3'000'000};
  const auto box = [&](Vec3d by) {
    Scene scene;
    const Vec3 colors[] = {{1, 0, 0},    {0, 1, 0},    {0, 0, 1},
                           {0.5f, 0, 0}, {0, 0.5f, 0}, {0, 0, 0.5f}};
    const Vec3d sides[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (std::size_t i = 0; i < 6; ++i) {
      const Vec3d u{sides[i].y, sides[i].z, sides[i].x}, v = cross(sides[i], u);
      add_quad(scene, by + sides[i] * 4, u * 4, v * 4, add_color(scene, colors[i]));
    }
    return scene;
  };
  const Eye eye = make_eye(sphere_directions(300), 6 * degree);
  const RenderSettings settings{.sampling = Fixed{64}};
  const auto expected = responses_at(box({}), eye, {}, settings);
  expect_alike(responses_at(box(away), eye, translation(away), settings), expected, "as it is");
  expect_alike(responses_at(moved(box(away), translation(away * -1.0)), eye, {}, settings),
               expected, "brought home");
  const Mat4 mirror = scaling({-1, 1, 1});
  const auto mirrored = responses_at(moved(box({}), mirror), eye, {}, settings);
  expect_alike(responses_at(moved(box(away), mirror * translation(away * -1.0)), eye, {}, settings),
               mirrored, "mirrored");
  const Mat4 there = translation({-7e6, 3, 2e6});
  expect_alike(responses_at(moved(box(away), there * mirror * translation(away * -1.0)), eye, there,
                            settings),
               mirrored, "mirrored, elsewhere");
}

TEST(FarScenes, WhatIsLeftIsToldAtThePoses) {
  const auto warning = [](const Scene& scene, Vec3d at) {
    const Renderer renderer = make_renderer(scene, make_eye(Vec3d{0, 0, -1}, 0.1));
    const std::vector<Mat4> poses = {Mat4{}, translation(at)};
    return renderer.precision_warning(std::span(poses).subspan(1));
  };
  const Scene scene = random_scene(2);
  EXPECT_EQ(warning(scene, {1, 2, 3}), "");
  EXPECT_EQ(warning(scene, {5e3, 0, 0}), "");
  EXPECT_EQ(warning(moved(scene, translation({5e6, 0, 0})), {5e6, 0, 0}), "");
  EXPECT_EQ(warning(Scene{}, {5e6, 0, 0}), "");
  // 2^-24 of 5e6 m, of a scene of some ten metres.
  EXPECT_NE(warning(scene, {5e6, 0, 0}).find("poses[0] lies 5e+06 m"), std::string::npos);
  EXPECT_NE(warning(scene, {5e6, 0, 0}).find("within 0.3 m"), std::string::npos)
      << warning(scene, {5e6, 0, 0});
  // A landscape of 200 km about the origin.
  Scene land;
  add_quad(land, {0, -1, 0}, {1e5, 0, 0}, {0, 0, -1e5}, add_color(land, {1, 1, 1}));
  EXPECT_EQ(warning(land, {1e4, 0, 0}), "");
  EXPECT_NE(warning(land, {9e4, 0, 0}).find("within 0.0054 m"), std::string::npos)
      << warning(land, {9e4, 0, 0});
}

}  // namespace
}  // namespace omma::test
