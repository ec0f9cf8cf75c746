// EXT_mesh_gpu_instancing: one node that places its mesh many times.
#include "gltf_builder.h"
#include "omma/rig.h"

namespace omma::test {
namespace {

// A triangle under a node that is moved by (0, 0, -2), placed by these accessors.
GltfBuilder placed(GltfBuilder b, const json& attributes) {
  b.document["nodes"][0]["translation"] = {0, 0, -2};
  b.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
  return b;
}

Vec3d corner(const Scene& scene, std::size_t instance, std::size_t vertex) {
  const Instance& one = scene.instances.at(instance);
  return transform_point(one.world_from_mesh,
                         to_double(scene.meshes.at(static_cast<std::size_t>(one.mesh))
                                       .positions.at(vertex)));
}

void expect_at(Vec3d found, Vec3d expected) {
  EXPECT_NEAR(found.x, expected.x, 1e-6);
  EXPECT_NEAR(found.y, expected.y, 1e-6);
  EXPECT_NEAR(found.z, expected.z, 1e-6);
}

TEST(GltfInstances, StandWhereTheFileSays) {
  GltfBuilder b = one_triangle();
  const int t = b.accessor<float>({-1, 0, 0, 0.5, 0, 0, 1, 0, 0}, "VEC3");
  const Scene scene = load(placed(b, {{"TRANSLATION", t}}));
  ASSERT_EQ(scene.instances.size(), 3u);
  EXPECT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.node_count, 1);
  EXPECT_TRUE(scene.warnings.empty());
  expect_at(corner(scene, 0, 0), {-1, 0, -2});
  expect_at(corner(scene, 1, 1), {1.5, 0, -2});
  expect_at(corner(scene, 2, 2), {1, 1, -2});
  for (const Instance& one : scene.instances) EXPECT_EQ(one.name, "node");
  // Each moves by itself.
  EXPECT_NE(scene.instances[0].node, scene.instances[1].node);
}

TEST(GltfInstances, TurnAndGrow) {
  // By a quarter about y, in bytes and shorts that are normalised and in floats, and twice as large
  // in y: within the rounding of a byte, which is normalised to a unit quaternion.
  GltfBuilder bytes = one_triangle(), shorts = one_triangle(), floats = one_triangle();
  const int b = bytes.accessor<std::int8_t>({0, 90, 0, 90, 0, 0, 0, 127}, "VEC4", true);
  const int s = shorts.accessor<std::int16_t>({0, 23170, 0, 23170, 0, 0, 0, 32767}, "VEC4", true);
  const int f = floats.accessor<float>({0, 0.70710678f, 0, 0.70710678f, 0, 0, 0, 1}, "VEC4");
  for (auto [builder, turn] : {std::pair(&bytes, b), std::pair(&shorts, s), std::pair(&floats, f)}) {
    const int scale = builder->accessor<float>({1, 2, 1, 1, 1, 1}, "VEC3");
    const Scene scene = load(placed(*builder, {{"ROTATION", turn}, {"SCALE", scale}}));
    ASSERT_EQ(scene.instances.size(), 2u);
    expect_at(corner(scene, 0, 1), {0, 0, -3});  // +x to -z
    expect_at(corner(scene, 0, 2), {0, 2, -2});
    expect_at(corner(scene, 1, 1), {1, 0, -2});
  }
}

TEST(GltfInstances, HangFromNodesThatAnimationsMove) {
  GltfBuilder b = one_triangle();
  const int t = b.accessor<float>({-1, 0, 0, 1, 0, 0}, "VEC3");
  const int times = b.accessor<float>({0, 1}, "SCALAR");
  const int shifts = b.accessor<float>({0, 0, -2, 0, 5, -2}, "VEC3");
  b.document["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
       {"samplers", {{{"input", times}, {"output", shifts}}}}}};
  const Scene scene = load(placed(b, {{"TRANSLATION", t}}));
  ASSERT_NE(scene.rig, nullptr);
  int placing = 0;
  for (const RigNode& node : scene.rig->nodes) placing += node.file_node >= 0;
  EXPECT_EQ(placing, 2);
}

TEST(GltfInstances, WhatIsWrongIsSaid) {
  GltfBuilder b = one_triangle();
  const int three = b.accessor<float>({-1, 0, 0, 0.5, 0, 0, 1, 0, 0}, "VEC3");
  const int two = b.accessor<float>({1, 1, 1, 1, 1, 1}, "VEC3");
  const int codes = b.accessor<std::int8_t>({0, 0, 0, 1}, "VEC4");
  const int nowhere = b.accessor<float>({0, 0, 0, 0}, "VEC4");
  const std::string place = "node 0 \"node\": EXT_mesh_gpu_instancing.attributes";
  expect_load_error(placed(b, {{"TRANSLATION", three}, {"SCALE", two}}),
                    {place + ".SCALE: has 2 elements, another has 3"});
  expect_load_error(placed(b, {{"ROTATION", three}}), {".ROTATION: expected 4 components, found 3"});
  expect_load_error(placed(b, {{"ROTATION", codes}}), {"integers that are normalised"});
  expect_load_error(placed(b, {{"ROTATION", nowhere}}), {"instance 0", "unit quaternion"});
  expect_load_error(placed(b, {{"TRANSLATION", 99}}), {place + ".TRANSLATION", "accessor 99"});
  expect_load_error(placed(b, {{"_ID", two}}), {place + ": expected TRANSLATION, ROTATION or SCALE"});
  GltfBuilder skinned = placed(b, {{"TRANSLATION", three}});
  skinned.document["nodes"][0]["skin"] = 0;
  skinned.document["skins"] = {{{"joints", {0}}}};
  expect_load_error(skinned, {"expected a skin or EXT_mesh_gpu_instancing, found both"});
  EXPECT_TRUE(has_warning(load(placed(b, {{"TRANSLATION", three}, {"_COLOR_0", three}})),
                          "colours of single instances are not read"));
}

TEST(GltfInstances, ASmallFileCannotPlaceTooMany) {
  GltfBuilder b = one_triangle();
  b.push("accessors", {{"componentType", 5126}, {"count", 500000000}, {"type", "VEC3"}});
  expect_load_error(placed(b, {{"TRANSLATION", 1}}), {"too large"});
}

}  // namespace
}  // namespace omma::test
