// glTF geometry feature by feature: accessors, primitives, nodes and scenes.
#include <cmath>

#include "gltf_builder.h"

namespace omma::test {
namespace {

// A triangle whose positions are `values`, one accessor of the given kind.
template <typename T>
Scene with_positions(const std::vector<T>& values, bool normalized) {
  GltfBuilder b;
  const int positions = b.accessor(values, "VEC3", normalized);
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}}}})}});
  return load(b);
}

TEST(GltfAccessor, EveryComponentType) {
  expect_near(
      with_positions<std::int8_t>({-5, 0, 0, 1, 0, 0, 0, 1, 0}, false).meshes[0].positions[0],
      {-5, 0, 0});
  expect_near(
      with_positions<std::uint8_t>({200, 0, 0, 1, 0, 0, 0, 1, 0}, false).meshes[0].positions[0],
      {200, 0, 0});
  expect_near(
      with_positions<std::int16_t>({-500, 0, 0, 1, 0, 0, 0, 1, 0}, false).meshes[0].positions[0],
      {-500, 0, 0});
  expect_near(
      with_positions<std::uint16_t>({60000, 0, 0, 1, 0, 0, 0, 1, 0}, false).meshes[0].positions[0],
      {60000, 0, 0});
  expect_near(
      with_positions<std::uint32_t>({100000, 0, 0, 1, 0, 0, 0, 1, 0}, false).meshes[0].positions[0],
      {100000, 0, 0});
  expect_near(
      with_positions<float>({-0.125f, 0, 0, 1, 0, 0, 0, 1, 0}, false).meshes[0].positions[0],
      {-0.125f, 0, 0});
}

TEST(GltfAccessor, NormalisedIntegers) {
  // glTF 2.0, 3.6.2.2: c/127, c/255, c/32767, c/65535; the signed minimum is clamped to -1.
  const float tolerance = 1e-7f;  // half a unit in the last place of numbers up to 1
  expect_near(
      with_positions<std::int8_t>({-128, 127, 64, 1, 0, 0, 0, 1, 0}, true).meshes[0].positions[0],
      {-1, 1, 64 / 127.0f}, tolerance);
  expect_near(
      with_positions<std::uint8_t>({0, 255, 51, 1, 0, 0, 0, 1, 0}, true).meshes[0].positions[0],
      {0, 1, 0.2f}, tolerance);
  expect_near(with_positions<std::int16_t>({-32768, 32767, -16384, 1, 0, 0, 0, 1, 0}, true)
                  .meshes[0]
                  .positions[0],
              {-1, 1, -16384 / 32767.0f}, tolerance);
  expect_near(with_positions<std::uint16_t>({0, 65535, 13107, 1, 0, 0, 0, 1, 0}, true)
                  .meshes[0]
                  .positions[0],
              {0, 1, 0.2f}, tolerance);
}

TEST(GltfAccessor, StridedAndOffset) {
  // Interleaved: position (12 bytes), texture coordinate (8), so a stride of 20.
  GltfBuilder b;
  const std::vector<float> interleaved = {0,    0,    0, 0.1f, 0.2f, 1,    0,   0,
                                          0.3f, 0.4f, 0, 1,    0,    0.5f, 0.6f};
  const int view = b.view(bytes_of(interleaved), 20);
  const int positions = b.push(
      "accessors", {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  const int uv = b.push("accessors", {{"bufferView", view},
                                      {"byteOffset", 12},
                                      {"componentType", 5126},
                                      {"count", 3},
                                      {"type", "VEC2"}});
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uv}}}})}});
  const Scene scene = load(b);
  expect_near(scene.meshes[0].positions[2], {0, 1, 0});
  EXPECT_EQ(scene.meshes[0].texcoords[0][1].x, 0.3f);
  EXPECT_EQ(scene.meshes[0].texcoords[0][2].y, 0.6f);
}

