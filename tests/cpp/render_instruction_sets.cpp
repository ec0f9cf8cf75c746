// The hot loop is built once per instruction set. Whichever a processor gets, the responses are the
// same to the last bit: no contraction to fused multiply-add, the same steps for any lane width.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "backend/eye_arrays.h"
#include "backend/portable/portable_backend.h"
#include "backend/portable/portable_builds.h"
#include "backend/processor.h"
#include "backend/shading_data.h"
#include "lit_squares.h"
#include "omma/bake.h"
#include "sampling/shared_rays.h"
#include "test_scenes.h"
#include "threads/thread_memory.h"
#include "world/world_state.h"
#include "world_tests.h"
#if defined(OMMA_HAS_EMBREE)
#include "backend/embree/embree_backend.h"
#include "backend/embree/embree_builds.h"
#endif

namespace omma::test {
namespace {

struct NamedBuild {
  std::string name;
  BlockFunctions block;
};

// A search, and the builds of the hot loop with it that this processor runs.
struct NamedSearch {
  Backend backend;
  std::vector<NamedBuild> builds;
};

std::vector<NamedSearch> searches() {
  std::vector<NamedSearch> all;
  all.push_back({portable_backend(),
                 {{"baseline", baseline::portable_block()}, {"plain", plain::portable_block()}}});
#if defined(__x86_64__)
  if (has_avx2()) all[0].builds.push_back({"avx2", avx2::portable_block()});
  if (has_avx512()) all[0].builds.push_back({"avx512", avx512::portable_block()});
#endif
#if defined(OMMA_HAS_EMBREE)
  all.push_back({embree_backend(),
                 {{"baseline", baseline::embree_block()}, {"plain", plain::embree_block()}}});
#if defined(__x86_64__)
  if (has_avx2()) all[1].builds.push_back({"avx2", avx2::embree_block()});
  if (has_avx512()) all[1].builds.push_back({"avx512", avx512::embree_block()});
#endif
#endif
  return all;
}

void expect_the_same_bits(const NamedSearch& search) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    Scene scene = random_scene(seed);
    // Texels far finer than footprints of 1.5 degrees, so that levels are read.
    if (seed > 3)
      for (Image& image : scene.images)
        image = make_image(300, 170, [&](int column, int row) {
          const auto value = static_cast<float>((column * 7 + row * 13 + column * row) % 31) / 31;
          return Vec4{value, 1 - value, value * value, 0.5f + 0.5f * value};
        });
    const Eye eye = make_eye(sphere_directions(150), 12 * degree);
    constexpr int samples = 21;  // not a multiple of any lane width
    const auto shading = make_shading_data(scene);
    const BackgroundData background = make_background_data(scene.background);
    SceneView view = shading->view;
    view.background = background.view;
    const Acceleration acceleration =
        search.backend.build(scene, shading->view, placement_of(scene), {}, nullptr);
    const DirectionTables directions = make_direction_tables(eye, {}, samples);
    const EyeArrays arrays = make_eye_arrays(eye, directions);
    const DirectionsView directions_view = omma::view(directions);
    const EyeView eye_view = omma::view(arrays);
    const FrameView frame{&view, &eye_view, &directions_view};
    std::vector<std::vector<float>> responses;
    for (const NamedBuild& build : search.builds) {
      responses.emplace_back(eye.size() * rgb_bands, -1.0f);
      BlockTask task;
      for (int i = 0; i < 3; ++i) task.world_from_head[i][i] = 1;
      task.count = static_cast<int>(eye.size());
      task.responses = responses.back().data();
      build.block.render(frame, task, acceleration.tracer.get(),
                         thread_memory(block_memory_bytes(frame)));
      EXPECT_EQ(responses.back(), responses.front())
          << search.backend.name << ", " << build.name << ", scene " << seed;
    }
  }
}

TEST(InstructionSets, GiveTheSameBits) {
  for (const NamedSearch& search : searches()) expect_the_same_bits(search);
}

