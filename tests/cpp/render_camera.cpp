// Pictures of cameras: known geometry against closed forms, every pixel against the brute-force
// reference, and that nothing depends on how the work is cut up.
#include "omma/camera.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "reference.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

using Picture = std::vector<float>;

Camera camera_of(CameraType type, const Mat4& world_from_camera = {}) {
  Camera camera;
  camera.name = "it";
  camera.type = type;
  camera.yfov_rad = pi / 2;
  camera.aspect_ratio = 1;
  camera.xmag_m = camera.ymag_m = 2;
  camera.world_from_camera = world_from_camera;
  return camera;
}

Picture picture_of(const World& world, const Camera& camera, const CameraSettings& settings) {
  Picture picture(
      static_cast<std::size_t>(settings.size.width * settings.size.height) * rgb_bands, -1.0f);
  render_camera(world, camera, settings, picture);
  return picture;
}

double mean_of(const Picture& picture) {
  double sum = 0;
  for (const float value : picture) sum += value;
  return sum / static_cast<double>(picture.size());
}

// A white square of side 1 in the plane z = -2, its centre at (x, y); all else black.
Scene square_at(double x, double y) {
  Scene scene;
  add_quad(scene, {x, y, -2}, {0.5, 0, 0}, {0, 0.5, 0}, add_color(scene, {1, 1, 1}));
  return scene;
}

TEST(CameraPicture, SquareFillsItsShareOfAPerspectivePicture) {
  // At 2 m the picture is 4 m x 4 m: of 64 x 64 pixels the square fills 16 x 16.
  const World world = make_world(square_at(0.5, 1));
  const Camera camera = camera_of(CameraType::perspective);
  const Picture picture = picture_of(world, camera, {{64, 64}, 1});
  for (int row = 0; row < 64; ++row)
    for (int column = 0; column < 64; ++column) {
      const bool inside = column >= 32 && column < 48 && row >= 8 && row < 24;
      EXPECT_EQ(picture[static_cast<std::size_t>(64 * row + column) * rgb_bands], inside)
          << row << ' ' << column;
    }
  // Twice the aspect: half as wide in as many pixels.
  Camera wide = camera;
  wide.aspect_ratio = 2;
  EXPECT_EQ(mean_of(picture_of(world, wide, {{64, 64}, 1})), 8 * 16 / 4096.0);
  EXPECT_EQ(mean_of(picture_of(world, wide, {{128, 64}, 1})), 16 * 16 / 8192.0);
}

TEST(CameraPicture, OrthographicExtentsStretchWithTheNode) {
  const Scene scene = square_at(0, 0);
  // Half extents of 2 m: 16 x 16 of 64 x 64 pixels; where the node halves them, 32 x 32.
  const auto share = [&](const Mat4& world_from_camera) {
    const Camera camera = camera_of(CameraType::orthographic, world_from_camera);
    return mean_of(picture_of(make_world(scene), camera, {{64, 64}, 1}));
  };
  EXPECT_EQ(share({}), 16 * 16 / 4096.0);
  EXPECT_EQ(share(scaling({0.5, 0.5, 0.5})), 32 * 32 / 4096.0);
  EXPECT_EQ(share(scaling({0.5, 1, 7})), 32 * 16 / 4096.0);
  EXPECT_EQ(share(translation({0, 0, 50})), 16 * 16 / 4096.0);  // parallel: distance is nothing
  EXPECT_EQ(share(translation({0, 0, -3})), 0);                 // behind it
  EXPECT_EQ(share(translation({1.5, 0, 0})), 16 * 16 / 4096.0);
  EXPECT_EQ(share(translation({2, 0, 0})), 8 * 16 / 4096.0);  // half outside
}