TEST(GltfAccessor, SparseOverAView) {
  GltfBuilder b;
  const int positions = b.accessor(triangle_positions, "VEC3");
  const int indices = b.view(bytes_of(std::vector<std::uint16_t>{1}));
  const int values = b.view(bytes_of(std::vector<float>{7, 8, 9}));
  b.document["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
      {"values", {{"bufferView", values}}}};
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}}}})}});
  const Scene scene = load(b);
  expect_near(scene.meshes[0].positions[1], {7, 8, 9});
  expect_near(scene.meshes[0].positions[2], {0, 1, 0});
}

TEST(GltfAccessor, SparseOverZeros) {
  for (const int index_type : {5121, 5123, 5125}) {
    GltfBuilder b;
    const std::string index_bytes = index_type == 5121 ? bytes_of(std::vector<std::uint8_t>{0, 2})
                                    : index_type == 5123
                                        ? bytes_of(std::vector<std::uint16_t>{0, 2})
                                        : bytes_of(std::vector<std::uint32_t>{0, 2});
    const int indices = b.view(index_bytes);
    const int values = b.view(bytes_of(std::vector<float>{1, 2, 3, 4, 5, 6}));
    const int positions = b.push(
        "accessors", {{"componentType", 5126},
                      {"count", 3},
                      {"type", "VEC3"},
                      {"sparse",
                       {{"count", 2},
                        {"indices", {{"bufferView", indices}, {"componentType", index_type}}},
                        {"values", {{"bufferView", values}}}}}});
    b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}}}})}});
    const Scene scene = load(b);
    expect_near(scene.meshes[0].positions[0], {1, 2, 3});
    expect_near(scene.meshes[0].positions[1], {0, 0, 0});
    expect_near(scene.meshes[0].positions[2], {4, 5, 6});
  }
}

TEST(GltfAccessor, WithoutAViewIsZero) {
  GltfBuilder b;
  const int positions =
      b.push("accessors", {{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}}}})}});
  const Scene scene = load(b);
  ASSERT_EQ(scene.meshes.size(), 1u);
  for (const Vec3 p : scene.meshes[0].positions) expect_near(p, {0, 0, 0});
}

// Five vertices in a row, assembled by `mode` with the given indices (none if empty).
template <typename T>
std::vector<std::array<std::uint32_t, 3>> assembled(int mode, const std::vector<T>& indices) {
  GltfBuilder b;
  json primitive = {
      {"mode", mode},
      {"attributes",
       {{"POSITION", b.accessor<float>({0, 0, 0, 1, 0, 0, 2, 0, 1, 3, 0, 0, 4, 1, 0}, "VEC3")}}}};
  if (!indices.empty()) primitive["indices"] = b.accessor(indices, "SCALAR");
  b.root({{"mesh", b.mesh(primitive)}});
  return load(b).meshes.at(0).triangles;
}

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

TEST(GltfPrimitive, IndicesOf8And16And32BitsOrNone) {
  const Triangles expected = {{4, 2, 0}, {1, 2, 3}};
  EXPECT_EQ(assembled<std::uint8_t>(4, {4, 2, 0, 1, 2, 3}), expected);
  EXPECT_EQ(assembled<std::uint16_t>(4, {4, 2, 0, 1, 2, 3}), expected);
  EXPECT_EQ(assembled<std::uint32_t>(4, {4, 2, 0, 1, 2, 3}), expected);
  EXPECT_EQ(assembled<std::uint8_t>(4, {}), (Triangles{{0, 1, 2}}));  // two corners are left over
}

