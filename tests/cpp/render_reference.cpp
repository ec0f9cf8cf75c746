// The engine against the brute-force reference of reference.h, ray by ray and as whole integrals.
#include "reference.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "test_scenes.h"

namespace omma::test {
namespace {

// Rays in all directions from points within 20 cm of the head's centre, some with a focal offset.
Eye ray_eye(std::uint64_t seed, int rays) {
  Random random{seed};
  std::vector<Vec3d> axes;
  for (int i = 0; i < rays; ++i) axes.push_back(random.direction());
  Eye eye = make_eye(axes, 0);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const Vec3d towards = random.direction();
    eye.position_m[i] = to_float(towards * random.uniform(0, 0.2));
    if (random.index(4) == 0) eye.focal_offset_m[i] = static_cast<float>(random.uniform(0, 4));
  }
  return eye;
}

std::vector<Mat4> some_poses(std::uint64_t seed) {
  Random random{seed};
  return {Mat4{}, translation({0.3, -0.2, 0.1}) * random_rotation(random),
          translation({-0.2, 0.4, 0.3}) * random_rotation(random) * scaling({0.5, 0.5, 0.5}),
          random_rotation(random) * scaling({1.5, 0.8, 1.1}) * random_rotation(random),
          random_rotation(random) * scaling({-1, 1, 1})};
}

struct Comparison {
  int rays = 0, doubtful = 0, wrong = 0, lit = 0;
  double worst = 0;
};

// Counts the rays whose colour differs by more than the tolerance in any channel between a
// reference and what is rendered. Doubtful rays (see reference.h) are counted apart.
void compare(const Scene& known, const Scene& rendered, const Eye& eye, std::span<const Mat4> poses,
             double tolerance, Comparison& sum) {
  const Reference reference = make_reference(known);
  const Result result = render(make_renderer(rendered, eye, {.sampling = Fixed{1}}), poses);
  for (std::size_t p = 0; p < poses.size(); ++p)
    for (std::size_t i = 0; i < eye.size(); ++i) {
      const Radiance expected = reference_radiance(reference, axis_ray(poses[p], eye, i));
      ++sum.rays;
      if (expected.doubtful) {
        ++sum.doubtful;
        continue;
      }
      double difference = 0;
      for (int c = 0; c < rgb_bands; ++c)
        difference = std::max(difference, std::fabs(result.at(p * eye.size() + i, c) -
                                                    expected.channel[static_cast<std::size_t>(c)]));
      sum.worst = std::max(sum.worst, difference);
      if (!(difference <= tolerance) && ++sum.wrong <= 3)
        ADD_FAILURE() << "pose " << p << ", ray " << i << ": found "
                      << result.at(p * eye.size() + i, 0) << ' ' << result.at(p * eye.size() + i, 1)
                      << ' ' << result.at(p * eye.size() + i, 2) << ", expected "
                      << expected.channel[0] << ' ' << expected.channel[1] << ' '
                      << expected.channel[2];
    }
}

// Which surface is hit: every triangle of every mesh has a colour of its own, exact in float, seen
// from both sides; the materials go.
Scene with_identities(Scene scene) {
  scene.materials.assign(1, {});
  scene.materials[0].double_sided = true;
  scene.background = constant_background({0, 0, 0});
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    Mesh& mesh = scene.meshes[m];
    Mesh flat;
    flat.material = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto first = static_cast<std::uint32_t>(flat.positions.size());
      for (const std::uint32_t vertex : mesh.triangles[t]) {
        flat.positions.push_back(mesh.positions[vertex]);
        flat.colors.push_back({static_cast<float>(t) / 64, static_cast<float>(m) / 64, 1, 1});
      }
      flat.triangles.push_back({first, first + 1, first + 2});
    }
    mesh = flat;
  }
  return scene;
}

// Meshes placed several times are traced as copies in small scenes and as instances in large ones.
// Adds what makes a scene large: over a million triangles in two places, none of which has an area.
Scene with_many_copies(Scene scene) {
  Mesh mesh;
  mesh.positions = {{0, 0, -1}, {0, 0, 1}};
  mesh.triangles.assign(600'000, {0, 1, 0});
  const int index = add_mesh(scene, std::move(mesh));
  add_instance(scene, index);
  add_instance(scene, index, translation({0, 3, 0}));
  return scene;
}

TEST(Reference, SameSurfaceIsHit) {
  Comparison sum;
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    // Colours are 1/64 apart; weights of a flat colour sum to 1 within float rounding.
    for (const bool shared : {false, true}) {
      const Scene scene = with_identities(random_scene(seed));
      compare(scene, shared ? with_many_copies(scene) : scene, ray_eye(seed, 3000),
              some_poses(seed), 1e-4, sum);
    }
  EXPECT_EQ(sum.wrong, 0) << "of " << sum.rays;
  EXPECT_LT(sum.doubtful, sum.rays / 100);
}

TEST(Reference, SameColours) {
  Comparison sum;
  for (std::uint64_t seed = 1; seed <= 9; ++seed) {
    const Scene scene = random_scene(seed);
    const bool shared = seed % 3 == 0;
    compare(scene, shared ? with_many_copies(scene) : scene, ray_eye(seed, 2000), some_poses(seed),
            1e-4, sum);
  }
  EXPECT_EQ(sum.wrong, 0) << "of " << sum.rays << ", worst difference " << sum.worst;
  EXPECT_LT(sum.doubtful, sum.rays / 100);
}

// Whole responses: quadrature over the sphere against many samples. The midpoint rule on 500 x 1000
// cells errs by some 1e-4 at the edges of this scene, 16,384 samples by less.
TEST(Reference, SameIntegral) {
  Scene scene = flat_triangles(11, 12);
  scene.background.type = BackgroundType::simple_sky;
  const Reference reference = make_reference(scene);
  Eye eye = make_eye(std::vector<Vec3d>{{0, 0, -1}, normalize({1, 1, 0.3})}, 90 * degree);
  eye.acceptance_angle_rad[1] = static_cast<float>(200 * degree);
  eye.position_m[1] = {0.1f, 0.2f, -0.1f};
  eye.focal_offset_m[0] = 0.05f;
  const Mat4 pose = translation({0.1, 0, 0.2}) * rotation({0, 1, 0}, 0.7);
  for (const Kernel kernel : {Kernel::gaussian, Kernel::pillbox, Kernel::compoundray}) {
    const Result result = render(scene, eye, {Fixed{1 << 14}, 2, kernel}, pose);
    for (std::size_t i = 0; i < eye.size(); ++i) {
      const auto expected = reference_response(reference, pose, eye, i, kernel, 500, 1000);
      for (int c = 0; c < rgb_bands; ++c)
        EXPECT_NEAR(result.at(i, c), expected[static_cast<std::size_t>(c)], 1e-3)
            << name_of(kernel) << ", ommatidium " << i << ", channel " << c;
    }
  }
}

}  // namespace
}  // namespace omma::test