TEST(CameraPicture, PanoramaShowsSixWallsWhereTheyAre) {
  // Walls of a cube around the camera: ahead, right, behind, left, up, down.
  Scene scene;
  const Vec3d towards[6] = {{0, 0, -1}, {1, 0, 0}, {0, 0, 1}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  for (int wall = 0; wall < 6; ++wall) {
    const auto [u, v] = tangents(towards[wall]);
    const float value = static_cast<float>(wall + 1) / 8;  // exact
    add_quad(scene, towards[wall], u, v, add_color(scene, {value, 0, 0}));
  }
  const Picture picture =
      picture_of(make_world(scene), camera_of(CameraType::panoramic), {{360, 180}, 1});
  const auto wall_at = [&](int azimuth_deg, int elevation_deg) {
    const int column = std::min(azimuth_deg + 180, 359), row = std::min(90 - elevation_deg, 179);
    return picture[static_cast<std::size_t>(360 * row + column) * rgb_bands] * 8;
  };
  EXPECT_EQ(wall_at(0, 0), 1);
  EXPECT_EQ(wall_at(-40, 0), 1);
  EXPECT_EQ(wall_at(50, 0), 2);
  EXPECT_EQ(wall_at(90, 0), 2);
  EXPECT_EQ(wall_at(180, 0), 3);
  EXPECT_EQ(wall_at(-180, 0), 3);
  EXPECT_EQ(wall_at(-90, 0), 4);
  EXPECT_EQ(wall_at(0, 50), 5);
  EXPECT_EQ(wall_at(-123, 90), 5);
  EXPECT_EQ(wall_at(0, -50), 6);
  EXPECT_EQ(wall_at(0, 40), 1);
  // With rows weighted by their solid angle each wall fills a sixth of the sphere.
  double share[6] = {}, whole = 0;
  for (int row = 0; row < 180; ++row)
    for (int column = 0; column < 360; ++column) {
      const double weight = std::cos((89.5 - row) * degree);
      share[std::lround(wall_at(column - 180, 90 - row)) - 1] += weight;
      whole += weight;
    }
  // Walls meet along some 500 pixels, each wrong by at most half of one of 65,000.
  for (const double one : share) EXPECT_NEAR(one / whole, 1.0 / 6, 0.004);
}

// simple_sky is brightest blue at the zenith and constant below the horizon (background.h).
TEST(CameraPicture, PanoramaOfTheSkyIsTheReferencesPixelByPixel) {
  Scene scene;
  scene.background.type = BackgroundType::simple_sky;
  Random random{8};
  const Camera camera = camera_of(CameraType::panoramic, random_rotation(random));
  const PictureSize size{32, 16};
  const Picture picture = picture_of(make_world(scene), camera, {size, 1});
  for (int row = 0; row < size.height; ++row)
    for (int column = 0; column < size.width; ++column) {
      const double azimuth = ((column + 0.5) / size.width - 0.5) * 2 * pi;
      const double elevation = (0.5 - (row + 0.5) / size.height) * pi;
      const Radiance expected = background_radiance(
          scene.background,
          transform_vector(camera.world_from_camera, from_azimuth_elevation(azimuth, elevation)));
      for (std::size_t c = 0; c < rgb_bands; ++c)
        EXPECT_NEAR(picture[static_cast<std::size_t>(size.width * row + column) * 3 + c],
                    expected.channel[c], 1e-6);  // directions are floats
    }
}

// Every pixel of all kinds of cameras in scenes that hold everything, under any transform.
TEST(CameraPicture, EveryPixelIsTheReferences) {
  int pixels = 0, doubtful = 0, wrong = 0, lit = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    Random random{seed};
    const Scene scene = random_scene(seed);
    const Reference reference = make_reference(scene);
    const World world = make_world(scene);
    for (const CameraType type :
         {CameraType::perspective, CameraType::orthographic, CameraType::panoramic}) {
      const Camera camera =
          camera_of(type, translation({0.2, -0.1, 0.3}) * random_rotation(random) *
                              scaling({0.8, 1.2, -0.9}));
      const PictureSize size{24, 16};
      const Picture picture = picture_of(world, camera, {size, 1});
      const Eye eye = camera_rays(camera, size, 0, size.height);
      for (std::size_t i = 0; i < eye.size(); ++i) {
        const Radiance expected =
            reference_radiance(reference, axis_ray(camera.world_from_camera, eye, i));
        ++pixels;
        doubtful += expected.doubtful;
        if (expected.doubtful) continue;
        for (std::size_t c = 0; c < rgb_bands; ++c) {
          // The tolerance of render_reference.cpp: textures are 16 bit, texture coordinates float.
          wrong += std::fabs(picture[i * rgb_bands + c] - expected.channel[c]) > 2e-3;
          lit += expected.channel[c] > 0;
        }
      }
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LT(doubtful, pixels / 10);
  EXPECT_GT(lit, pixels);
}

TEST(CameraPicture, ManyRaysCoverAnEdgeByItsShare) {
  // The right edge of the square at x = 0.3 runs through a column of the 4 m wide picture.
  Scene scene;
  add_quad(scene, {-4.7, 0, -2}, {5, 0, 0}, {0, 9, 0}, add_color(scene, {1, 1, 1}));
  const World world = make_world(scene);
  const Camera camera = camera_of(CameraType::perspective);
  // 8 columns of 0.5 m: the fifth goes from 0 to 0.5 and is covered by 0.6.
  const int samples = 256;
  const Picture picture = picture_of(world, camera, {{8, 8}, samples, 3});
  std::vector<float> edge;
  for (int row = 0; row < 8; ++row) {
    const auto at = [&](int column) {
      return picture[static_cast<std::size_t>(8 * row + column) * rgb_bands];
    };
    EXPECT_EQ(at(3), 1);
    EXPECT_EQ(at(5), 0);
    // Of the 256 strata that the points have in x all but one lie on one side for certain.
    EXPECT_NEAR(at(4), 0.6, 1.0 / samples);
    edge.push_back(at(4));
  }
  // A finer picture of the same has the same mean.
  EXPECT_NEAR(mean_of(picture), mean_of(picture_of(world, camera, {{32, 32}, 64})), 1e-3);
  EXPECT_EQ(picture, picture_of(world, camera, {{8, 8}, samples, 3}));
}

TEST(CameraPicture, RaysDifferFromPixelToPixel) {
  // Stripes of half a pixel, lit on the left of each: of three rays one or two meet light.
  Scene scene;
  const int columns = 32, rows = 32;
  const int white = add_color(scene, {1, 1, 1});
  const double pixel = 4.0 / columns;  // m
  for (int column = 0; column < columns; ++column)
    add_quad(scene, {-2 + (column + 0.25) * pixel, 0, -1}, {pixel / 4, 0, 0}, {0, 3, 0}, white);
  const World world = make_world(scene);
  const Camera camera = camera_of(CameraType::orthographic);
  const Picture picture = picture_of(world, camera, {{columns, rows}, 3});
  int one_of_three = 0;
  for (std::size_t i = 0; i < picture.size(); i += rgb_bands) {
    const bool one = std::fabs(picture[i] - 1.0f / 3) < 1e-6;
    EXPECT_TRUE(one || std::fabs(picture[i] - 2.0f / 3) < 1e-6) << picture[i];
    one_of_three += one;
  }
  // Half of 1024 pixels, were each a coin tossed by itself; five standard deviations are 80.
  EXPECT_NEAR(one_of_three, 512, 80);
  EXPECT_NE(picture_of(world, camera, {{columns, rows}, 3, 1}), picture);  // another seed
  // One ray goes through the middle whatever the seed.
  const World other = make_world(random_scene(4));
  EXPECT_EQ(picture_of(other, camera, {{20, 20}, 1, 1}),
            picture_of(other, camera, {{20, 20}, 1, 2}));
}

TEST(CameraPicture, BandsAndThreadsGiveTheBitsOfOnePiece) {
  const auto scene = std::make_shared<const Scene>(random_scene(2));
  for (const CameraType type :
       {CameraType::perspective, CameraType::orthographic, CameraType::panoramic}) {
    const Camera camera = camera_of(type);
    // More pixels than a band has rays.
    const PictureSize size{257, 149};
    const Renderer whole =
        make_renderer(*scene, camera_rays(camera, size, 0, size.height), {.sampling = Fixed{1}});
    const Picture expected = render(whole, std::span(&camera.world_from_camera, 1)).response;
    EXPECT_EQ(picture_of(make_world(*scene), camera, {size, 1}), expected);
    EXPECT_EQ(picture_of(make_world(*scene, {.threads = 1}), camera, {size, 1}), expected);
    EXPECT_EQ(picture_of(make_world(*scene, {.threads = 5}), camera, {size, 5}),
              picture_of(make_world(*scene, {.threads = 1}), camera, {size, 5}));
  }
}

TEST(CameraPicture, HasTheWorldsBackground) {
  Scene scene;
  scene.background = constant_background({0.25f, 0.5f, 0.75f});
  const Camera camera = camera_of(CameraType::panoramic);
  EXPECT_EQ(picture_of(make_world(scene), camera, {{1, 1}, 4}), (Picture{0.25f, 0.5f, 0.75f}));
  const Image image = make_image(2, 1, [](int column, int) {
    return column == 0 ? Vec4{2, 0, 0, 1} : Vec4{0, 3, 0, 1};
  });
  const World other = make_world(scene, {.background = image_background(image)});
  const Picture picture = picture_of(other, camera, {{4, 1}, 1});
  EXPECT_EQ(picture[0], 2 * 0.75f);  // a quarter of the way to the next texel's middle
  EXPECT_EQ(picture[10], 3 * 0.75f);
}

TEST(CameraPicture, ProgressGrowsAndCancels) {
  const World world = make_world(random_scene(1), {.threads = 1});
  const Camera camera = camera_of(CameraType::perspective);
  const CameraSettings settings{{300, 300}, 4};
  Picture picture(300 * 300 * rgb_bands);
  double last = 0;
  render_camera(world, camera, settings, picture, [&](double done) {
    EXPECT_GT(done, last);
    last = done;
    return true;
  });
  EXPECT_EQ(last, 1);
  EXPECT_THROW(render_camera(world, camera, settings, picture, [](double) { return false; }),
               Cancelled);
}

TEST(CameraPicture, ChecksItsArguments) {
  const World world = make_world(Scene{});
  Camera camera = camera_of(CameraType::perspective);
  Picture picture(12 * rgb_bands);
  EXPECT_NO_THROW(render_camera(world, camera, {{4, 3}, 1}, picture));
  EXPECT_THROW(render_camera(world, camera, {{4, 4}, 1}, picture), Error);
  EXPECT_THROW(render_camera(world, camera, {{0, 0}, 1}, {}), Error);
  EXPECT_THROW(render_camera(world, camera, {{4, 3}, 0}, picture), Error);
  EXPECT_THROW(render_camera(world, camera, {{4, 3}, max_samples + 1}, picture), Error);
  camera.type = CameraType::compound;
  EXPECT_THROW(render_camera(world, camera, {{4, 3}, 1}, picture), Error);
}

}  // namespace
}  // namespace omma::test
