// The arena of Ofstad et al. through the old name, in both kernels, against the brute-force
// reference of tests/cpp/reference.h: does a frame differ by more than 1,000 random samples and 8
// bits make it?
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <vector>

#include "../cpp/reference.h"
#include "../cpp/test_scenes.h"
#include "libEyeRenderer.h"
#include "omma/omma.h"

namespace omma::test {
namespace {

constexpr int samples = 1000;
constexpr std::size_t every = 25;  // ommatidium compared; all 1,000 take a minute each way
constexpr int rings = 60;

struct Expected {
  std::array<double, 3> mean{}, sd{};  // radiance, and its spread from one ray to another
};

// Mean and spread of the radiance over an ommatidium's field: rays at the middle of `rings` equal
// parts of its weight over the polar angle, `rings` to a ring, each ring turned by the golden
// angle.
Expected integrate(const Reference& reference, const Mat4& pose, const Eye& eye, std::size_t i,
                   Kernel kernel) {
  const double acceptance = eye.acceptance_angle_rad[i];
  constexpr int steps = 20000;
  // Weight up to each polar angle; nothing comes from beyond six acceptance angles.
  const double end = std::min(pi, 6 * acceptance);
  std::vector<double> weight(steps + 1);
  for (int k = 0; k < steps; ++k) {
    const double theta = end * (k + 0.5) / steps;
    weight[static_cast<std::size_t>(k) + 1] =
        weight[static_cast<std::size_t>(k)] +
        sensitivity(kernel, theta, acceptance) * std::sin(theta);
  }
  ReferenceRay ray = axis_ray(pose, eye, i);
  const Vec3d axis = ray.direction;
  Expected result;
  std::array<double, 3> squares{};
  for (int ring = 0; ring < rings; ++ring) {
    const double part = weight.back() * (ring + 0.5) / rings;
    const auto above = std::upper_bound(weight.begin(), weight.end(), part);
    const double theta = end * (static_cast<double>(above - weight.begin()) - 0.5) / steps;
    for (int j = 0; j < rings; ++j) {
      const double phi = 2 * pi * (j + 0.5) / rings + ring * 2.399963;
      ray.direction = direction_about(axis, theta, phi);
      const Radiance radiance = reference_radiance(reference, ray);
      for (std::size_t c = 0; c < 3; ++c) {
        result.mean[c] += radiance.channel[c] / (rings * rings);
        squares[c] += radiance.channel[c] * radiance.channel[c] / (rings * rings);
      }
    }
  }
  for (std::size_t c = 0; c < 3; ++c)
    result.sd[c] = std::sqrt(std::max(0.0, squares[c] - result.mean[c] * result.mean[c]));
  return result;
}

double level_of(double radiance) {
  return 255 * std::pow(std::clamp(radiance, 0.0, 1.0), 1 / 2.2);
}

// How far a radiance lies outside of all those that are shown as this level.
double distance_from_level(double radiance, int level) {
  const double lowest = std::pow(level / 255.0, 2.2);
  const double highest = level == 255 ? 1e300 : std::pow((level + 1) / 255.0, 2.2);
  return std::max({0.0, lowest - radiance, radiance - highest});
}

void compare_arena(const std::string& camera_name, const std::string& eye_name, Kernel kernel) {
  const std::string folder = OMMA_SHARED_DATA "/compound-ray/scenes/";
  const std::string path = folder + "ofstad-arena.gltf";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "needs " << path;

  setenv("OMMA_COMPAT_KERNEL", kernel == Kernel::gaussian ? "gaussian" : "compoundray", 1);
  setVerbosity(false);
  loadGlTFscene(path.c_str());
  ASSERT_TRUE(gotoCameraByName(camera_name.c_str()));
  ASSERT_EQ(getCurrentEyeOmmatidialCount(), 1000u);
  setCurrentEyeShaderName("single_dimension_fast");
  setCurrentEyeSamplesPerOmmatidium(samples);
  setRenderSize(1000, 1);
  renderFrame();
  const unsigned char* frame = getFramePointer();

  SceneOptions options;
  options.color_rule = ColorRule::compoundray;
  Scene scene = load_scene(path, options);
  scene.background.type = BackgroundType::test_pattern;  // CompoundRay's where a scene names none
  const Reference reference = make_reference(scene);
  const Eye eye = load_eye(folder + "eyes/" + eye_name, 1.0);
  const Mat4 pose = find_camera(scene, camera_name).world_from_camera;

  double levels = 0, predicted = 0, z_squared = 0, worst_z = 0;
  int compared = 0;
  for (std::size_t i = 0; i < eye.size(); i += every) {
    const Expected expected = integrate(reference, pose, eye, i, kernel);
    for (std::size_t c = 0; c < 3; ++c) {
      const int found = frame[4 * i + c];
      levels += std::fabs(found - std::floor(level_of(expected.mean[c])));
      // Sampling alone: the mean of a normal's magnitude, through the slope of the display curve.
      const double error = expected.sd[c] / std::sqrt(double{samples});
      predicted += std::sqrt(2 / pi) *
                   (level_of(expected.mean[c] + error) - level_of(expected.mean[c] - error)) / 2;
      // The reference's own error: its 3,600 rays are spread evenly, so that only cells which an
      // edge runs through err; of 60 x 60 some 120 do, by half their area: sqrt(120) / 2 / 3600.
      const double reference_error = 0.0015;
      const double z =
          distance_from_level(expected.mean[c], found) / std::hypot(error, reference_error);
      z_squared += z * z;
      worst_z = std::max(worst_z, z);
      ++compared;
    }
  }
  const double rms_z = std::sqrt(z_squared / compared);
  levels /= compared, predicted /= compared;
  std::printf(
      "%s, %s: mean absolute difference %.2f of 255, of which sampling %.2f; in standard "
      "errors %.2f rms, %.2f at most, %d values\n",
      eye_name.c_str(), kernel == Kernel::gaussian ? "gaussian" : "compoundray", levels, predicted,
      rms_z, worst_z, compared);
  // Truncation puts equal radiances up to one level apart, a third of one on average.
  EXPECT_LT(levels, predicted + 0.5);
  EXPECT_LT(levels, 1.5);   // what published pictures of CompoundRay are held to
  EXPECT_LT(rms_z, 1.2);    // 1 where sampling explains all; less, since 8 bits hide small errors
  EXPECT_LT(worst_z, 4.5);  // chance 7e-6 each
}

TEST(CompatArena, EquidistantEyeAsCompoundRay) {
  compare_arena("insect-eye-equidistant", "1000-equidistant.eye", Kernel::compoundray);
}

TEST(CompatArena, EquidistantEyeGaussian) {
  compare_arena("insect-eye-equidistant", "1000-equidistant.eye", Kernel::gaussian);
}

TEST(CompatArena, AcuteEyeAsCompoundRay) {
  compare_arena("insect-eye-variable-acceptance", "1000-horizontallyAcute-variableDegree.eye",
                Kernel::compoundray);
}

TEST(CompatArena, AcuteEyeGaussian) {
  compare_arena("insect-eye-variable-acceptance", "1000-horizontallyAcute-variableDegree.eye",
                Kernel::gaussian);
}

}  // namespace
}  // namespace omma::test
