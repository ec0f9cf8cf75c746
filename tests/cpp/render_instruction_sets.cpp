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
  WeighRays weigh;
};

std::vector<NamedBuild> runnable_builds() {
  std::vector<NamedBuild> builds = {{"baseline", baseline::render_block, baseline::weigh_rays}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2"))
    builds.push_back({"avx2", avx2::render_block, avx2::weigh_rays});
  if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512bw"))
    builds.push_back({"avx512", avx512::render_block, avx512::weigh_rays});
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
    const auto tracer = make_embree_tracer(scene, shading->view, placement_of(scene));
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

TEST(InstructionSets, WeighSharedRaysAlike) {
  const std::vector<NamedBuild> builds = runnable_builds();
  if (builds.size() == 1) GTEST_SKIP() << "this processor runs the baseline only";
  const Eye eye = make_eye(sphere_directions(150), 25 * degree);
  RenderSettings settings;
  settings.samples = 5;
  const SharedRays shared = make_shared_rays(eye, make_direction_tables(eye, settings), 0);
  Random random{8};
  std::vector<float> radiance(shared.rays.size() * channel_count);
  for (float& value : radiance) value = static_cast<float>(random.uniform());
  std::vector<std::vector<float>> responses;
  for (const NamedBuild& build : builds) {
    responses.emplace_back(eye.size() * channel_count, -1.0f);
    const auto count = static_cast<std::int64_t>(eye.size());
    build.weigh(shared, radiance.data(), 0, 70, responses.back().data());
    build.weigh(shared, radiance.data(), 70, count, responses.back().data());
    EXPECT_EQ(responses.back(), responses.front()) << build.name;
  }
  // And are the sums they should be: of some hundred products, in floats.
  for (std::size_t i = 0; i < eye.size(); ++i)
    for (std::size_t c = 0; c < channel_count; ++c) {
      double sum = 0;
      for (auto k = static_cast<std::size_t>(shared.first[i]);
           k < static_cast<std::size_t>(shared.first[i + 1]); ++k)
        sum += static_cast<double>(shared.weight[k]) *
               static_cast<double>(
                   radiance[static_cast<std::size_t>(shared.ray[k]) * channel_count + c]);
      EXPECT_NEAR(responses.front()[i * channel_count + c], sum, 1e-6);
    }
}

}  // namespace
}  // namespace omma::test
