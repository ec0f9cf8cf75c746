// Rays that would start further away than can be traced are refused, whatever sends them there, and
// poses count as they were when the render began.
#include <gtest/gtest.h>

#include "omma/camera.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

template <typename Act>
std::string message_of(Act act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

Scene walled_scene() {
  Scene scene;
  add_instance(scene, add_mesh(scene, cube_seen_from_inside(2, add_color(scene, {1, 1, 1}))));
  return scene;
}

// Embree's own bound is 1.844e18; its packets refuse rays beyond, by ending the process.
constexpr double too_far_m = 2e18;

std::string message_at(const Eye& eye, const Mat4& pose, RenderSettings settings = {}) {
  const Renderer renderer = make_renderer(walled_scene(), eye, settings);
  const std::vector<Mat4> poses = {Mat4{}, pose};
  std::vector<float> responses(2 * eye.size() * rgb_bands);
  return message_of([&] { renderer.render(poses, responses); });
}

void expect_refused(const std::string& message, const std::string& found, int pose = 1) {
  const std::string place = "poses[" + std::to_string(pose) + "]: expected";
  EXPECT_NE(message.find(place), std::string::npos) << message;
  EXPECT_NE(message.find("found"), std::string::npos) << message;
  EXPECT_NE(message.find(found), std::string::npos) << message;
}

TEST(FarRays, OfAPoseAreRefused) {
  const Eye eye = make_eye(sphere_directions(20), 0.1);
  for (const double sign : {-1.0, 1.0})
    for (const Vec3d away : {Vec3d{too_far_m, 0, 0}, {0, too_far_m, 0}, {0, 0, too_far_m}})
      expect_refused(message_at(eye, translation(away * sign)), "2e+18");
  expect_refused(message_at(eye, translation({0, 1e300, 0})), "1e+300");
  const RenderSettings shared{.sampling = Shared{}};
  expect_refused(
      message_at(make_eye(sphere_directions(500), 0.2), translation({too_far_m, 0, 0}), shared),
      "2e+18");
}

TEST(FarRays, OfAnEyeAtAPoseAreRefused) {
  // Each alone can be traced; together they cannot.
  const Mat4 larger = scaling({1e9, 1e9, 1e9});
  Eye eye = make_eye(sphere_directions(20), 0.1);
  EXPECT_EQ(message_at(eye, larger), "");
  eye.position_m[7] = {0, 3e9f, 0};
  EXPECT_EQ(message_at(eye, {}), "");
  expect_refused(message_at(eye, larger), "3e+18");
  eye.position_m[7] = {0, 0, 0};
  eye.focal_offset_m[3] = 4e9f;
  EXPECT_EQ(message_at(eye, {}), "");
  expect_refused(message_at(eye, larger), "e+");
  eye.focal_offset_m[3] = 0;
  eye.aperture_diameter_m[2] = 1e10f;
  EXPECT_EQ(message_at(eye, {}), "");
  expect_refused(message_at(eye, larger), "e+");
  // Numbers whose products are not finite in single precision.
  eye.aperture_diameter_m[2] = 3e38f;
  expect_refused(message_at(eye, larger), "e+38", 0);
  eye = make_eye(sphere_directions(20), 0.1);
  eye.position_m[7] = {3e38f, 3e38f, 3e38f};
  expect_refused(message_at(eye, larger), "3e+38", 0);
}

// Rays of a stretched eye need directions: squares of what the pose makes of an axis are floats.
TEST(FarRays, PosesThatStretchBeyondSinglePrecisionAreRefused) {
  const Eye eye = make_eye(sphere_directions(200), 0.1);
  for (const Vec3d scale : {Vec3d{1e20, 1e20, 1e20},
                            {1e-20, 1e-20, 1e-20},
                            {1, 1e-9, 1e-9},
                            {1e12, 1, 1},
                            {1e200, 1e200, 1e200},
                            {1e-200, 1e-200, 1e-200}})
    expect_refused(message_at(eye, scaling(scale)), "e");
  // And those within bounds give directions: a surround of 1 gives 1.
  for (const Vec3d scale : {Vec3d{1e-14, 1e-14, 1e-14}, {1, 1e-4, 1e-4}, {1e4, 1, 1}, {1, 1, 1}}) {
    const Mat4 pose = rotation({0.6, 0, 0.8}, 1) * scaling(scale) * rotation({0, 1, 0}, 0.4);
    const Result result = render(walled_scene(), eye, {.sampling = Fixed{4}}, pose);
    for (const float value : result.response) EXPECT_NEAR(value, 1, 1e-6);
  }
}

TEST(FarRays, OfACameraAreRefused) {
  const World world = make_world(walled_scene());
  std::vector<float> picture(4 * 4 * rgb_bands);
  const CameraSettings settings{{4, 4}, 1, 0};
  Camera camera;
  camera.name = "far";
  camera.type = CameraType::panoramic;
  camera.world_from_camera = translation({0, 0, too_far_m});
  const auto refused = [&] {
    return message_of([&] { render_camera(world, camera, settings, picture); });
  };
  EXPECT_NE(refused().find("far"), std::string::npos) << refused();
  camera.world_from_camera = {};
  camera.type = CameraType::orthographic;
  camera.xmag_m = 1, camera.ymag_m = too_far_m;
  EXPECT_NE(refused().find("far"), std::string::npos) << refused();
  camera.ymag_m = 1;
  EXPECT_EQ(refused(), "");
}

// The caller moves its poses to where no ray can start while the render runs: from the progress
// callback, after which it goes on with the stretch that follows.
TEST(FarRays, PosesCountAsTheyWereWhenTheRenderBegan) {
  const Eye eye = make_eye(sphere_directions(400), 5 * degree);
  const Renderer renderer =
      make_renderer(flat_triangles(3, 60), eye, {.sampling = Fixed{256}, .threads = 1});
  const std::vector<Mat4> given = turning_poses(60);
  const Result expected = render(renderer, given);
  for (const Sampling& sampling : {Sampling(Fixed{256}), Sampling(Shared{16})}) {
    const Renderer other(renderer, eye, {.sampling = sampling, .threads = 1});
    const Result undisturbed = render(other, given);
    std::vector<Mat4> poses = given;
    std::vector<float> responses(undisturbed.response.size());
    RenderCall call;
    int calls = 0;
    call.progress = [&](double) {
      ++calls;
      for (Mat4& pose : poses) pose = translation({0, 1e30, 0});
      return true;
    };
    other.render(poses, responses, call);
    EXPECT_GT(calls, 1);
    EXPECT_TRUE(same_bits(responses, undisturbed.response));
  }
}

}  // namespace
}  // namespace omma::test
