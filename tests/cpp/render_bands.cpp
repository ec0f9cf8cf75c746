// Any number of bands: what textures and backgrounds have as linear RGB is lifted by a matrix, and
// responses may be mixtures of bands with errors of their own.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "omma/camera.h"
#include "reference.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

constexpr int band_counts[] = {1, 3, 4, 8, 16, 128};

// Weights of both signs, another row for each band.
std::vector<double> some_matrix(int bands) {
  Random random{static_cast<std::uint64_t>(bands)};
  std::vector<double> matrix;
  for (int i = 0; i < 3 * bands; ++i) matrix.push_back(random.uniform(-0.5, 1));
  return matrix;
}

World world_in_bands(const Scene& scene, const std::vector<double>& band_from_rgb) {
  WorldSettings settings;
  settings.band_from_rgb = band_from_rgb;
  return make_world(scene, settings);
}

struct Bands {
  std::vector<float> response, error;
};

Bands render_bands(const Renderer& renderer, bool with_error = false,
                   std::span<const double> output_from_band = {}) {
  const std::size_t outputs =
      output_from_band.empty()
          ? static_cast<std::size_t>(renderer.world().bands())
          : output_from_band.size() / static_cast<std::size_t>(renderer.world().bands());
  Bands result{std::vector<float>(renderer.eye().size() * outputs, -1e30f), {}};
  if (with_error) result.error.resize(result.response.size(), -1e30f);
  RenderCall call;
  call.standard_error = result.error;
  call.output_from_band = output_from_band;
  const Mat4 pose;
  renderer.render({&pose, 1}, result.response, call);
  return result;
}

// Sum of a row of weights times RGB.
double mixed(const std::vector<double>& matrix, std::size_t row, const auto& rgb) {
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += matrix[3 * row + c] * static_cast<double>(rgb[c]);
  return sum;
}

// Rays against every triangle, in double precision, and then lifted. Radiance is up to about 2, and
// weights 1, so 2e-3 is what render_reference.cpp allows colours, summed.
TEST(Bands, AreWhatTheReferenceSees) {
  int rays = 0, wrong = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Scene scene = random_scene(seed);
    const Reference reference = make_reference(scene);
    const Eye eye = make_eye(sphere_directions(400), 0);
    for (const int bands : band_counts) {
      const std::vector<double> matrix = some_matrix(bands);
      const Renderer renderer(world_in_bands(scene, matrix), eye, {.sampling = Fixed{1}});
      const Bands found = render_bands(renderer);
      for (std::size_t i = 0; i < eye.size(); ++i) {
        const Radiance expected = reference_radiance(reference, axis_ray({}, eye, i));
        if (expected.doubtful) continue;
        ++rays;
        bool good = true;
        for (std::size_t b = 0; b < static_cast<std::size_t>(bands); ++b) {
          const double error = found.response[i * static_cast<std::size_t>(bands) + b] -
                               mixed(matrix, b, expected.channel);
          good = good && std::fabs(error) <= 4e-3;
        }
        wrong += !good;
      }
    }
  }
  EXPECT_GT(rays, 3000);
  EXPECT_LE(wrong, rays / 1000);
}

// All is linear, so bands are the matrix times the RGB of the same rays: own rays, standard errors'
// scrambles, shared ones, random ones, and through layers.
TEST(Bands, AreTheMatrixTimesRgb) {
  Eye eye = make_eye(sphere_directions(150), 9 * degree);
  for (const std::uint64_t seed : {4u, 5u, 6u}) {
    const Scene scene = random_scene(seed);
    for (const bool with_error : {false, true})
      for (const RenderSettings& settings :
           {RenderSettings{.sampling = Fixed{5}}, RenderSettings{.sampling = Fixed{32}},
            RenderSettings{.sampling = Shared{8}},
            RenderSettings{.sampling = Fixed{7}, .points = Points::random}}) {
        const Bands rgb =
            render_bands(Renderer(make_world(scene), eye, settings), with_error);
        for (const int bands : band_counts) {
          const std::vector<double> matrix = some_matrix(bands);
          const Bands found = render_bands(
              Renderer(world_in_bands(scene, matrix), eye, settings), with_error);
          for (std::size_t i = 0; i < eye.size(); ++i)
            for (std::size_t b = 0; b < static_cast<std::size_t>(bands); ++b)
              ASSERT_NEAR(found.response[i * static_cast<std::size_t>(bands) + b],
                          mixed(matrix, b, &rgb.response[3 * i]), 3e-6)
                  << seed << ' ' << bands;
        }
      }
  }
}

TEST(Bands, OfTheUnitMatrixAreRgbToTheBit) {
  const Scene scene = random_scene(2);
  const Eye eye = make_eye(sphere_directions(200), 7 * degree);
  const Bands rgb = render_bands(Renderer(make_world(scene), eye));
  const Bands unit =
      render_bands(Renderer(world_in_bands(scene, {1, 0, 0, 0, 1, 0, 0, 0, 1}), eye));
  EXPECT_EQ(rgb.response, unit.response);
}

