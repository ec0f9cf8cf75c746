// Rays and sizes of cameras against the definitions of glTF 2.0 (3.10.2 and 3.10.3), and which
// camera a name or an index means.
#include "omma/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "omma/error.h"

namespace {

using omma::Camera;
using omma::camera_ray;
using omma::camera_rays;
using omma::CameraRay;
using omma::CameraType;
using omma::Error;
using omma::Eye;
using omma::normalize;
using omma::pi;
using omma::picture_size;
using omma::PictureSize;
using omma::Vec3d;

Camera camera_of(CameraType type) {
  Camera camera;
  camera.name = "it";
  camera.type = type;
  camera.yfov_rad = 1.2;
  camera.aspect_ratio = 1.5;
  camera.xmag_m = 3;
  camera.ymag_m = 2;
  return camera;
}

// A few roundings in double.
constexpr double rounding = 1e-14;

void expect_near(Vec3d found, Vec3d expected, double tolerance = rounding) {
  EXPECT_NEAR(found.x, expected.x, tolerance);
  EXPECT_NEAR(found.y, expected.y, tolerance);
  EXPECT_NEAR(found.z, expected.z, tolerance);
}

TEST(CameraRay, PerspectiveCornersAreThoseOfItsAngles) {
  const Camera camera = camera_of(CameraType::perspective);
  const double half_height = std::tan(0.6), half_width = 1.5 * half_height;
  // The aspect ratio holds whatever the pixels' shape.
  for (const PictureSize size : {PictureSize{300, 200}, PictureSize{100, 400}}) {
    const double w = size.width, h = size.height;
    expect_near(camera_ray(camera, size, 0, 0).direction,
                normalize({-half_width, half_height, -1}));
    expect_near(camera_ray(camera, size, w, 0).direction, normalize({half_width, half_height, -1}));
    expect_near(camera_ray(camera, size, 0, h).direction,
                normalize({-half_width, -half_height, -1}));
    expect_near(camera_ray(camera, size, w / 2, h / 2).direction, {0, 0, -1});
    expect_near(camera_ray(camera, size, 0, 0).origin_m, {0, 0, 0});
    const Vec3d top = camera_ray(camera, size, w / 2, 0).direction;
    EXPECT_NEAR(std::atan2(top.y, -top.z), 0.6, rounding);  // half of yfov
  }
}

TEST(CameraRay, PerspectiveWithoutAspectTakesThatOfThePicture) {
  Camera camera = camera_of(CameraType::perspective);
  camera.aspect_ratio = 0;
  const double half = std::tan(0.6);
  expect_near(camera_ray(camera, {500, 200}, 500, 100).direction, normalize({2.5 * half, 0, -1}));
  expect_near(camera_ray(camera, {100, 200}, 100, 100).direction, normalize({0.5 * half, 0, -1}));
}

TEST(CameraRay, OrthographicStartsInTheCamerasPlane) {
  const Camera camera = camera_of(CameraType::orthographic);
  const PictureSize size{60, 10};
  expect_near(camera_ray(camera, size, 0, 0).origin_m, {-3, 2, 0});
  expect_near(camera_ray(camera, size, 60, 10).origin_m, {3, -2, 0});
  expect_near(camera_ray(camera, size, 45, 5).origin_m, {1.5, 0, 0});
  expect_near(camera_ray(camera, size, 45, 5).direction, {0, 0, -1});
}

TEST(CameraRay, PanoramaHasAheadInTheMiddle) {
  const Camera camera = camera_of(CameraType::panoramic);
  const PictureSize size{360, 180};
  const auto at = [&](double azimuth_deg, double elevation_deg) {
    return camera_ray(camera, size, azimuth_deg + 180, 90 - elevation_deg).direction;
  };
  expect_near(at(0, 0), {0, 0, -1});
  expect_near(at(90, 0), {1, 0, 0});
  expect_near(at(-90, 0), {-1, 0, 0});
  expect_near(at(180, 0), {0, 0, 1});
  expect_near(at(0, 90), {0, 1, 0});
  expect_near(at(77, -90), {0, -1, 0});
  expect_near(at(30, 45), {0.5 * std::sqrt(0.5), std::sqrt(0.5), -0.75 * std::sqrt(2.0 / 3)});
}

TEST(CameraRays, GoRowByRowFromTheTop) {
  for (const CameraType type :
       {CameraType::perspective, CameraType::orthographic, CameraType::panoramic}) {
    const Camera camera = camera_of(type);
    const PictureSize size{7, 5};
    const Eye eye = camera_rays(camera, size, 2, 3, {0.25f, 0.5f});
    ASSERT_EQ(eye.size(), 21u);
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 7; ++column) {
        const auto i = static_cast<std::size_t>(7 * row + column);
        const CameraRay ray = camera_ray(camera, size, column + 0.25, row + 2.5);
        // Rounded to float once.
        expect_near(to_double(eye.axis[i]), ray.direction, 6e-8);
        expect_near(to_double(eye.position_m[i]), ray.origin_m, 2e-7);
        EXPECT_EQ(eye.acceptance_angle_rad[i], 0);
        EXPECT_EQ(eye.focal_offset_m[i], 0);
      }
  }
}

