// What can go wrong between Omma and a graphics card, by a driver that stands for NVIDIA's and
// fails where it is told to (emulated/driver.cpp): each call's error is an omma::Error that names
// it, and the card renders the same as before when the error has gone.
#include <gtest/gtest.h>

#include <functional>

#include "backend/cuda/card_outputs.h"
#include "backend/cuda/cuda_backend.h"
#include "card_errors.h"
#include "emulated/emulated_backend.h"
#include "omma/error.h"
#include "world_tests.h"

namespace omma::test {
namespace {

World squares_on_card() {
  WorldSettings settings;
  settings.backend = "emulated";
  return make_world(flat_triangles(1, 10), settings);
}

// No test leaves the driver failing.
class CardErrors : public testing::Test {
 protected:
  void SetUp() override {
    if (is_real_card()) GTEST_SKIP() << "a real driver does not fail when it is asked to";
  }
  ~CardErrors() override {
    if (is_real_card()) return;
    make_driver_fail("", 0);
    limit_card_memory(0);
  }
};

TEST_F(CardErrors, OfOpeningSayWhatIsMissing) {
  const CardLibraries libraries = card_libraries();
  const auto opening = [&](CardLibraries changed) {
    return error_of([&] { (void)open_card(changed, 0); });
  };
  CardLibraries none = libraries;
  none.driver = "libno_such_driver.so.1";
  expect_words(opening(none), {"expected NVIDIA's driver, found none", "libno_such_driver.so.1"});
  none.driver = "libm.so.6";
  expect_words(opening(none), {"libm.so.6", "cuInit", "update"});
  make_driver_fail("cuDriverGetVersion", 1);
  expect_words(opening(libraries), {"CUDA 12.0 or newer", "CUDA 11.4"});
  make_driver_fail("cuDeviceGetCount", 1);
  expect_words(opening(libraries), {"found a driver without one"});
}

TEST_F(CardErrors, OfOpeningNameTheCall) {
  for (const char* const call :
       {"cuInit", "cuDeviceGet", "cuDeviceGetName", "cuDeviceGetAttribute",
        "cuDevicePrimaryCtxRetain", "cuCtxSetCurrent", "cuModuleLoadData", "cuModuleGetFunction",
        "cuOccupancyMaxActiveBlocksPerMultiprocessor"}) {
    make_driver_fail(call, launch_failed);
    expect_words(error_of([] {
                   Card card = open_card(card_libraries(), 0);
                   use_card(card);
                   load_kernel(card, CardKernel::render);
                 }),
                 {call, "CUDA_ERROR_LAUNCH_FAILED", "cuda"});
  }
}

TEST_F(CardErrors, OfRenderingNameTheCallAndLeaveNothingBehind) {
  const World world = squares_on_card();
  const Renderer renderer(world, make_eye(sphere_directions(100), 12 * degree), {});
  const std::vector<float> expected = seen(renderer);
  for (const char* const call : {"cuCtxSetCurrent", "cuMemcpyHtoD", "cuMemcpyDtoH",
                                 "cuLaunchKernel", "cuStreamSynchronize"}) {
    make_driver_fail(call, launch_failed);
    expect_words(error_of([&] { seen(renderer); }),
                 {"cuda:0 (emulated card)", call, "started anew"});
    make_driver_fail("", 0);
    EXPECT_EQ(seen(renderer), expected) << call;
  }
}

TEST_F(CardErrors, OfMemorySayHowMuchIsThere) {
  const World world = squares_on_card(), other = squares_on_card();
  const Eye eye = make_eye(sphere_directions(100), 12 * degree);
  const Renderer renderer(world, eye, {}), of_other(other, eye, {});
  const std::vector<float> expected = seen(renderer);
  make_driver_fail("cuMemAlloc", out_of_memory);
  expect_words(error_of([&] { seen(of_other); }),
               {"cuda:0 (emulated card): expected", "MB of memory", "free of", "smaller scene"});
  make_driver_fail("", 0);
  EXPECT_EQ(seen(of_other), expected);
  EXPECT_EQ(seen(renderer), expected);
}

// What had been rendered when a card was lost stays where it was written.
TEST_F(CardErrors, InTheMiddleLeaveWhatIsFinished) {
  constexpr std::size_t poses = 40;
  const World world = squares_on_card();
  const Eye eye = make_eye(sphere_directions(1000), 12 * degree);
  const Renderer renderer(world, eye, {});
  std::vector<float> responses(poses * eye.size() * 3, -1.f);
  double finished = 0;
  RenderCall call;
  call.progress = [&](double fraction) {
    finished = fraction;
    make_driver_fail("cuLaunchKernel", launch_failed);
    return true;
  };
  expect_words(error_of([&] { renderer.render(std::vector<Mat4>(poses), responses, call); }),
               {"cuda:0 (emulated card)", "cuLaunchKernel"});
  make_driver_fail("", 0);
  ASSERT_GT(finished * poses, 1);
  ASSERT_LT(finished, 1);
  EXPECT_EQ(std::vector(responses.begin(), responses.begin() + 3000), seen(renderer));
  EXPECT_EQ(responses.back(), -1.f);
}

// What a launch needs does not grow with the batch: its responses alone are twice what is there.
TEST_F(CardErrors, OfMemoryAreNoneWhereABatchIsLarge) {
  constexpr std::size_t ommatidia = 500, poses = 3000, memory = std::size_t{8} << 20;
  const World world = squares_on_card();
  const Renderer renderer(world, make_eye(sphere_directions(ommatidia), 12 * degree),
                          {.sampling = Fixed{1}});
  std::vector<float> responses(poses * ommatidia * 3);
  limit_card_memory(memory);
  renderer.render(std::vector<Mat4>(poses), responses);
  EXPECT_GE(responses.size() * sizeof(float), 2 * memory);
  EXPECT_EQ(std::vector(responses.end() - 3 * ommatidia, responses.end()), seen(renderer));
}

// Where memory is short what other worlds have left there is given up, and copied again for them.
TEST_F(CardErrors, OfMemoryAreNoneWhereSomethingCanBeGivenUp) {
  const World world = squares_on_card(), other = squares_on_card();
  const Eye eye = make_eye(sphere_directions(100), 12 * degree);
  const Renderer renderer(world, eye, {}), of_other(other, eye, {});
  const std::vector<float> expected = seen(renderer);
  take_kept_bytes();
  EXPECT_EQ(seen(renderer), expected);
  EXPECT_EQ(take_kept_bytes(), 0u);
  make_driver_fail("cuMemAlloc", out_of_memory, 1);
  EXPECT_EQ(seen(of_other), expected);
  take_kept_bytes();
  EXPECT_EQ(seen(renderer), expected);
  EXPECT_GT(take_kept_bytes(), 0u);
}

// What lies on the card is written there: nothing of it is on the host.
TEST(CardOutputs, AreWrittenWhereTheyAre) {
  const World world = squares_on_card();
  const Renderer renderer(world, make_eye(sphere_directions(100), 12 * degree), {});
  const std::vector<float> expected = seen(renderer);
  const std::size_t bytes = expected.size() * sizeof(float);
  const CardPointer at = allocate_on_card(0, bytes);
  EXPECT_EQ(card_of(at), 0);
  {
    const CardOutputs outputs({{at, bytes}});
    renderer.render({{Mat4()}}, {reinterpret_cast<float*>(at), expected.size()});
  }
  std::vector<float> found(expected.size());
  read_from_card(0, found.data(), at, bytes);
  free_on_card(0, at);
  EXPECT_EQ(found, expected);
  EXPECT_THROW(card_of(reinterpret_cast<CardPointer>(found.data())), Error);
}

}  // namespace
}  // namespace omma::test