// A surround of radiance (1, 2, 4) everywhere, whatever the acceptance.
TEST(Bands, OfAnEvenSurroundAreExact) {
  Scene scene;
  scene.background = constant_background({1, 2, 4});
  const Eye eye = make_eye(sphere_directions(30), 20 * degree);
  for (const int bands : band_counts) {
    std::vector<double> matrix;  // exact in binary
    for (int i = 0; i < 3 * bands; ++i) matrix.push_back((i % 7) / 8.0);
    const Bands found = render_bands(Renderer(world_in_bands(scene, matrix), eye), true);
    constexpr double rgb[] = {1, 2, 4};
    for (std::size_t k = 0; k < found.response.size(); ++k) {
      EXPECT_EQ(found.response[k], mixed(matrix, k % static_cast<std::size_t>(bands), rgb));
      EXPECT_EQ(found.error[k], 0);
    }
  }
}

TEST(Bands, OfPicturesToo) {
  const Scene scene = random_scene(1);
  Camera camera;
  camera.type = CameraType::perspective;
  camera.yfov_rad = 1;
  std::vector<float> rgb(20 * 10 * 3), found(20 * 10 * 5);
  const std::vector<double> matrix = some_matrix(5);
  render_camera(make_world(scene), camera, {{20, 10}, 4, 0}, rgb);
  const World world = world_in_bands(scene, matrix);
  EXPECT_EQ(world.bands(), 5);
  render_camera(world, camera, {{20, 10}, 4, 0}, found);
  for (std::size_t i = 0; i < 200; ++i)
    for (std::size_t b = 0; b < 5; ++b)
      EXPECT_NEAR(found[5 * i + b], mixed(matrix, b, &rgb[3 * i]), 3e-6);
}

TEST(Bands, AnErrorIsReachedInAllOfThem) {
  const Scene scene = flat_triangles(3, 60);
  const Eye eye = make_eye(sphere_directions(100), 8 * degree);
  const RenderSettings settings{.sampling = ToError{0.02, 8, 1 << 14}};
  const RenderSettings many{.sampling = Fixed{1 << 14}};
  for (const int bands : {1, 4, 16}) {
    const World world = world_in_bands(scene, some_matrix(bands));
    const Bands expected = render_bands(Renderer(world, eye, many));
    const Bands found = render_bands(Renderer(world, eye, settings), true);
    std::size_t beyond = 0;
    for (std::size_t k = 0; k < found.response.size(); ++k) {
      EXPECT_LE(found.error[k], 0.0201f);
      beyond += std::fabs(found.response[k] - expected.response[k]) > 2 * 0.02f;
    }
    EXPECT_LE(beyond, found.response.size() / 50);
  }
}

// A mixture's standard error is that of its own estimates: nothing is left of it where what varies
// cancels ray by ray, though that of each band is large.
TEST(Outputs, HaveErrorsOfTheirOwn) {
  Scene scene = flat_triangles(5, 80, 2);
  scene.background = constant_background({0, 0, 0});
  for (Material& material : scene.materials)
    material.base_color = {material.base_color.x, material.base_color.x, material.base_color.x, 1};
  const Eye eye = make_eye(sphere_directions(100), 15 * degree);
  const std::vector<double> mixtures = {1, 0, 0, 2, 0, 0, 1, -1, 0, 0.5, 0.25, 0.25};
  for (const Sampling& sampling : {Sampling(Fixed{4}), Sampling(Shared{4})}) {
    const Renderer renderer(make_world(scene), eye, {.sampling = sampling});
    const Bands plain = render_bands(renderer, true);
    const Bands found = render_bands(renderer, true, mixtures);
    double largest = 0;
    for (std::size_t i = 0; i < eye.size(); ++i) {
      const float red = plain.response[3 * i], error = plain.error[3 * i];
      largest = std::max(largest, static_cast<double>(error));
      EXPECT_NEAR(found.response[4 * i], red, 1e-6);
      EXPECT_NEAR(found.response[4 * i + 1], 2 * red, 2e-6);
      EXPECT_NEAR(found.response[4 * i + 2], 0, 1e-6);
      EXPECT_NEAR(found.response[4 * i + 3], red, 1e-6);
      EXPECT_NEAR(found.error[4 * i], error, 1e-5);
      EXPECT_NEAR(found.error[4 * i + 1], 2 * error, 2e-5);
      EXPECT_NEAR(found.error[4 * i + 2], 0, 1e-6);
      EXPECT_NEAR(found.error[4 * i + 3], error, 1e-5);
    }
    EXPECT_GT(largest, 0.02);
  }
}

TEST(Bands, TooManyOrWithoutNumbersAreRefused) {
  const Scene scene;
  EXPECT_THROW(world_in_bands(scene, std::vector<double>(3 * 129, 0.5)), Error);
  EXPECT_THROW(world_in_bands(scene, {1, 0}), Error);
  EXPECT_THROW(world_in_bands(scene, {1, 0, std::numeric_limits<double>::quiet_NaN()}), Error);
  EXPECT_THROW(world_in_bands(scene, {1, 0, 1e7}), Error);
  const Renderer renderer(world_in_bands(scene, some_matrix(4)), make_eye(Vec3d{0, 0, -1}, 0.1));
  EXPECT_THROW(render_bands(renderer, false, some_matrix(1)), Error);  // three weights, four bands
  std::vector<float> too_few(3);
  const Mat4 pose;
  EXPECT_THROW(renderer.render({&pose, 1}, too_few), Error);
  WorldSettings settings;
  settings.backend = "none";
  EXPECT_THROW(make_world(scene, settings), Error);
}

}  // namespace
}  // namespace omma::test
