// Kernel functions that only other backends call, run here on the host: the path of a single ray
// against what the packets of the renderer see, the density of a sample against the sphere.
#include "physics/path.h"

#include <gtest/gtest.h>

#include "backend/shading_data.h"
#include "optics/acceptance_warp.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

// Three half-transparent walls ahead, one behind the other, the last before the sky.
TEST(Kernel, PathOfOneRayIsWhatThePacketsSee) {
  Scene scene;
  scene.background.type = BackgroundType::simple_sky;
  const float alpha[] = {0.25f, 0.5f, 0.75f};
  for (int k = 0; k < 3; ++k) {
    Material material;
    material.base_color = {0.2f * static_cast<float>(k), 0.9f, 0.3f, alpha[k]};
    material.emissive = {0.1f, 0, 0};
    material.alpha_mode = AlphaMode::blend;
    material.double_sided = true;
    const int index = add_material(scene, material);
    add_instance(scene, add_mesh(scene, quad({0, 0, -1.0 - k}, {4, 0, 0}, {0, 4, 0}, index)));
  }
  const Result packets = render(scene, make_eye(Vec3d{0, 0, -1}, 0), {1, 0, {}, {}, 0, {}});

  const auto shading = make_shading_data(scene);
  SceneView view = shading->view;
  const BackgroundData background = make_background_data(scene.background);
  view.background = background.view;
  int next = 0;
  const auto trace = [&](float t_near_m, SurfaceHit& hit, float& t_m) {
    if (next == 3) return false;
    hit = {next, 0, 0.25f, 0.25f};
    t_m = static_cast<float>(++next);
    EXPECT_LT(t_near_m, t_m);
    return true;
  };
  const omma::Radiance one = eval_path(view, {0, 0, -1}, 0.0f, 0.0f, trace);
  for (int c = 0; c < channel_count; ++c)  // the same operations in the same order
    EXPECT_FLOAT_EQ(one.channel[c], packets.at(0, c));
}

// Midpoint rule in theta; exact to 1e-5 with 100,000 cells where the density is smooth, and the
// edge of the pillbox falls into one cell.
TEST(Kernel, DensityOfSamplesIntegratesToOne) {
  constexpr int cells = 100'000;
  for (const Kernel kernel : {Kernel::gaussian, Kernel::pillbox, Kernel::compoundray})
    for (const double degrees : {2.6, 60.0, 360.0}) {
      Acceptance acceptance;
      acceptance.kernel = kernel;
      acceptance.width_rad = degrees * degree;
      const AcceptanceWarp warp = make_acceptance_warp(acceptance);
      const double end = std::min(pi, 5 * degrees * degree), width = end / cells;
      double integral = 0;
      for (int i = 0; i < cells; ++i) {
        const double theta = (i + 0.5) * width;
        integral += acceptance_pdf(view(warp), theta, 0) * 2 * pi * std::sin(theta) * width;
      }
      EXPECT_NEAR(integral, 1.0, 1e-4) << name_of(kernel) << ' ' << degrees;
    }
}

}  // namespace
}  // namespace omma::test
