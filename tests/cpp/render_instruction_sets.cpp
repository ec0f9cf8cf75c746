// The hot loop is built once per instruction set. Whichever a processor gets, the responses are the
// same to the last bit: no contraction to fused multiply-add, the same steps for any lane width.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "backend/embree/block.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

struct NamedBuild {
  std::string name;
  RenderBlock render;
};

std::vector<NamedBuild> runnable_builds() {
  std::vector<NamedBuild> builds = {{"baseline", baseline::render_block}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) builds.push_back({"avx2", avx2::render_block});
  if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512bw"))
    builds.push_back({"avx512", avx512::render_block});
#endif
  return builds;
}

TEST(InstructionSets, GiveTheSameBits) {
  const std::vector<NamedBuild> builds = runnable_builds();
  if (builds.size() == 1) GTEST_SKIP() << "this processor runs the baseline only";
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
    RenderSettings settings;
    settings.samples = 21;  // not a multiple of any lane width
    const auto shading = make_shading_data(scene);
    const BackgroundData background = make_background_data(scene.background);
    SceneView view = shading->view;
    view.background = background.view;
    const auto tracer = make_embree_tracer(scene, shading->view);
    const DirectionTables directions = make_direction_tables(eye, settings);
    const EyeArrays arrays = make_eye_arrays(eye, directions);
    const BlockContext context{tracer.get(), &view, &arrays, &directions, 1};
    std::vector<std::vector<float>> responses;
    for (const NamedBuild& build : builds) {
      responses.emplace_back(eye.size() * channel_count, -1.0f);
      BlockTask task;
      for (int i = 0; i < 3; ++i) task.world_from_head[i][i] = 1;
      task.count = static_cast<int>(eye.size());
      task.responses = responses.back().data();
      build.render(context, task);
      EXPECT_EQ(responses.back(), responses.front()) << build.name << ", scene " << seed;
    }
  }
}

}  // namespace
}  // namespace omma::test
