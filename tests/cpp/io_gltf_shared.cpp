// The real scenes: all load, and they hold what their README says. Skipped where they are not.
#include <cctype>
#include <cmath>

#include "gltf_builder.h"

namespace omma::test {
namespace {

const std::filesystem::path scenes =
    std::filesystem::path(OMMA_SHARED_DATA) / "compound-ray/scenes";

struct RealScene {
  const char* file;
  std::uint64_t triangles;
  std::size_t cameras, images;
  BackgroundType background;
};

class RealScenes : public testing::TestWithParam<RealScene> {};

TEST_P(RealScenes, Load) {
  const RealScene& expected = GetParam();
  if (!std::filesystem::exists(scenes / expected.file))
    GTEST_SKIP() << (scenes / expected.file) << " is not there";
  const Scene scene = load_scene((scenes / expected.file).string());
  EXPECT_EQ(triangle_count(scene), expected.triangles);
  EXPECT_EQ(scene.cameras.size(), expected.cameras);
  EXPECT_EQ(scene.images.size(), expected.images);
  EXPECT_EQ(scene.background.type, expected.background);
  // CompoundRay lights nothing, and its scenes do not say that they are unlit.
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_TRUE(has_warning(scene, "without a light surfaces show"));
  EXPECT_FALSE(scene_bounds(scene).empty);
}

// The triangles of the meadow and the cameras are from the README, the rest was counted in the JSON
// (indices / 3).
INSTANTIATE_TEST_SUITE_P(
    CompoundRay, RealScenes,
    testing::Values(RealScene{"natural-standin-sky.gltf", 24200, 4, 1, BackgroundType::simple_sky},
                    RealScene{"ofstad-arena.gltf", 1020, 3, 1, BackgroundType::constant},
                    RealScene{"test-scene.gltf", 980, 6, 0, BackgroundType::constant},
                    RealScene{"test-scene-sky.gltf", 980, 6, 0, BackgroundType::simple_sky},
                    RealScene{"env_2.gltf", 1292, 2, 2, BackgroundType::constant},
                    RealScene{"environment.glb", 1360, 2, 2, BackgroundType::constant}),
    [](const auto& parameter) {
      std::string name = parameter.param.file;
      for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
      return name;
    });

TEST(RealScene, CamerasOfTheMeadow) {
  const auto file = scenes / "natural-standin-sky.gltf";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const Scene scene = load_scene(file.string());
  // By the camera's own name, as CompoundRay calls it; its node is called ..._Orientation.
  const Camera camera = find_camera(scene, "insect-eye-spherical-projector");
  EXPECT_EQ(camera.name, "insect-eye-spherical-projector_Orientation");
  EXPECT_EQ(camera.compound_structure, "eyes/1000-horizontallyAcute-variableDegree.eye");
}

TEST(RealScene, CamerasOfTheArenaAreScaled) {
  const auto file = scenes / "ofstad-arena.gltf";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  for (const Camera& camera : load_scene(file.string()).cameras)
    EXPECT_NEAR(std::cbrt(determinant(camera.world_from_camera)), 0.0209079, 1e-9);
}

}  // namespace
}  // namespace omma::test
