// A world and those who use it: several renderers and cameras, threads that render and move at
// once, progress and its end.
#include "omma/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "omma/camera.h"
#include "world_tests.h"

namespace omma::test {
namespace {

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(WorldUse, IsOneForAllWhoSeeIt) {
  const Scene scene = random_scene(5);
  const Eye eye = single_rays(300), wide = make_eye(sphere_directions(60), 0.3);
  World world = make_world(scene, {.background = constant_background({0.5f, 0.5f, 0.5f})});
  const Renderer one(world, eye, {.sampling = Fixed{1}}), two(one, eye, {.sampling = Fixed{1}});
  const World before_red = world.with_background(constant_background({1, 0, 0}));
  const Renderer three(before_red, eye, {.sampling = Fixed{1}});
  const Renderer four(world, eye,
                      {.sampling = Fixed{1}, .background = constant_background({1, 0, 0})});
  const Renderer fields(world, wide, {.sampling = Fixed{4}});
  const std::vector<float> at_first = seen(one), of_fields = seen(fields);
  EXPECT_EQ(seen(two), at_first);
  EXPECT_EQ(seen(four), seen(three));
  EXPECT_NE(seen(three), at_first);
  World again = two.world();
  std::vector<int> all;
  for (int i = 0; i < 16; ++i) all.push_back(i);
  const std::vector<Mat4> behind(16, translation({0, 0, 100}) * scaling({1e-3, 1e-3, 1e-3}));
  again.set_transforms(all, behind);
  EXPECT_EQ(seen(one), (std::vector<float>(900, 0.5f)));
  EXPECT_EQ(seen(two), seen(one));
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_EQ(seen(three)[3 * i], 1);
    EXPECT_EQ(seen(four)[3 * i + 1], 0);
  }
  EXPECT_NE(seen(fields), of_fields);
  EXPECT_EQ(&before_red.scene(), &world.scene());
  EXPECT_EQ(before_red.instances()[3].world_from_node.m[2][3], 100);
}

TEST(WorldUse, IsNotMovedWhileItIsRendered) {
  World world = make_world(random_scene(1), {.threads = 2});
  const int thing = 1;
  const Mat4 there = translation({0, 0, -3});
  const Renderer renderer(world, make_eye(sphere_directions(200), 0.1), {.threads = 2});
  const Mat4 pose;
  std::vector<float> out(200 * rgb_bands), picture(32 * 32 * rgb_bands);
  std::string message;
  const auto move = [&](double) {
    message = message_of([&] { world.set_transforms({&thing, 1}, {&there, 1}); });
    return true;
  };
  RenderCall call;
  call.progress = move;
  renderer.render({&pose, 1}, out, call);
  EXPECT_TRUE(has(message, "something is being rendered")) << message;
  message.clear();
  Camera camera;
  camera.type = CameraType::panoramic;
  render_camera(world, camera, {{32, 32}, 1}, picture, move);
  EXPECT_TRUE(has(message, "something is being rendered")) << message;
  EXPECT_EQ(message_of([&] { move(0); }), "");
  EXPECT_EQ(message, "");  // afterwards it can be

  // While it is moved, and built again for that, it is neither rendered nor moved.
  std::string of_render, of_move;
  const int other = 2;
  world.set_transforms({&other, 1}, {&there, 1}, [&](double) {
    of_render = message_of([&] { renderer.render({&pose, 1}, out); });
    of_move = message_of([&] { world.set_transforms({&thing, 1}, {&pose, 1}); });
    return true;
  });
  EXPECT_TRUE(has(of_render, "moving something")) << of_render;
  EXPECT_TRUE(has(of_move, "something is being moved")) << of_move;
  EXPECT_NO_THROW(renderer.render({&pose, 1}, out));
}

// Threads that render and one that moves, all at once: each call is whole or refused.
TEST(WorldUse, RendersAndMovesAtOnceAreWholeOrRefused) {
  Scene scene;
  add_quad(scene, {0, 0, -1}, {50, 0, 0}, {0, 50, 0}, add_color(scene, {1, 1, 1}));
  World world = make_world(scene);
  const int wall = 0;
  const Mat4 ahead, behind = translation({0, 0, 9});
  world.set_transforms({&wall, 1}, {&ahead, 1});
  std::atomic<bool> end = false;
  std::atomic<int> mixed = 0, rendered = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t)
    threads.emplace_back([&] {
      const Renderer renderer(world, make_eye(Vec3d{0, 0, -1}, 0.1, 300), {.threads = 1});
      while (!end) try {
          const std::vector<float> found = seen(renderer);
          ++rendered;
          for (const float value : found) mixed += value != found[0] ? 1 : 0;
          // Or else one of three is always at it, on a machine with fewer cores.
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        } catch (const Error&) {
        }
    });
  int moves = 0;
  for (int i = 0; i < 3000 || ((moves < 20 || rendered < 20) && i < 5000000); ++i) try {
      world.set_transforms({&wall, 1}, {moves % 2 == 0 ? &behind : &ahead, 1});
      ++moves;
    } catch (const Error&) {
      std::this_thread::yield();
    }
  end = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(mixed, 0);
  EXPECT_GE(moves, 20);
  EXPECT_GE(rendered, 20);
  EXPECT_EQ(world.instances()[0].world_from_node.m[2][3], moves % 2 == 0 ? 0 : 9);
}

