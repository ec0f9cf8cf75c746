// Frames in a world where things move between one frame and the next, against the same frames where
// nothing ever moved: the bundled meadow, in which flowers and grass sway, and 10,000 stones that
// are rolled about on the hills.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "scenes.h"

namespace omma::bench {
namespace {

// Cubes of 0.2 m all over the hills, 100 by 100 of them, a metre apart.
Setup stones() {
  Setup setup = hills(200);
  setup.name = "hills with stones";
  Scene scene = *setup.scene;
  Mesh cube;
  for (int corner = 0; corner < 8; ++corner)
    cube.positions.push_back(
        to_float({corner & 1 ? 0.1 : -0.1, corner & 2 ? 0.1 : -0.1, corner & 4 ? 0.1 : -0.1}));
  cube.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  scene.meshes.push_back(std::move(cube));
  const Vec3d eye{setup.poses[0].m[0][3], setup.poses[0].m[1][3], setup.poses[0].m[2][3]};
  for (int i = 0; i < 10000; ++i) {
    Mat4 t;
    t.m[0][3] = eye.x + i % 100 - 49.5, t.m[1][3] = eye.y - 1.5, t.m[2][3] = eye.z + i / 100 - 49.5;
    scene.instances.push_back({"stone " + std::to_string(i), 1, t});
  }
  setup.scene = std::make_shared<const Scene>(std::move(scene));
  return setup;
}

// A swing by up to 0.2 rad about the foot, each in a phase of its own.
Mat4 swing(const Mat4& at_rest, std::size_t thing, std::size_t frame) {
  const double angle =
      0.2 * std::sin(0.3 * static_cast<double>(frame) + static_cast<double>(thing));
  return at_rest * pose_from_quaternion({0, 0, 0}, std::sin(angle / 2), 0, 0, std::cos(angle / 2));
}

void measure(const Setup& setup, std::size_t first, const std::vector<std::size_t>& counts,
             bool quick) {
  const World still(setup.scene);
  RenderSettings settings;
  settings.sampling = Fixed{16};
  const Renderer of_still(still, setup.eye, settings);
  const std::vector<Mat4> poses = flight(setup, 64);
  std::vector<float> out(setup.eye.size() * rgb_bands);
  for (const std::size_t wanted : counts) {
    World world(setup.scene);
    const Renderer of_world(world, setup.eye, settings);
    const std::vector<WorldInstance> things = world.instances();
    const std::size_t count = std::min(wanted, things.size() - first);
    std::vector<int> moving;
    for (std::size_t k = 0; k < count; ++k)
      moving.push_back(static_cast<int>(first + k * (things.size() - first) / count));
    std::size_t frame = 0;
    double move_s = 0;
    const auto move = [&] {
      std::vector<Mat4> transforms;
      for (const int thing : moving)
        transforms.push_back(swing(things[static_cast<std::size_t>(thing)].world_from_node,
                                   static_cast<std::size_t>(thing), frame));
      ++frame;
      const auto start = Clock::now();
      world.set_transforms(moving, transforms);
      move_s += seconds_since(start);
    };
    const auto start = Clock::now();
    move();
    const double first_s = seconds_since(start);
    double still_s = 1e9, moved_s = 1e9, frames_s = 1e9, least_move_s = 1e9;
    // In turns, so that a disturbance meets all of them.
    for (int round = 0; round < (quick ? 2 : 12); ++round) {
      const auto seconds_of = [&](const Renderer& renderer, bool moves) {
        const auto begin = Clock::now();
        for (const Mat4& pose : poses) {
          if (moves) move();
          renderer.render({&pose, 1}, out);
        }
        return seconds_since(begin) / static_cast<double>(poses.size());
      };
      still_s = std::min(still_s, seconds_of(of_still, false));
      moved_s = std::min(moved_s, seconds_of(of_world, false));
      move_s = 0;
      frames_s = std::min(frames_s, seconds_of(of_world, true));
      least_move_s = std::min(least_move_s, move_s / static_cast<double>(poses.size()));
    }
    std::printf("%s,%zu,%zu,%.0f,%.1f,%.0f,%.0f,%.0f,%.3f\n", setup.name.c_str(), setup.eye.size(),
                count, 1e3 * first_s, 1e6 * least_move_s, 1 / still_s, 1 / moved_s, 1 / frames_s,
                still_s / frames_s);
    std::fflush(stdout);
  }
}

}  // namespace

void moving(bool quick) {
  std::printf(
      "scene,ommatidia,moving,first_move_ms,move_us,still_frames_per_s,moved_frames_per_s,"
      "moving_frames_per_s,share_of_still\n");
  Setup meadow = bundled();
  meadow.eye = sector(meadow.eye, meadow.eye.size() / 1000);
  // Behind land, path and verges.
  measure(meadow, 3, {1, 100, 1000, 10000}, quick);
  Setup field = stones();
  field.eye = sector(field.eye, field.eye.size() / 1000);
  measure(field, 1, {1, 100, 10000}, quick);
}

}  // namespace omma::bench
