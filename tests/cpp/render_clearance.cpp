// Free space about triangles (backend/clearance), against two plates whose clearance is known.
#include <gtest/gtest.h>

#include <cmath>

#include "backend/backend.h"
#include "backend/clearance.h"
#include "backend/shading_data.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

std::vector<std::vector<float>> clearances_in(const Scene& scene) {
  const auto shading = make_shading_data(scene);
  const Placement placement = placement_of(scene);
  const Backend& backend = find_backend(backend_under_test);
  const Acceleration built = backend.build(scene, shading->view, placement, {}, nullptr);
  return clearances_m({backend.launches({}).closest, built.tracer.get()}, scene, placement);
}

// Between plates at a distance d that are far wider, rays by the cosine meet the other one at d /
// cos(theta), and E[cos(theta)] = 2/3; those of the other side meet nothing: harmonic mean 3 d.
// Sixteen rays are within a sixth of that. A triangle that is a line has no sides.
TEST(Clearance, BetweenTwoPlatesIsThreeTimesTheirDistance) {
  constexpr float distance_m = 0.5f, half_m = 500;
  Scene scene;
  scene.materials.resize(1);
  scene.materials[0].double_sided = true;
  for (const float y : {0.0f, distance_m}) {
    Mesh mesh;
    mesh.material = 0;
    mesh.positions = {{-half_m, y, -half_m}, {half_m, y, -half_m}, {0, y, half_m}};
    mesh.triangles = {{0, 1, 2}};
    scene.meshes.push_back(mesh);
  }
  Mesh line;
  line.material = 0;
  line.positions = {{-1, distance_m / 2, 0}, {0, distance_m / 2, 0}, {1, distance_m / 2, 0}};
  line.triangles = {{0, 1, 2}};
  scene.meshes.push_back(line);
  scene.instances.resize(3);
  for (int i = 0; i < 3; ++i) scene.instances[static_cast<std::size_t>(i)].mesh = i;
  const std::vector<std::vector<float>> found = clearances_in(scene);
  ASSERT_EQ(found.size(), 3u);
  for (int plate = 0; plate < 2; ++plate)
    EXPECT_NEAR(found[static_cast<std::size_t>(plate)][0], 3 * distance_m, 0.5 * distance_m);
  EXPECT_TRUE(std::isinf(found[2][0]));
}

}  // namespace
}  // namespace omma::test
