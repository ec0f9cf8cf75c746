// KHR_gaussian_splatting: read as the extension says, written and read back, refused where it is
// not as it says.
#include <cmath>

#include "gltf_builder.h"

namespace omma::test {
namespace {

// Two splats under a node that is moved by (0, 0, -2).
GltfBuilder splats() {
  GltfBuilder b = one_triangle();
  b.document["nodes"][0]["translation"] = {0, 0, -2};
  const int positions = b.accessor<float>({0, 0, 0, 1, 2, 3}, "VEC3");
  const int scales = b.accessor<float>({0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0}, "VEC3");
  const int rotations = b.accessor<std::int8_t>({0, 0, 0, 127, 0, 90, 0, 90}, "VEC4", true);
  const int opacities = b.accessor<std::uint8_t>({255, 51}, "SCALAR", true);
  const int colors = b.accessor<float>({1, 2, 3, 4, 5, 6}, "VEC3");
  b.document["meshes"][0]["primitives"] = {
      {{"mode", 0},
       {"attributes",
        {{"POSITION", positions},
         {"KHR_gaussian_splatting:SCALE", scales},
         {"KHR_gaussian_splatting:ROTATION", rotations},
         {"KHR_gaussian_splatting:OPACITY", opacities},
         {"KHR_gaussian_splatting:SH_DEGREE_0_COEF_0", colors}}},
       {"extensions",
        {{"KHR_gaussian_splatting",
          {{"kernel", "ellipse"}, {"colorSpace", "srgb_rec709_display"}}}}}}};
  b.document["extensionsUsed"] = {"KHR_gaussian_splatting"};
  return b;
}

json& primitive(GltfBuilder& b) {
  return b.document["meshes"][0]["primitives"][0];
}
json& extension(GltfBuilder& b) {
  return primitive(b)["extensions"]["KHR_gaussian_splatting"];
}

TEST(GltfSplats, AreReadAsTheExtensionSays) {
  GltfBuilder b = splats();
  b.document["extensionsRequired"] = {"KHR_gaussian_splatting"};
  const Scene scene = load(b);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(scene.instances.empty());
  ASSERT_EQ(scene.splats.size(), 1u);
  const SplatCloud& cloud = scene.splats[0];
  EXPECT_EQ(cloud.name, "node");
  EXPECT_EQ(cloud.terms, 1);
  EXPECT_EQ(cloud.color_space, SplatColor::srgb);
  EXPECT_EQ(cloud.direction, SplatDirection::center);
  EXPECT_EQ(cloud.world_from_splats.m[2][3], -2);
  EXPECT_EQ(cloud.positions[1], (Vec3{1, 2, 3}));
  EXPECT_EQ(cloud.scales[0], (Vec3{0.1f, 0.2f, 0.3f}));
  EXPECT_GT(cloud.scales[1].z, 0);  // flat, but there
  EXPECT_EQ(cloud.opacities[0], 1);
  EXPECT_FLOAT_EQ(cloud.opacities[1], 0.2f);
  EXPECT_FLOAT_EQ(cloud.rotations[1].y, std::sqrt(0.5f));
  EXPECT_EQ(cloud.harmonics, (std::vector<float>{1, 2, 3, 4, 5, 6}));
}

TEST(GltfSplats, OfDraftsHaveLogarithms) {
  GltfBuilder b = splats();
  primitive(b)["attributes"]["KHR_gaussian_splatting:SCALE"] =
      b.accessor<float>({-1, 0, -2, -3, -4, -5}, "VEC3");
  const Scene scene = load(b);
  EXPECT_FLOAT_EQ(scene.splats.at(0).scales[0].x, std::exp(-1.0f));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("logarithms"), std::string::npos);
}

TEST(GltfSplats, ComeBackAsTheyWere) {
  Scene scene;
  for (const int terms : {1, 4, 9, 16}) {
    SplatCloud& cloud = scene.splats.emplace_back();
    cloud.name = "degree " + std::to_string(terms);
    cloud.terms = terms;
    cloud.color_space = SplatColor::linear;
    cloud.direction = terms == 9 ? SplatDirection::ray : SplatDirection::center;
    cloud.white = {2, 1, 0.5f};
    cloud.world_from_splats.m[0][1] = 0.25;
    cloud.world_from_splats.m[1][3] = terms;
    for (int i = 0; i < 5; ++i) {
      const auto x = static_cast<float>(i);
      cloud.positions.push_back({x, 2 * x, -x});
      cloud.scales.push_back({0.1f, 0.2f, 0.1f + x});
      cloud.rotations.push_back({0, 0.6f, 0, 0.8f});
      cloud.opacities.push_back(0.2f * x);
      for (int k = 0; k < 3 * terms; ++k)
        cloud.harmonics.push_back(x + 0.01f * static_cast<float>(k));
    }
  }
  const TemporaryFolder folder;
  const std::string path = (folder.path / "splats.glb").string();
  save_scene(path, scene);
  const Scene back = load_scene(path);
  EXPECT_TRUE(back.warnings.empty());
  ASSERT_EQ(back.splats.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    // Quaternions are made unit when they are read.
    for (const Vec4 q : back.splats[i].rotations) EXPECT_NEAR(q.y, 0.6f, 1e-7);
    SplatCloud same = back.splats[i];
    same.rotations = scene.splats[i].rotations;
    EXPECT_EQ(same, scene.splats[i]);
  }
}

TEST(GltfSplats, AreRefusedWhereTheyAreNotAsTheExtensionSays) {
  const auto expect = [](const std::string& part, auto change) {
    GltfBuilder b = splats();
    change(b);
    expect_load_error(b, {part});
  };
  expect("colorSpace", [](GltfBuilder& b) { extension(b)["colorSpace"] = "aces"; });
  expect("colorSpace", [](GltfBuilder& b) { extension(b).erase("colorSpace"); });
  expect("kernel", [](GltfBuilder& b) { extension(b).erase("kernel"); });
  expect("mode: expected 0", [](GltfBuilder& b) { primitive(b)["mode"] = 4; });
  for (const char* name : {"SCALE", "ROTATION", "OPACITY", "SH_DEGREE_0_COEF_0"})
    expect(std::string(name) + ": is missing", [&](GltfBuilder& b) {
      primitive(b)["attributes"].erase(std::string("KHR_gaussian_splatting:") + name);
    });
  expect("all harmonics of each degree", [](GltfBuilder& b) {
    primitive(b)["attributes"]["KHR_gaussian_splatting:SH_DEGREE_1_COEF_1"] = 0;
  });
  expect("splat 0: expected a rotation of length 1", [](GltfBuilder& b) {
    primitive(b)["attributes"]["KHR_gaussian_splatting:ROTATION"] =
        b.accessor<float>({0, 0, 0, 0, 0, 0, 0, 1}, "VEC4");
  });
  expect("splat 1: expected an opacity", [](GltfBuilder& b) {
    primitive(b)["attributes"]["KHR_gaussian_splatting:OPACITY"] =
        b.accessor<float>({0.5f, 2}, "SCALAR");
  });
  expect("has 1 elements, POSITION has 2", [](GltfBuilder& b) {
    primitive(b)["attributes"]["KHR_gaussian_splatting:OPACITY"] =
        b.accessor<float>({0.5f}, "SCALAR");
  });
  expect("splat-transform", [](GltfBuilder& b) {
    b.document["extensionsRequired"] = {"KHR_gaussian_splatting_compression_spz"};
  });
}

}  // namespace
}  // namespace omma::test