TEST(GltfPrimitive, StripsAlternateTheirWinding) {
  // glTF 2.0, 3.7.2.1: p_i = {v_i, v_(i + (1 + i%2)), v_(i + (2 - i%2))}.
  EXPECT_EQ(assembled<std::uint8_t>(5, {}), (Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
  EXPECT_EQ(assembled<std::uint16_t>(5, {4, 3, 2, 1}), (Triangles{{4, 3, 2}, {3, 1, 2}}));
}

TEST(GltfPrimitive, Fans) {
  // p_i = {v_(i+1), v_(i+2), v_0}.
  EXPECT_EQ(assembled<std::uint8_t>(6, {}), (Triangles{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}}));
}

TEST(GltfPrimitive, PointsAndLinesArePassedOver) {
  for (int mode = 0; mode < 4; ++mode) {
    GltfBuilder b = one_triangle();
    b.document["meshes"][0]["primitives"][0]["mode"] = mode;
    const Scene scene = load(b);
    EXPECT_TRUE(scene.meshes.empty());
    EXPECT_TRUE(has_warning(scene, "points and lines"));
  }
}

TEST(GltfPrimitive, WithoutPositionsIsPassedOver) {
  GltfBuilder b = one_triangle();
  b.document["meshes"][0]["primitives"][0]["attributes"] = json::object();
  const Scene scene = load(b);
  EXPECT_TRUE(scene.meshes.empty());
  EXPECT_TRUE(has_warning(scene, "without positions"));
}

TEST(GltfPrimitive, UnusedVerticesAreDropped) {
  GltfBuilder b;
  std::vector<float> many(300, 0);
  many[3 * 50] = 1;      // vertex 50: x = 1
  many[3 * 99 + 1] = 2;  // vertex 99: y = 2
  const int positions = b.accessor(many, "VEC3");
  const int indices = b.accessor<std::uint8_t>({99, 7, 50}, "SCALAR");
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}})}});
  const Mesh mesh = load(b).meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.triangles, (Triangles{{2, 0, 1}}));
  expect_near(mesh.positions[1], {1, 0, 0});
  expect_near(mesh.positions[2], {0, 2, 0});
}

TEST(GltfPrimitive, ColorsOfThreeAndFourComponents) {
  GltfBuilder b = one_triangle();
  const auto color = [&](int accessor) {
    b.document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = accessor;
    return load(b).meshes.at(0).colors.at(1);
  };
  const float tolerance = 1e-7f;  // half a unit in the last place of numbers up to 1
  expect_near(color(b.accessor<float>({0, 0, 0, 0.1f, 0.2f, 2.5f, 0, 0, 0}, "VEC3")),
              {0.1f, 0.2f, 2.5f, 1});
  expect_near(color(b.accessor<float>({0, 0, 0, 0, 0.1f, 0.2f, 0.3f, 0.4f, 0, 0, 0, 0}, "VEC4")),
              {0.1f, 0.2f, 0.3f, 0.4f});
  expect_near(
      color(b.accessor<std::uint8_t>({0, 0, 0, 0, 255, 51, 0, 102, 0, 0, 0, 0}, "VEC4", true)),
      {1, 0.2f, 0, 0.4f}, tolerance);
  expect_near(color(b.accessor<std::uint16_t>({0, 0, 0, 0, 65535, 13107, 0, 26214, 0, 0, 0, 0},
                                              "VEC4", true)),
              {1, 0.2f, 0, 0.4f}, tolerance);
  expect_near(color(b.accessor<std::uint16_t>({0, 0, 0, 65535, 13107, 0, 0, 0, 0}, "VEC3", true)),
              {1, 0.2f, 0, 1}, tolerance);
}

TEST(GltfPrimitive, TextureCoordinatesOfBothSets) {
  GltfBuilder b = one_triangle();
  json& attributes = b.document["meshes"][0]["primitives"][0]["attributes"];
  const int first = b.accessor<std::uint8_t>({0, 0, 255, 51, 0, 255}, "VEC2", true);
  const int second = b.accessor<std::uint16_t>({0, 0, 13107, 65535, 0, 0}, "VEC2", true);
  attributes["TEXCOORD_0"] = first;
  attributes["TEXCOORD_1"] = second;
  const Mesh mesh = load(b).meshes.at(0);
  const float tolerance = 1e-7f;  // half a unit in the last place of numbers up to 1
  EXPECT_NEAR(mesh.texcoords[0][1].y, 0.2f, tolerance);
  EXPECT_NEAR(mesh.texcoords[1][1].x, 0.2f, tolerance);
  EXPECT_EQ(mesh.texcoords[1][1].y, 1);
}

