// Renderers that share a scene, and what single rays bring.
#include <gtest/gtest.h>

#include "test_scenes.h"

namespace omma::test {
namespace {

std::vector<float> responses_of(const Renderer& renderer) {
  std::vector<float> responses(renderer.eye().size() * rgb_bands);
  const Mat4 pose;
  renderer.render({&pose, 1}, responses);
  return responses;
}

TEST(SameScene, GivesTheBitsOfARendererOfItsOwn) {
  const auto scene = std::make_shared<const Scene>(random_scene(3));
  const Eye wide = make_eye(sphere_directions(20), 0.4),
            fine = make_eye(sphere_directions(90), 0.1);
  const RenderSettings settings{.sampling = Fixed{7}, .seed = 5, .kernel = Kernel::compoundray};
  auto first = std::make_unique<Renderer>(scene, wide);
  const std::vector<float> before = responses_of(*first);
  const Renderer second(*first, fine, settings);
  EXPECT_EQ(responses_of(second), responses_of(Renderer(scene, fine, settings)));
  EXPECT_EQ(responses_of(*first), before);
  EXPECT_EQ(second.eye().size(), 90u);
  EXPECT_EQ(second.settings().sampling, settings.sampling);
  EXPECT_EQ(&second.scene(), &first->scene());
  // Takes over the warps of the angles that both know.
  Eye mixed = make_eye(sphere_directions(30), 0.1);
  for (std::size_t i = 0; i < 15; ++i) mixed.acceptance_angle_rad[i] = 0.2f;
  EXPECT_EQ(responses_of(Renderer(second, mixed, settings)),
            responses_of(Renderer(scene, mixed, settings)));
  const std::vector<float> again = responses_of(second);
  first.reset();
  EXPECT_EQ(responses_of(second), again);  // it does not need the first one
}

TEST(SameScene, HasABackgroundOfItsOwn) {
  Scene scene;
  scene.background = constant_background({0.25f, 0.25f, 0.25f});
  const Eye eye = make_eye(Vec3d{0, 0, -1}, 0.1);
  const Renderer first(std::make_shared<const Scene>(scene), eye);
  const Image red = make_image(2, 1, [](int, int) { return Vec4{1, 0, 0, 1}; });
  const Renderer second(first, eye, {.background = image_background(red)});
  const Renderer third(second, eye);  // in the second's world
  const Renderer fourth(first, eye);
  EXPECT_EQ(responses_of(second), (std::vector<float>{1, 0, 0}));
  EXPECT_EQ(responses_of(first), (std::vector<float>{0.25f, 0.25f, 0.25f}));
  EXPECT_EQ(responses_of(third), responses_of(second));
  EXPECT_EQ(responses_of(fourth), responses_of(first));
}

TEST(SameScene, ChecksWhatItIsGiven) {
  const Renderer first(std::make_shared<const Scene>(), make_eye(Vec3d{0, 0, -1}, 0));
  EXPECT_THROW(Renderer(first, Eye{}), Error);
  EXPECT_THROW(Renderer(first, first.eye(), {.sampling = Fixed{0}}), Error);
}

// Radiance of every ray: [ommatidium][sample][channel].
std::vector<float> rays_of(const Renderer& renderer, std::uint64_t first_pose = 0) {
  const std::size_t ommatidia = renderer.eye().size();
  const auto samples =
      static_cast<std::size_t>(std::get<Fixed>(renderer.settings().sampling).samples);
  std::vector<float> responses(ommatidia * rgb_bands), rays(responses.size() * samples, -1.0f);
  const Mat4 pose;
  RenderCall call;
  call.first_pose = first_pose;
  call.ray_radiance = rays;
  std::vector<float> beside(responses.size() * beside_rows, -1.0f);
  call.beside_rays = beside;
  renderer.render({&pose, 1}, responses, call);
  EXPECT_EQ(beside, std::vector<float>(beside.size()));  // nothing shines on this
  // Sums of at most 37 floats under 10 in another order.
  for (std::size_t i = 0; i < ommatidia; ++i)
    for (std::size_t c = 0; c < rgb_bands; ++c) {
      double mean = 0;
      for (std::size_t s = 0; s < samples; ++s)
        mean += rays[(i * samples + s) * rgb_bands + c] / static_cast<double>(samples);
      EXPECT_NEAR(responses[i * rgb_bands + c], mean, 1e-5);
    }
  return rays;
}

TEST(RayRadiance, MeansAreTheResponses) {
  for (const Points points : {Points::low_discrepancy, Points::random})
    for (const int samples : {1, 16, 37}) {
      const auto scene = std::make_shared<const Scene>(random_scene(2));
      const Renderer renderer(
          scene, make_eye(sphere_directions(50), 0.3),
          {.sampling = Fixed{samples}, .points = points, .noise = Noise::new_every_frame});
      const std::vector<float> rays = rays_of(renderer);
      EXPECT_EQ(rays_of(renderer), rays);
      EXPECT_NE(rays_of(renderer, 1), rays);  // another pose draws other rays
    }
}

// Each ray keeps its own value: over an edge they are black or white, never a mean.
TEST(RayRadiance, IsThatOfEachRay) {
  Scene scene;
  scene.background = image_background(make_image(2, 1, [](int column, int) {
    return Vec4{1.0f * column, 0, 0, 1};
  }));
  scene.background.image.rgba_linear[3] = 1;
  add_quad(scene, {-50, 0, -1}, {50, 0, 0}, {0, 50, 0}, add_color(scene, {0, 0, 0}));
  add_quad(scene, {50, 0, -1}, {50, 0, 0}, {0, 50, 0}, add_color(scene, {1, 0, 0}));
  const Renderer renderer(std::make_shared<const Scene>(scene), make_eye(Vec3d{0, 0, -1}, 0.2),
                          {.sampling = Fixed{64}});
  int white = 0;
  const std::vector<float> rays = rays_of(renderer);
  for (std::size_t s = 0; s < 64; ++s) {
    EXPECT_TRUE(rays[s * rgb_bands] == 0 || rays[s * rgb_bands] == 1);
    white += rays[s * rgb_bands] == 1;
  }
  EXPECT_NEAR(white, 32, 4);  // stratified points: at most a few cross the edge
}

TEST(RayRadiance, ChecksItsRoom) {
  const Renderer renderer(std::make_shared<const Scene>(), make_eye(Vec3d{0, 0, -1}, 0.1),
                          {.sampling = Fixed{4}});
  std::vector<float> responses(rgb_bands), rays(4 * rgb_bands - 1), errors(rgb_bands);
  const Mat4 pose;
  RenderCall call;
  call.ray_radiance = rays;
  EXPECT_THROW(renderer.render({&pose, 1}, responses, call), Error);
  rays.resize(4 * rgb_bands);
  call.ray_radiance = rays;
  EXPECT_NO_THROW(renderer.render({&pose, 1}, responses, call));
  std::vector<float> beside(beside_rows * rgb_bands + 1);
  call.beside_rays = beside;
  EXPECT_THROW(renderer.render({&pose, 1}, responses, call), Error);
  beside.pop_back();
  call.beside_rays = beside;
  EXPECT_NO_THROW(renderer.render({&pose, 1}, responses, call));
  call.standard_error = errors;
  EXPECT_THROW(renderer.render({&pose, 1}, responses, call), Error);
  call.ray_radiance = {};
  EXPECT_THROW(renderer.render({&pose, 1}, responses, call), Error);
}

}  // namespace
}  // namespace omma::test
