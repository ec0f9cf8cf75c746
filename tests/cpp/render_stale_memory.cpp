// What a thread's memory and stack held before never comes into a frame: lanes of a packet that met
// nothing compute with whatever lies there, and nothing of it may be added to those that did.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "backend/block_functions.h"
#include "lit_squares.h"
#include "omma/bake.h"
#include "test_scenes.h"
#include "threads/thread_memory.h"
#include "world/world_state.h"
#include "world_tests.h"

namespace omma::test {
namespace {

// What a frame of this renderer takes.
std::size_t bytes_of(const Renderer& renderer) {
  FrameView frame;
  frame.scene = &renderer.world().state().view;
  frame.outputs = renderer.world().bands();
  return block_memory_bytes(frame);
}

std::vector<float> seen_after(const Renderer& renderer, int byte) {
  const std::size_t bytes = bytes_of(renderer);
  std::byte* const memory = thread_memory(bytes);
  std::memset(memory, byte, bytes);
  std::vector<float> found = seen(renderer);
  EXPECT_EQ(thread_memory(bytes), memory) << "the frame was rendered in other memory";
  return found;
}

void expect_the_same(const World& world) {
  const Eye eye = make_eye(sphere_directions(400), 0.1);
  RenderSettings settings;
  settings.sampling = Fixed{24};
  settings.threads = 1;
  const Renderer renderer(world, eye, settings);
  const std::vector<float> expected = seen_after(renderer, 0);
  for (const float x : expected) ASSERT_TRUE(std::isfinite(x));
  // All ones are not a number, as floats and as half of a double.
  for (const int byte : {0xff, 0x7f}) {
    const std::vector<float> found = seen_after(renderer, byte);
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(float)), 0) << byte;
  }
}

TEST(StaleMemory, IsNotSeenInUnlitWorlds) {
  expect_the_same(make_world(squares()));
}

TEST(StaleMemory, IsNotSeenByPathsOrInBakedLight) {
  for (const int components : {1, 3}) {
    WorldSettings settings;
    Lighting lighting = lighting_of(components);
    settings.lighting = lighting;
    const World by_paths = make_world(squares(), settings);
    expect_the_same(by_paths);
    lighting.baked = std::make_shared<const BakedLight>(bake_light(by_paths, {.paths = 16}));
    World baked = by_paths.with_lighting(lighting);
    expect_the_same(baked);
    const int moved[] = {2};
    const Mat4 to[] = {translation({0.2, 2.2, -2.5})};
    baked.set_transforms(moved, to);
    expect_the_same(baked);
  }
}

}  // namespace
}  // namespace omma::test