TEST(GltfPrimitive, QuantizedPositionsAndTextureCoordinates) {
  GltfBuilder b;
  b.document["extensionsUsed"] = b.document["extensionsRequired"] = {"KHR_mesh_quantization"};
  const int positions = b.accessor<std::int16_t>({0, 0, 0, 1000, 0, 0, 0, -1000, 0}, "VEC3");
  const int uv = b.accessor<std::int8_t>({0, 0, 3, -2, 0, 1}, "VEC2");
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uv}}}})}});
  const Scene scene = load(b);
  expect_near(scene.meshes[0].positions[2], {0, -1000, 0});
  EXPECT_EQ(scene.meshes[0].texcoords[0][1].y, -2);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfPrimitive, ZeroAreaTrianglesAreKept) {
  GltfBuilder b = one_triangle();
  b.document["meshes"][0]["primitives"][0]["indices"] =
      b.accessor<std::uint8_t>({0, 0, 0, 0, 1, 1}, "SCALAR");
  EXPECT_EQ(triangle_count(load(b)), 2u);
}

void expect_transform(const Mat4& t, const std::array<double, 12>& expected) {
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 4; ++c)
      EXPECT_NEAR(t.m[r][c], expected[4 * r + c], 1e-12) << r << "," << c;  // rounding of doubles
}

TEST(GltfNode, TranslationRotationScale) {
  GltfBuilder b = one_triangle();
  json& node = b.document["nodes"][0];
  const double h = std::sqrt(0.5);  // a quarter turn around z: x goes to y
  node["translation"] = {1, 2, 3};
  node["rotation"] = {0, 0, h, h};
  node["scale"] = {2, 3, -4};
  expect_transform(load(b).instances.at(0).world_from_mesh, {0, -3, 0, 1, 2, 0, 0, 2, 0, 0, -4, 3});
}

TEST(GltfNode, RotationsOfEachAxis) {
  const double h = std::sqrt(0.5);
  GltfBuilder b = one_triangle();
  b.document["nodes"][0]["rotation"] = {h, 0, 0, h};
  expect_transform(load(b).instances[0].world_from_mesh, {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0});
  b.document["nodes"][0]["rotation"] = {0, h, 0, h};
  expect_transform(load(b).instances[0].world_from_mesh, {0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0});
}

TEST(GltfNode, MatrixIsColumnMajor) {
  GltfBuilder b = one_triangle();
  b.document["nodes"][0]["matrix"] = {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0, 10, 11, 12, 1};
  expect_transform(load(b).instances[0].world_from_mesh, {1, 4, 7, 10, 2, 5, 8, 11, 3, 6, 9, 12});
}

TEST(GltfNode, ChildrenFollowTheirParents) {
  GltfBuilder b = one_triangle();
  b.document["nodes"] = {{{"translation", {1, 0, 0}}, {"scale", {2, 2, 2}}, {"children", {1}}},
                         {{"translation", {0, 1, 0}}, {"children", {2}}},
                         {{"scale", {-1, 1, 1}}, {"mesh", 0}, {"name", "leaf"}}};
  const Scene scene = load(b);
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.node_count, 3);
  EXPECT_EQ(scene.instances[0].name, "leaf");
  expect_transform(scene.instances[0].world_from_mesh, {-2, 0, 0, 1, 0, 2, 0, 2, 0, 0, 2, 0});
  EXPECT_LT(determinant(scene.instances[0].world_from_mesh), 0);  // negative scale mirrors
}