TEST(CameraRays, RefuseWhatHasNoPicture) {
  const PictureSize size{4, 3};
  const auto refused = [&](void (*change)(Camera&), CameraType type = CameraType::perspective) {
    Camera camera = camera_of(type);
    change(camera);
    try {
      camera_rays(camera, size, 0, 3);
    } catch (const Error& error) {
      return std::string(error.what()).starts_with("camera \"it\": ");
    }
    return false;
  };
  EXPECT_TRUE(refused([](Camera& c) { c.type = CameraType::compound; }));
  EXPECT_TRUE(refused([](Camera& c) { c.yfov_rad = 0; }));
  EXPECT_TRUE(refused([](Camera& c) { c.yfov_rad = pi; }));
  EXPECT_TRUE(refused([](Camera& c) { c.aspect_ratio = -1; }));
  EXPECT_TRUE(refused([](Camera& c) { c.aspect_ratio = std::nan(""); }));
  EXPECT_TRUE(refused([](Camera& c) { c.xmag_m = 0; }, CameraType::orthographic));
  EXPECT_TRUE(refused([](Camera& c) { c.ymag_m = std::nan(""); }, CameraType::orthographic));
  EXPECT_TRUE(refused([](Camera& c) { c.world_from_camera.m[1][1] = 0; }, CameraType::panoramic));
  EXPECT_FALSE(refused([](Camera& c) { c.yfov_rad = 0; }, CameraType::panoramic));
  const Camera camera = camera_of(CameraType::perspective);
  EXPECT_THROW(camera_rays(camera, size, 0, 4), Error);
  EXPECT_THROW(camera_rays(camera, size, -1, 2), Error);
  EXPECT_THROW(camera_rays(camera, size, 0, 0), Error);
  EXPECT_THROW(camera_rays(camera, {0, 3}, 0, 1), Error);
}

TEST(PictureSize, HasSquarePixels) {
  const auto size_of = [](Camera camera, int width, int height) {
    const PictureSize size = picture_size(camera, width, height);
    return std::pair(size.width, size.height);
  };
  using Size = std::pair<int, int>;
  Camera camera = camera_of(CameraType::perspective);  // 3 to 2
  EXPECT_EQ(size_of(camera, 0, 0), Size(1024, 683));
  EXPECT_EQ(size_of(camera, 300, 0), Size(300, 200));
  EXPECT_EQ(size_of(camera, 0, 100), Size(150, 100));
  EXPECT_EQ(size_of(camera, 11, 99), Size(11, 99));  // as asked for
  camera.aspect_ratio = 0;
  EXPECT_EQ(size_of(camera, 0, 0), Size(1024, 768));
  EXPECT_EQ(size_of(camera_of(CameraType::orthographic), 300, 0), Size(300, 200));
  EXPECT_EQ(size_of(camera_of(CameraType::panoramic), 0, 0), Size(1024, 512));
  EXPECT_EQ(size_of(camera_of(CameraType::compound), 0, 0), Size(1024, 512));
  camera.aspect_ratio = 1e9;
  EXPECT_EQ(size_of(camera, 0, 0), Size(1024, 1));
  camera.aspect_ratio = 1e-9;
  EXPECT_EQ(size_of(camera, 0, 0), Size(1024, omma::max_picture_extent));
  EXPECT_THROW(picture_size(camera, -1, 0), Error);
  EXPECT_THROW(picture_size(camera, 0, omma::max_picture_extent + 1), Error);
}

TEST(ChooseCamera, ByNameThenByIndex) {
  omma::Scene scene;
  scene.path = "made.gltf";
  for (const char* name : {"front", "2", "side", "twin", "twin"}) {
    Camera camera;
    camera.name = name;
    camera.data_name = "data" + std::to_string(scene.cameras.size());
    scene.cameras.push_back(camera);
  }
  scene.cameras[0].data_name = "lens";
  const auto index_of = [&](const char* text) {
    return &omma::choose_camera(scene, text) - scene.cameras.data();
  };
  EXPECT_EQ(index_of("front"), 0);
  EXPECT_EQ(index_of("lens"), 0);
  EXPECT_EQ(index_of("0"), 0);
  EXPECT_EQ(index_of("2"), 1);  // a name before an index
  EXPECT_EQ(index_of("3"), 3);
  EXPECT_EQ(index_of("4"), 4);
  for (const char* missing : {"back", "5", "-1", "", "1.0", " 1", "99999999999999999999"}) {
    try {
      index_of(missing);
      ADD_FAILURE() << missing;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()),
                "made.gltf: there is no camera \"" + std::string(missing) +
                    "\"; there are 0 \"front\", 1 \"2\", 2 \"side\", 3 \"twin\", 4 \"twin\"");
    }
  }
  try {
    index_of("twin");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "made.gltf: 2 cameras are called \"twin\": 3, 4");
  }
}

}  // namespace
