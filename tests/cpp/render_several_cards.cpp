// Several graphics cards that share what is rendered, by the stand-in driver with two: the bits are
// those of one card and of `portable`, and what goes wrong with one of them is told by its name.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <future>
#include <initializer_list>
#include <numeric>

#include "backend/cuda/compile.h"
#include "backend/cuda/cuda_backend.h"
#include "backend/cuda/share_out.h"
#include "card_errors.h"
#include "emulated/emulated_backend.h"
#include "lit_squares.h"
#include "omma/bake.h"
#include "omma/error.h"
#include "world_tests.h"

namespace omma::test {
namespace {

// Two cards, of which no test leaves one failing.
class SeveralCards : public testing::Test {
 protected:
  void SetUp() override {
    if (is_real_card()) GTEST_SKIP() << "a real driver has the cards that there are";
    setenv("OMMA_EMULATED_CARDS", "2", 1);
  }
  void TearDown() override {
    if (is_real_card()) return;
    make_driver_fail("", 0);
    unsetenv("OMMA_EMULATED_CARDS");
  }
};

World world_on(const std::string& backend, std::vector<int> devices, bool is_lit = false) {
  WorldSettings settings;
  settings.backend = backend;
  settings.devices = std::move(devices);
  if (is_lit) settings.lighting = lighting_of(1);
  return make_world(squares(), settings);
}

World on_both() {
  return world_on("emulated", {0, 1});
}

Eye small_eye() {
  return make_eye(sphere_directions(150), 12 * degree);  // several blocks a pose
}

std::vector<Mat4> several_poses(int count) {
  std::vector<Mat4> poses;
  for (int k = 0; k < count; ++k) poses.push_back(translation({0.1 * k, 0.05 * k, 0.1 * k}));
  return poses;
}

std::vector<float> batch(const Renderer& renderer, int poses = 5) {
  return render(renderer, several_poses(poses)).response;
}

TEST_F(SeveralCards, GiveTheBitsOfOneAndOfPortable) {
  const Eye eye = small_eye();
  for (const bool is_lit : {false, true})
    for (const Sampling& sampling :
         {Sampling(Fixed{4}), Sampling(ToError{.error = 0.05, .most = 64}), Sampling(Shared{4})}) {
      SCOPED_TRACE(testing::Message() << "lit " << is_lit << ", sampling " << sampling.index());
      const auto rendered = [&](const World& world, int poses) {
        const bool with_error = !std::holds_alternative<Fixed>(sampling);
        return render(Renderer(world, eye, {.sampling = sampling}), several_poses(poses),
                      with_error);
      };
      const World portable = world_on("portable", {}, is_lit);
      const World one = world_on("emulated", {0}, is_lit),
                  both = world_on("emulated", {0, 1}, is_lit);
      for (const int poses : {1, 5}) {
        const Result expected = rendered(portable, poses), by_one = rendered(one, poses),
                     by_both = rendered(both, poses);
        EXPECT_EQ(by_one.response, expected.response);
        EXPECT_EQ(by_both.response, expected.response);
        EXPECT_EQ(by_both.standard_error, expected.standard_error);
      }
    }
}

// Each of them at poses of its own, with the rays that it has alone.
TEST_F(SeveralCards, RenderTheEyesOfAPopulation) {
  const Eye all = small_eye();
  const std::vector<std::int32_t> sizes = {70, 20, 60};
  for (const bool is_lit : {false, true}) {
    SCOPED_TRACE(testing::Message() << "lit " << is_lit);
    const auto rendered = [&](const World& world) {
      const std::vector<Mat4> poses = several_poses(6);
      const Renderer renderer(world, all, {.sampling = Fixed{4}, .eye_sizes = sizes});
      std::vector<float> responses(2 * all.size() * static_cast<std::size_t>(world.bands()));
      renderer.render(poses, responses);
      return responses;
    };
    const World portable = world_on("portable", {}, is_lit);
    const std::vector<float> expected = rendered(portable);
    EXPECT_EQ(rendered(world_on("emulated", {0}, is_lit)), expected);
    EXPECT_EQ(rendered(world_on("emulated", {0, 1}, is_lit)), expected);
    std::vector<std::int64_t> of_second(20);
    std::iota(of_second.begin(), of_second.end(), 70);
    const Mat4 pose = several_poses(2)[1];
    const Renderer alone(portable, take_ommatidia(all, of_second), {.sampling = Fixed{4}});
    const std::ptrdiff_t bands = portable.bands();
    EXPECT_EQ(std::vector<float>(expected.begin() + 70 * bands, expected.begin() + 90 * bands),
              render(alone, {&pose, 1}).response);
  }
}

TEST_F(SeveralCards, TakeAnyOrderAndAnyCard) {
  const Eye eye = small_eye();
  const std::vector<float> expected = batch(Renderer(on_both(), eye, {}));
  EXPECT_EQ(batch(Renderer(world_on("emulated", {1, 0}), eye, {})), expected);
  EXPECT_EQ(batch(Renderer(world_on("emulated", {1}), eye, {})), expected);
  EXPECT_EQ(on_both().backend(), "emulated, cuda:0 (emulated card), cuda:1 (emulated card)");
  EXPECT_EQ(world_on("emulated", {1}).backend(), "emulated, cuda:1 (emulated card)");
}

TEST_F(SeveralCards, BakeTheSameLight) {
  const BakeSettings settings{.cell_m = 0.5, .paths = 16};
  const BakedLight expected = bake_light(world_on("portable", {}, true), settings);
  const BakedLight found = bake_light(world_on("emulated", {0, 1}, true), settings);
  ASSERT_EQ(found.lines.size(), expected.lines.size());
  for (std::size_t k = 0; k < expected.lines.size(); ++k)
    ASSERT_EQ(std::memcmp(&found.lines[k], &expected.lines[k], sizeof(BakedLine)), 0) << k;
}

// Each of them has work, and the world renders the same when the error has gone.
TEST_F(SeveralCards, ThatAreLostAreNamed) {
  const Renderer renderer(on_both(), small_eye(), {});
  const std::vector<float> expected = batch(renderer);
  for (const char* const call : {"cuLaunchKernel", "cuMemcpyHtoD", "cuCtxSetCurrent"})
    for (const int card : {0, 1}) {
      make_driver_fail(call, launch_failed, 1000, card);
      const std::string name = "cuda:" + std::to_string(card) + " (emulated card)";
      expect_words(error_of([&] { batch(renderer); }), {name.c_str(), call});
      make_driver_fail("", 0);
      EXPECT_EQ(batch(renderer), expected) << call << " of " << card;
    }
  make_driver_fail("cuLaunchKernel", launch_failed);
  expect_words(error_of([&] { batch(renderer); }), {"cuda:0 (emulated card)"});
  // One pose is the first card's.
  make_driver_fail("cuLaunchKernel", launch_failed, 1000, 1);
  EXPECT_NO_THROW(batch(renderer, 1));
}

TEST_F(SeveralCards, ThatAreFullAreNamed) {
  const Renderer renderer(on_both(), small_eye(), {});
  make_driver_fail("cuMemAlloc", out_of_memory, 1000, 1);
  expect_words(error_of([&] { batch(renderer); }),
               {"cuda:1 (emulated card): expected", "MB of memory", "free of"});
  make_driver_fail("", 0);
  EXPECT_EQ(batch(renderer), batch(Renderer(world_on("portable", {}), small_eye(), {})));
}

TEST_F(SeveralCards, EndWhereTheirWorkIsCancelled) {
  const Renderer renderer(on_both(), small_eye(), {});
  const std::vector<Mat4> poses = several_poses(200);
  std::vector<float> responses(poses.size() * 150 * 3);
  RenderCall call;
  call.progress = [](double) { return false; };
  EXPECT_THROW(renderer.render(poses, responses, call), Cancelled);
  const std::atomic<bool> cancelled = true;
  const TakingPart part(&cancelled);
  std::vector<float> radiance(2), response(2);
  const std::array tasks{WeighTask{&radiance[0], &response[0]},
                         WeighTask{&radiance[1], &response[1]}};
  std::atomic<int> asked = 0;
  const std::array cards{0, 1};
  EXPECT_THROW(share_out(std::span<const int>(cards), std::span<const WeighTask>(tasks),
                         [&](int, std::span<const WeighTask>) {
                           ++asked;
                           check_cancelled();
                         }),
               Cancelled);
  EXPECT_EQ(asked, 2);
}

TEST_F(SeveralCards, AreThoseThatThereAre) {
  const auto asking = [](const std::string& backend, std::vector<int> devices) {
    return error_of([&] { world_on(backend, std::move(devices)); });
  };
  expect_words(asking("emulated", {0, 2}),
               {"devices: expected ordinals below 2, as the driver has cuda:0 (emulated card), "
                "cuda:1 (emulated card); found 2"});
  expect_words(asking("emulated", {-1}), {"devices: expected ordinals below 2", "found -1"});
  expect_words(asking("emulated", {1, 0, 1}), {"devices: expected each card once, found 1 twice"});
  expect_words(asking("portable", {0}),
               {"devices: expected none with the backend \"portable\"", "\"cuda\"", "found 0"});
  const std::vector<CardState> states = card_states();
  ASSERT_EQ(states.size(), 2u);
  EXPECT_EQ(states[1].name, "cuda:1 (emulated card)");
  EXPECT_EQ(states[1].why_not, "");
  make_driver_fail("cuDeviceGetAttribute", launch_failed, 1000, 1);
  EXPECT_EQ(card_states()[0].why_not, "");
  expect_words(card_states()[1].why_not, {"cuda:1 (emulated card)", "cuDeviceGetAttribute"});
}

TEST_F(SeveralCards, HaveMemoryOfTheirOwn) {
  Card first = open_card(card_libraries(), 0), second = open_card(card_libraries(), 1);
  const float sent = 3;
  float back = 0;
  use_card(second);
  load_kernel(second, CardKernel::render);
  const CardPointer at = try_to_allocate(second, sizeof sent);
  copy_to_card(second, at, &sent, sizeof sent);
  use_card(first);
  expect_words(error_of([&] { copy_from_card(first, &back, at, sizeof back); }),
               {"cuda:0 (emulated card)", "cuMemcpyDtoH"});
  expect_words(error_of([&] { run(second, CardKernel::render, 1, {}, nullptr); }),
               {"cuLaunchKernel"});
  use_card(second);
  copy_from_card(second, &back, at, sizeof back);
  EXPECT_EQ(back, sent);
  free_memory(second, at);
}

// The stand-in for the compiler counts.
TEST_F(SeveralCards, OfOneKindCompileOnce) {
  const auto compiled_so_far = [] {
    const std::string cubin = compile_kernels({75, card_libraries().nvrtc}, render_program).cubin;
    return std::stoi(cubin.substr(cubin.rfind(' ') + 1));
  };
  CardLibraries libraries = card_libraries();
  libraries.kernel_cache = testing::TempDir() + "several_cards";
  const int before = compiled_so_far();
  {
    const auto load = [&](int ordinal) {
      Card card = open_card(libraries, ordinal);
      use_card(card);
      load_kernel(card, CardKernel::render);
    };
    const std::future<void> other = std::async(std::launch::async, load, 1);
    load(0);
  }
  EXPECT_EQ(compiled_so_far() - before, 2);  // one of them the question
  std::filesystem::remove_all(libraries.kernel_cache);
}

TEST(CutBetweenPoses, KeepsPosesTogether) {
  std::array<float, 9> responses{};
  for (const int poses : {0, 1, 2, 3, 5, 8})
    for (const int blocks : {1, 2, 7})
      for (const std::size_t cards : {1, 2, 3}) {
        std::vector<BlockTask> tasks(static_cast<std::size_t>(poses * blocks));
        for (std::size_t i = 0; i < tasks.size(); ++i)
          tasks[i].responses = &responses[i / static_cast<std::size_t>(blocks)];
        const auto cut = cut_between_poses(std::span<const BlockTask>(tasks), cards);
        ASSERT_EQ(cut.size(), cards);
        std::size_t begin = 0;
        const std::size_t most = (static_cast<std::size_t>(poses) + cards - 1) / cards *
                                 static_cast<std::size_t>(blocks);
        for (const std::span<const BlockTask> piece : cut) {
          EXPECT_EQ(piece.data(), tasks.data() + begin);
          begin += piece.size();
          EXPECT_LE(piece.size(), most);
          EXPECT_EQ(begin % static_cast<std::size_t>(blocks), 0u);
        }
        EXPECT_EQ(begin, tasks.size());
      }
}

}  // namespace
}  // namespace omma::test