TEST(WorldUse, BuildingIsToldAndEnds) {
  Scene scene = random_scene(3);
  Mesh fine;  // half a second's work
  constexpr std::uint32_t cells = 1000;
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i)
      fine.positions.push_back(to_float({0.1 * i - 50, -9 + 0.1 * ((i + j) % 7), 0.1 * j - 50}));
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i;
      fine.triangles.push_back({a, a + cells + 1, a + 1});
      fine.triangles.push_back({a + 1, a + cells + 1, a + cells + 2});
    }
  add_instance(scene, add_mesh(scene, std::move(fine)));
  EXPECT_THROW(World(std::make_shared<const Scene>(scene), {}, [](double) { return false; }),
               Cancelled);
  World world = make_world(scene);
  const Eye eye = single_rays(300);
  const std::vector<float> before = seen(world, eye);
  const int thing = 2;
  const Mat4 there = translation({0, -1, 0});
  EXPECT_THROW(world.set_transforms({&thing, 1}, {&there, 1}, [](double) { return false; }),
               Cancelled);
  EXPECT_EQ(seen(world, eye), before);
  // At the very end too.
  EXPECT_THROW(world.set_transforms({&thing, 1}, {&there, 1}, [](double done) { return done < 1; }),
               Cancelled);
  EXPECT_EQ(seen(world, eye), before);
  std::vector<double> told;
  world.set_transforms({&thing, 1}, {&there, 1}, [&](double done) {
    told.push_back(done);
    return true;
  });
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), 1);
  EXPECT_NE(seen(world, eye), before);
}

// The rays of the last picture are kept; that must not show.
TEST(WorldUse, KeepsTheRaysOfItsLastPicture) {
  const World world = make_world(random_scene(2));
  const auto picture_of = [](const World& of, const Camera& camera,
                             const CameraSettings& settings) {
    std::vector<float> picture(
        static_cast<std::size_t>(settings.size.width * settings.size.height) * rgb_bands);
    render_camera(of, camera, settings, picture);
    return picture;
  };
  Camera perspective, panorama;
  perspective.type = CameraType::perspective;
  perspective.yfov_rad = 1;
  panorama.type = CameraType::panoramic;
  Camera wider = perspective, elsewhere = perspective;
  wider.yfov_rad = 1.2;
  elsewhere.world_from_camera = rotation({0, 1, 0}, 1) * translation({0.1, 0.2, 0});
  const std::vector<std::pair<Camera, CameraSettings>> pictures{
      {perspective, {{90, 70}, 4}},     {perspective, {{90, 70}, 4}},
      {elsewhere, {{90, 70}, 4}},       {wider, {{90, 70}, 4}},
      {panorama, {{90, 70}, 4}},        {perspective, {{70, 90}, 4}},
      {perspective, {{70, 90}, 4, 1}},  {perspective, {{70, 90}, 5, 1}},
      {perspective, {{1500, 1500}, 1}}, {perspective, {{1500, 1500}, 1}}};  // more than are kept
  for (const auto& [camera, settings] : pictures)
    EXPECT_EQ(picture_of(world, camera, settings),
              picture_of(make_world(random_scene(2)), camera, settings));
}

}  // namespace
}  // namespace omma::test