TEST(GltfNode, HierarchyOfAnyDepth) {
  GltfBuilder b = one_triangle();
  const int depth = 100000;  // far past what recursion would stand
  json nodes = json::array();
  for (int i = 0; i < depth; ++i)
    nodes.push_back({{"translation", {1, 0, 0}}, {"children", {i + 1}}});
  nodes.push_back({{"mesh", 0}});
  b.document["nodes"] = nodes;
  const Scene scene = load(b);
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].world_from_mesh.m[0][3], depth);
}

TEST(GltfNode, OneMeshUnderManyNodesIsStoredOnce) {
  GltfBuilder b = one_triangle();
  json& primitives = b.document["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  for (int i = 0; i < 9; ++i) b.root({{"mesh", 0}, {"translation", {i, 0, 0}}});
  const Scene scene = load(b);
  EXPECT_EQ(scene.meshes.size(), 2u);      // one for each primitive
  EXPECT_EQ(scene.instances.size(), 20u);  // one for each node and primitive
  EXPECT_EQ(triangle_count(scene), 20u);
  for (std::size_t i = 0; i < 20; ++i)  // both primitives know the node that places them
    EXPECT_EQ(scene.instances[i].node, static_cast<int>(i / 2));
}

TEST(GltfScene, TheDefaultOrTheOneAskedFor) {
  GltfBuilder b = one_triangle();
  b.push("nodes", {{"name", "other"}, {"mesh", 0}});
  b.document["scenes"] = {{{"name", "first"}, {"nodes", {0}}},
                          {{"name", "second"}, {"nodes", {1}}}};
  b.document["scene"] = 1;
  EXPECT_EQ(load(b).instances.at(0).name, "other");
  EXPECT_EQ(load(b, {.scene_index = 0}).instances.at(0).name, "node");
  EXPECT_EQ(load(b, {.scene_index = 1}).scene_names, (std::vector<std::string>{"first", "second"}));
  b.document.erase("scene");
  EXPECT_EQ(load(b).instances.at(0).name, "node");
  expect_error([&] { load(b, {.scene_index = 2}); }, {"scene.gltf", "no scene 2", "it has 2"});
  expect_error([&] { load(b, {.scene_index = -2}); }, {"scene.gltf", "no scene -2"});
  b.document["scene"] = 5;
  expect_load_error(b, {"default scene is 5"});
}

TEST(GltfScene, WithoutScenesAllRootsAreShown) {
  GltfBuilder b = one_triangle();
  b.document.erase("scenes");
  b.document.erase("scene");
  b.document["nodes"] = {{{"children", {1}}}, {{"mesh", 0}}, {{"mesh", 0}}};
  const Scene scene = load(b);
  EXPECT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.node_count, 3);
}

TEST(GltfScene, EmptyIsLegal) {
  GltfBuilder b;
  b.document.erase("scene");
  EXPECT_TRUE(load(b).instances.empty());
  b.document["scenes"] = {{{"name", "nothing"}}};
  const Scene scene = load(b);
  EXPECT_TRUE(scene.instances.empty());
  EXPECT_TRUE(scene_bounds(scene).empty);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfScene, MeshesOfOtherScenesAreNotKept) {
  GltfBuilder b = one_triangle();
  b.push("meshes", b.document["meshes"][0]);
  EXPECT_EQ(load(b).meshes.size(), 1u);
}

TEST(GltfScene, MorphTargetsThatNobodyBlendsLeaveTheMeshAsItIs) {
  GltfBuilder b = one_triangle();
  b.document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}};
  EXPECT_TRUE(load(b).warnings.empty());
  expect_near(load(b).meshes.at(0).positions[1], {1, 0, 0});
  b.document["nodes"][0]["weights"] = {0.5};
  expect_near(load(b).meshes.at(0).positions[1], {1.5, 0, 0});
  EXPECT_EQ(load(b).rig, nullptr);
}

}  // namespace
}  // namespace omma::test