// One frame of a lit world, by every build.
void expect_the_same_bits(const NamedSearch& search, const World& world, const std::string& what) {
  const Eye eye = make_eye(sphere_directions(300), 20 * degree);
  const DirectionTables directions = make_direction_tables(eye, {}, 21);
  const EyeArrays arrays = make_eye_arrays(eye, directions);
  const DirectionsView directions_view = omma::view(directions);
  const EyeView eye_view = omma::view(arrays);
  FrameView frame{&world.state().view, &eye_view, &directions_view};
  const bool is_polarized = world.state().view.polarized;
  frame.outputs = world.bands() * (is_polarized ? 3 : 1);
  const auto outputs = static_cast<std::size_t>(frame.outputs);
  std::vector<std::vector<float>> responses;
  for (const NamedBuild& build : search.builds) {
    responses.emplace_back(eye.size() * outputs, -1.0f);
    for (int first = 0; first < static_cast<int>(eye.size()); first += 25) {
      BlockTask task;
      for (int i = 0; i < 3; ++i) task.world_from_head[i][i] = 1;
      task.first = first;
      task.count = 25;  // of 21 rays each: more than wait for each other
      task.responses = responses.back().data();
      build.block.render(frame, task, world.state().built->acceleration.tracer.get(),
                         thread_memory(block_memory_bytes(frame)));
    }
    for (const float x : responses.back()) ASSERT_TRUE(std::isfinite(x));
    EXPECT_EQ(responses.back(), responses.front())
        << search.backend.name << ", " << build.name << ", " << what;
  }
}

TEST(InstructionSets, GiveTheSameBitsInLitWorlds) {
  for (const NamedSearch& search : searches())
    for (const int components : {1, 3})
      for (const int depth : {0, 1, 2}) {
        WorldSettings settings;
        settings.backend = search.backend.name;
        Lighting lighting = lighting_of(components);
        lighting.depth = depth;
        settings.lighting = lighting;
        const World by_paths = make_world(squares(), settings);
        const std::string what = std::to_string(components) + " components, ";
        expect_the_same_bits(search, by_paths, what + "depth " + std::to_string(depth));
        if (depth != 0) continue;
        lighting.baked = std::make_shared<const BakedLight>(bake_light(by_paths, {.paths = 16}));
        expect_the_same_bits(search, by_paths.with_lighting(lighting), what + "baked");
      }
}

TEST(InstructionSets, WeighSharedRaysAlike) {
  const std::vector<NamedBuild> builds = searches()[0].builds;
  const Eye eye = make_eye(sphere_directions(150), 25 * degree);
  const SharedRays shared = make_shared_rays(eye, make_direction_tables(eye, {}, 5), 0);
  Random random{8};
  std::vector<float> radiance(shared.rays.size() * rgb_bands);
  for (float& value : radiance) value = static_cast<float>(random.uniform());
  std::vector<std::vector<float>> responses;
  for (const NamedBuild& build : builds) {
    responses.emplace_back(eye.size() * rgb_bands, -1.0f);
    const auto count = static_cast<std::int64_t>(eye.size());
    build.block.weigh(omma::view(shared), radiance.data(), rgb_bands, 0, 70,
                      responses.back().data());
    build.block.weigh(omma::view(shared), radiance.data(), rgb_bands, 70, count,
                      responses.back().data());
    EXPECT_EQ(responses.back(), responses.front()) << build.name;
  }
  // And are the sums they should be: of some hundred products, in floats.
  for (std::size_t i = 0; i < eye.size(); ++i)
    for (std::size_t c = 0; c < rgb_bands; ++c) {
      double sum = 0;
      for (auto k = static_cast<std::size_t>(shared.first[i]);
           k < static_cast<std::size_t>(shared.first[i + 1]); ++k)
        sum +=
            static_cast<double>(shared.weight[k]) *
            static_cast<double>(radiance[static_cast<std::size_t>(shared.ray[k]) * rgb_bands + c]);
      EXPECT_NEAR(responses.front()[i * rgb_bands + c], sum, 1e-6);
    }
}

}  // namespace
}  // namespace omma::test
