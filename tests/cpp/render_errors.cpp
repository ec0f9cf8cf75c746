// Wrong arguments are errors that name what is wrong; a render can be cancelled and the renderer
// goes on working.
#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "test_scenes.h"

namespace omma::test {
namespace {

// The message of the omma::Error that `act` throws; "" where it throws none.
template <typename Act>
std::string message_of(Act act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

bool names(const std::string& message, const std::string& what) {
  return message.find(what) != std::string::npos;
}

Scene lit_scene() {
  Scene scene;
  scene.background.type = BackgroundType::simple_sky;
  return scene;
}

TEST(Errors, Settings) {
  const Eye eye = make_eye(Vec3d{0, 0, -1}, 0.1);
  for (const int samples : {0, -1, (1 << 20) + 1, std::numeric_limits<int>::max()}) {
    const std::string message =
        message_of([&] { make_renderer(lit_scene(), eye, {.sampling = Fixed{samples}}); });
    EXPECT_TRUE(names(message, "samples") && names(message, std::to_string(samples))) << message;
  }
  for (const int threads : {-1, 1'000'000})
    EXPECT_TRUE(names(message_of([&] { make_renderer(lit_scene(), eye, {.threads = threads}); }),
                      "threads: expected 0 (all) to "));
  RenderSettings settings;
  settings.background = constant_background({std::numeric_limits<float>::quiet_NaN(), 0, 0});
  EXPECT_TRUE(names(message_of([&] { make_renderer(lit_scene(), eye, settings); }), "background"));
  EXPECT_NE(message_of([&] { Renderer(nullptr, eye); }), "");
}

// Two acceptance angles, so that tables of directions would be too large and each direction is made
// where it is needed. In the plane the horizon's half of a Gaussian raises the mean elevation to
// sigma / sqrt(2 pi); the sphere's curvature changes that by sigma^2, which is 1e-5 of radiance.
TEST(Errors, MostSamplesAreAllowed) {
  Eye eye = make_eye(Vec3d{0, 0, -1}, 0.1, 2);
  eye.acceptance_angle_rad[1] = 0.2f;
  const Result result = render(lit_scene(), eye, {.sampling = Fixed{max_samples}});
  const double horizon = 143 / 255.0 * 0.8, zenith = 1 / 255.0;
  for (std::size_t i = 0; i < 2; ++i) {
    const double sigma = eye.acceptance_angle_rad[i] / 2.35482;
    const double up = sigma / std::sqrt(2 * pi) / (pi / 2);
    EXPECT_NEAR(result.at(i), horizon + up * (zenith - horizon), 1e-4);
  }
}

TEST(Errors, ScenesAndEyesAreChecked) {
  Scene scene = lit_scene();
  add_instance(scene, 3);
  EXPECT_NE(message_of([&] { make_renderer(scene, make_eye(Vec3d{0, 0, -1}, 0.1)); }), "");
  EXPECT_NE(message_of([&] { make_renderer(lit_scene(), Eye{}); }), "");
  EXPECT_NE(message_of([&] { make_renderer(lit_scene(), make_eye(Vec3d{0, 0, 0}, 0.1)); }), "");
  EXPECT_NE(message_of([&] { make_renderer(lit_scene(), make_eye(Vec3d{0, 0, -1}, 7)); }), "");
  EXPECT_NE(message_of([&] { make_renderer(lit_scene(), make_eye(Vec3d{0, 0, -1}, -1)); }), "");
}

TEST(Errors, OutputsOfTheWrongSize) {
  const Renderer renderer = make_renderer(lit_scene(), make_eye(Vec3d{0, 0, -1}, 0.1, 5));
  const std::vector<Mat4> poses(2);
  for (const std::size_t size : {0u, 29u, 31u, 15u}) {
    std::vector<float> output(size);
    const std::string message = message_of([&] { renderer.render(poses, output); });
    EXPECT_TRUE(names(message, "responses") && names(message, "30")) << message;
  }
  std::vector<float> output(30), error(29);
  RenderCall call;
  call.standard_error = error;
  EXPECT_TRUE(names(message_of([&] { renderer.render(poses, output, call); }), "standard_error"));
}

TEST(Errors, PosesMustBeFiniteAndInvertible) {
  const Renderer renderer = make_renderer(lit_scene(), make_eye(Vec3d{0, 0, -1}, 0.1));
  std::vector<float> output(3 * rgb_bands);
  std::vector<Mat4> bad(7);
  bad[0] = scaling({1, 0, 1});
  bad[1].m[0][3] = std::numeric_limits<double>::quiet_NaN();
  bad[2].m[1][1] = std::numeric_limits<double>::infinity();
  bad[3].m[3][0] = 1;
  bad[4].m[3][3] = 2;
  bad[5] = scaling({0, 0, 0});
  for (int k = 0; k < 3; ++k) bad[6].m[1][k] = 2 * bad[6].m[0][k];  // two rows alike
  for (const Mat4& pose : bad) {
    const std::vector<Mat4> poses = {Mat4{}, Mat4{}, pose};
    const std::string message = message_of([&] { renderer.render(poses, output); });
    EXPECT_TRUE(names(message, "[2]")) << "expected the place of the pose: " << message;
  }
}

TEST(Errors, NothingToDoIsNoError) {
  const std::vector<Mat4> none;
  const Renderer renderer = make_renderer(lit_scene(), make_eye(Vec3d{0, 0, -1}, 0.1));
  EXPECT_TRUE(render(renderer, none).response.empty());
  // An empty scene is legal: only background.
  EXPECT_EQ(render(Scene{}, make_eye(Vec3d{0, 0, -1}, 0.1)).at(0), 0);
}

TEST(Cancel, ThrowsAndTheNextRenderWorks) {
  const Renderer renderer =
      make_renderer(flat_triangles(1, 50), make_eye(sphere_directions(2000), 5 * degree),
                    {.sampling = Fixed{256}});
  const std::vector<Mat4> poses(20);
  std::vector<float> output(poses.size() * renderer.eye().size() * rgb_bands);
  int calls = 0;
  RenderCall call;
  call.progress = [&](double) { return ++calls < 2; };
  EXPECT_THROW(renderer.render(poses, output, call), Cancelled);
  EXPECT_EQ(calls, 2);
  const Mat4 pose;
  const Result after = render(renderer, std::span(&pose, 1));
  const Result fresh =
      render(make_renderer(flat_triangles(1, 50), renderer.eye(), renderer.settings()),
             std::span(&pose, 1));
  EXPECT_EQ(after.response, fresh.response);
}

// A callback that throws is the caller's way out too.
TEST(Cancel, ExceptionsOfTheCallbackPassThrough) {
  const Renderer renderer =
      make_renderer(lit_scene(), make_eye(sphere_directions(100), 5 * degree));
  const std::vector<Mat4> poses(1);
  std::vector<float> output(poses.size() * renderer.eye().size() * rgb_bands);
  RenderCall call;
  call.progress = [](double) -> bool { throw std::out_of_range("mine"); };
  EXPECT_THROW(renderer.render(poses, output, call), std::out_of_range);
}

TEST(Progress, RisesToOneFromTheCallingThread) {
  const Renderer renderer =
      make_renderer(flat_triangles(1, 50), make_eye(sphere_directions(2000), 5 * degree),
                    {.sampling = Fixed{64}});
  const std::vector<Mat4> poses(50);
  std::vector<float> output(poses.size() * renderer.eye().size() * rgb_bands);
  std::vector<double> shares;
  bool same_thread = true;
  const auto caller = std::this_thread::get_id();
  RenderCall call;
  call.progress = [&](double share) {
    shares.push_back(share);
    same_thread = same_thread && std::this_thread::get_id() == caller;
    return true;
  };
  renderer.render(poses, output, call);
  ASSERT_FALSE(shares.empty());
  for (std::size_t i = 1; i < shares.size(); ++i) EXPECT_GT(shares[i], shares[i - 1]);
  EXPECT_EQ(shares.back(), 1);
  EXPECT_TRUE(same_thread);
}

TEST(Renderer, ServesSeveralCallersAtOnce) {
  const Renderer renderer = make_renderer(
      flat_triangles(1, 50), make_eye(sphere_directions(300), 5 * degree), {.threads = 2});
  const std::vector<Mat4> poses(4);
  const Result alone = render(renderer, poses);
  std::vector<Result> together(3);
  std::vector<std::thread> callers;
  for (Result& result : together) callers.emplace_back([&] { result = render(renderer, poses); });
  for (std::thread& caller : callers) caller.join();
  for (const Result& result : together) EXPECT_EQ(result.response, alone.response);
}

}  // namespace
}  // namespace omma::test
