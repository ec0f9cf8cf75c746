// Building what traces a scene: watched and ended, on the scene's own arrays, compact when large.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "test_scenes.h"

namespace omma::test {
namespace {

// A closed surround of radiance 1 that is large enough to be built compactly: 2 * 1500^2 triangles.
std::shared_ptr<const Scene> large_surround() {
  static const auto made = [] {
    constexpr std::uint32_t cells = 1500;
    Scene scene;
    Mesh mesh;
    mesh.material = add_color(scene, {1, 1, 1});
    for (std::uint32_t j = 0; j <= cells; ++j)
      for (std::uint32_t i = 0; i < cells; ++i)
        mesh.positions.push_back(
            to_float(from_azimuth_elevation(2 * pi * i / cells, pi * j / cells - pi / 2)));
    for (std::uint32_t j = 0; j < cells; ++j)
      for (std::uint32_t i = 0; i < cells; ++i) {
        const std::uint32_t a = j * cells + i, b = j * cells + (i + 1) % cells;
        mesh.triangles.push_back({a, b, a + cells});
        mesh.triangles.push_back({b, b + cells, a + cells});
      }
    add_instance(scene, add_mesh(scene, std::move(mesh)));
    return std::make_shared<const Scene>(std::move(scene));
  }();
  return made;
}

TEST(Build, LargeScenesAreWatertightToo) {
  const Eye eye = make_eye(sphere_directions(2000), 0.05);
  const Renderer renderer(large_surround(), eye, {.sampling = Fixed{64}});
  const Mat4 pose;
  std::vector<float> responses(eye.size() * rgb_bands);
  renderer.render({&pose, 1}, responses);
  // Sums of 64 ones in single precision are exact.
  for (const float response : responses) ASSERT_EQ(response, 1.0f);
}

TEST(Build, ReportsAndCancels) {
  const Eye eye = make_eye({0, 0, -1}, 0.1);
  std::vector<double> shares;
  std::thread::id where;
  const auto note = [&](double share) {
    shares.push_back(share);
    where = std::this_thread::get_id();
    return true;
  };
  const Renderer renderer(std::make_shared<const Scene>(random_scene(3)), eye, {}, note);
  ASSERT_FALSE(shares.empty());
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.back(), 1);
  EXPECT_EQ(where, std::this_thread::get_id());

  // It takes most of a second, so these end it on the way.
  EXPECT_THROW(Renderer(large_surround(), eye, {}, [](double) { return false; }), Cancelled);
  EXPECT_THROW(Renderer(large_surround(), eye, {.threads = 1},
                        [](double) -> bool { throw std::range_error("enough"); }),
               std::range_error);
}

// Vertices are used where they are if there is memory after the last one, else copied.
TEST(Build, TheSameBitsWithAndWithoutCopies) {
  Scene scene = random_scene(7);
  const Eye eye = make_eye(sphere_directions(300), 0.2);
  for (Mesh& mesh : scene.meshes) mesh.positions.reserve(mesh.positions.size() + 1);
  for (Instance& instance : scene.instances) instance.world_from_mesh = {};
  Scene tight = scene;
  for (Mesh& mesh : tight.meshes) mesh.positions.shrink_to_fit();
  const auto responses = [&](Scene&& one) {
    const Renderer renderer(std::make_shared<const Scene>(std::move(one)), eye);
    const Mat4 pose;
    std::vector<float> result(eye.size() * rgb_bands);
    renderer.render({&pose, 1}, result);
    return result;
  };
  EXPECT_EQ(responses(std::move(scene)), responses(std::move(tight)));
}

// Large scenes keep texture coordinates and colours by vertex, small ones by corner.
TEST(Build, TheSameBitsInALargeScene) {
  const Eye eye = make_eye(sphere_directions(300), 0.2);
  for (const ColorRule rule : {ColorRule::gltf, ColorRule::compoundray}) {
    Scene scene = random_scene(7);
    scene.color_rule = rule;
    Scene large = scene;
    Mesh nowhere;  // counts, though it is never placed
    nowhere.positions.resize(1);
    nowhere.triangles.resize((std::size_t(1) << 22) + 1);
    add_mesh(large, std::move(nowhere));
    EXPECT_EQ(render(large, eye).response, render(scene, eye).response);
  }
}

}  // namespace
}  // namespace omma::test
