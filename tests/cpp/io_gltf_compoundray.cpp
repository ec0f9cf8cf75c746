// What CompoundRay's files say beyond glTF: hit boxes, and its rule for colours.
#include "gltf_builder.h"

namespace omma::test {
namespace {

TEST(GltfHitBox, IsKeptAndNotDrawn) {
  GltfBuilder b = one_triangle();
  b.document["meshes"][0]["name"] = "wall";
  b.document["meshes"][0]["extras"] = {{"hitbox", "True"}};
  b.document["nodes"][0]["translation"] = {0, 5, 0};
  const Scene scene = load(b);
  EXPECT_TRUE(scene.meshes.empty());
  EXPECT_TRUE(scene.instances.empty());
  ASSERT_EQ(scene.hit_boxes.size(), 1u);
  EXPECT_EQ(scene.hit_boxes[0].name, "wall");
  EXPECT_EQ(scene.hit_boxes[0].triangles.size(), 1u);
  EXPECT_EQ(scene.hit_boxes[0].world_from_mesh.m[1][3], 5);
}

TEST(GltfHitBox, AnythingButTrueIsDrawn) {
  for (const json& value : {json("no"), json(false), json(1), json(nullptr)}) {
    GltfBuilder b = one_triangle();
    b.document["meshes"][0]["extras"] = {{"hitbox", value}};
    const Scene scene = load(b);
    EXPECT_EQ(scene.instances.size(), 1u) << value;
    EXPECT_TRUE(scene.hit_boxes.empty()) << value;
  }
}

// A mesh used twice: as a box under each node, and another mesh beside it is still drawn.
TEST(GltfHitBox, UnderSeveralNodes) {
  GltfBuilder b = one_triangle();
  const json triangle = b.document["meshes"][0]["primitives"][0];
  b.document["meshes"][0]["extras"] = {{"hitbox", true}};
  b.document["meshes"][0]["primitives"].push_back(triangle);
  b.root({{"mesh", 0}, {"translation", {1, 0, 0}}});
  b.push("meshes", {{"primitives", json::array({triangle})}});
  b.root({{"mesh", 1}});
  const Scene scene = load(b);
  ASSERT_EQ(scene.hit_boxes.size(), 2u);
  EXPECT_EQ(scene.hit_boxes[1].triangles.size(), 2u);
  EXPECT_EQ(scene.hit_boxes[1].triangles[1][0], 3u);  // of the second primitive
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].mesh, 0);
}

TEST(GltfCompoundRayColors, MaterialsAreItsOwn) {
  GltfBuilder b = textured_triangle({{"uri", data_uri(png_1x1(9, 9, 9), "image/png")}});
  json& material = b.document["materials"][0];
  material["alphaMode"] = "MASK";
  material["emissiveFactor"] = {1, 1, 1};
  material["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0.25, 1, 0.5};
  b.push("samplers", {{"wrapS", 33071}, {"minFilter", 9728}, {"magFilter", 9728}});
  b.document["textures"][0]["sampler"] = 0;
  const Scene scene = load(b, {.color_rule = ColorRule::compoundray});
  EXPECT_EQ(scene.color_rule, ColorRule::compoundray);
  const Material& m = scene.materials.at(0);
  EXPECT_EQ(m.name, "painted");
  EXPECT_EQ(m.alpha_mode, AlphaMode::opaque);
  EXPECT_TRUE(m.double_sided);
  expect_near(m.emissive, {0, 0, 0});
  expect_near(m.base_color, {0.5f, 0.25f, 1, 0.5f});
  EXPECT_EQ(m.base_color_texture.texture, 0);
  EXPECT_EQ(scene.textures.at(0).filter, Filter::linear);
  EXPECT_EQ(scene.textures.at(0).wrap_u, Wrap::repeat);
  EXPECT_EQ(load(b).color_rule, ColorRule::gltf);
  EXPECT_EQ(load(b).materials.at(0).alpha_mode, AlphaMode::mask);
}

}  // namespace
}  // namespace omma::test
