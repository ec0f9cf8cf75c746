// Renderers with any numbers of threads side by side: the numbers asked for are used, the bits are
// the same, and nothing is printed (oneTBB warns on stderr where an arena asks for more threads
// than its limit allows).
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "omma/camera.h"
#include "test_scenes.h"
#include "threads/parallel.h"

namespace omma::test {
namespace {

TEST(Threads, NumbersMixWithoutAWord) {
  const Scene scene = flat_triangles(5, 60);
  const Eye eye = make_eye(sphere_directions(300), 5 * degree);
  const Mat4 pose;
  Camera camera;
  camera.type = CameraType::panoramic;
  std::vector<float> picture(64 * 32 * rgb_bands);
  testing::internal::CaptureStderr();
  std::vector<Renderer> renderers;
  std::vector<std::vector<float>> responses;
  for (const int threads : {3, 1, 64, 2, 7, 50, 0, 63}) {
    renderers.push_back(make_renderer(scene, eye, {.sampling = Fixed{16}, .threads = threads}));
    if (threads > 0) {
      EXPECT_EQ(renderers.back().threads(), threads);
    }
    render_camera(renderers.back().world(), camera, {{64, 32}, 1, 0}, picture);
    // All that there are render again: their arenas were made under lower limits.
    for (const Renderer& renderer : renderers)
      responses.push_back(render(renderer, std::span(&pose, 1)).response);
    if (threads == 64) renderers.erase(renderers.begin());
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  for (const std::vector<float>& response : responses)
    EXPECT_TRUE(same_bits(response, responses.front()));
}

// What a loop of one thread has not done is not taken for done where another thread's has failed,
// as cells of baked light would be whose launch was cut short.
TEST(Threads, ALoopThatIsEndedByAnotherSaysSo) {
  std::atomic<bool> has_begun{false}, ended_early{false};
  const auto failing = [&] {
    for (int k = 0; k < 10000 && !has_begun; ++k)  // where there is no other thread, a second
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    throw Error("on purpose");
  };
  const auto working = [&] {
    std::atomic<int> done{0};
    parallel_for(0, 10000, [&](int) {
      has_begun = true;
      std::this_thread::sleep_for(std::chrono::microseconds(100));
      ++done;
    });
    ended_early = done < 10000;
  };
  oneapi::tbb::task_arena arena(2);
  EXPECT_THROW(
      run_in_arena(arena,
                   [&] { parallel_for(0, 2, [&](int i) { i == 0 ? failing() : working(); }); }),
      Error);
  EXPECT_FALSE(ended_early);
}

}  // namespace
}  // namespace omma::test
