// Files that are valid glTF 2.0 though no exporter that we know writes them so. Most of the cases
// are those of Khronos' validator (KhronosGroup/glTF-Validator, test/base/data), in files of ours.
#include "gltf_builder.h"
#include "io/oces.h"

namespace omma::test {
namespace {

// Every whole number as JSON may write it too: 3.0 for 3.
json with_decimal_points(const json& value) {
  if (value.is_number_integer()) return value.get<double>();
  if (!value.is_structured()) return value;
  json changed = value;
  for (json& element : changed) element = with_decimal_points(element);
  return changed;
}

// A file with an integer in every place that has one.
GltfBuilder all_integers() {
  GltfBuilder b = textured_triangle({{"bufferView", 2}});
  b.view(png_1x1(10, 20, 30));
  b.push("samplers",
         {{"magFilter", 9728}, {"minFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}});
  b.document["textures"][0]["sampler"] = 0;
  b.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 0;
  b.document["materials"][0]["emissiveTexture"] = {
      {"index", 0}, {"extensions", {{"KHR_texture_transform", {{"texCoord", 0}}}}}};
  json& primitive = b.document["meshes"][0]["primitives"][0];
  primitive["mode"] = 5;
  primitive["indices"] = b.accessor<std::uint16_t>({0, 2, 1}, "SCALAR");
  b.document["bufferViews"][0]["byteStride"] = 12;
  b.document["accessors"][0]["byteOffset"] = 0;
  const int indices = b.view(bytes_of(std::vector<std::uint8_t>{0, 0, 0, 0, 1}));
  const int values = b.view(bytes_of(std::vector<float>{9, 7, 8, 9}));
  b.document["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", indices}, {"byteOffset", 4}, {"componentType", 5121}}},
      {"values", {{"bufferView", values}, {"byteOffset", 4}}}};
  b.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
  b.document["nodes"][0]["children"] = {1};
  b.push("nodes", {{"camera", 0}, {"skin", 0}, {"translation", {1, 2, 3}}});
  b.document["skins"] = {{{"joints", {0}}}};
  return b;
}

void expect_same(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t m = 0; m < a.meshes.size(); ++m) {
    EXPECT_EQ(a.meshes[m].triangles, b.meshes[m].triangles);
    EXPECT_EQ(a.meshes[m].material, b.meshes[m].material);
    ASSERT_EQ(a.meshes[m].positions.size(), b.meshes[m].positions.size());
    for (std::size_t i = 0; i < a.meshes[m].positions.size(); ++i)
      expect_near(a.meshes[m].positions[i], b.meshes[m].positions[i]);
  }
  EXPECT_EQ(a.instances.size(), b.instances.size());
  EXPECT_EQ(a.cameras.size(), b.cameras.size());
  EXPECT_EQ(a.images.at(0).rgba_srgb8, b.images.at(0).rgba_srgb8);
  EXPECT_EQ(a.textures.at(0).wrap_v, b.textures.at(0).wrap_v);
  EXPECT_EQ(a.textures.at(0).filter, b.textures.at(0).filter);
  EXPECT_EQ(a.warnings.size(), b.warnings.size());
}

TEST(GltfValid, IntegersWithADecimalPoint) {
  GltfBuilder b = all_integers();
  const Scene plain = load(b);
  EXPECT_EQ(plain.textures.at(0).wrap_v, Wrap::mirrored_repeat);
  expect_near(plain.meshes.at(0).positions[1], {7, 8, 9});
  EXPECT_EQ(plain.cameras.size(), 1u);
  b.document = with_decimal_points(b.with_buffer());
  ASSERT_NE(b.gltf().find("\"mesh\":0.0"), std::string::npos);
  expect_same(load(b), plain);

  // And in the other ways that JSON has.
  const TemporaryFolder folder;
  std::string text = one_triangle().gltf();
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"\"mesh\":0", "\"mesh\":0e0"},
                                 {"\"count\":3", "\"count\":30e-1"},
                                 {"\"componentType\":5126", "\"componentType\":0.5126e4"},
                                 {"\"byteLength\":36", "\"byteLength\":3.6E+1"},
                                 {"\"byteOffset\":0", "\"byteOffset\":-0"}}) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  }
  EXPECT_EQ(triangle_count(load_scene(folder.write("scene.gltf", text))), 1u);
}

TEST(GltfValid, OnlyWholeNumbersAreIntegers) {
  for (const json& value : {json(0.5), json(-1.0), json(1e10), json(1e300)}) {
    GltfBuilder b = one_triangle();
    b.document["nodes"][0]["mesh"] = value;
    expect_load_error(b, {"nodes[0].mesh", "expected an integer"});
  }
  for (const json& value : {json(0.5), json(-4.0), json(1e16), json(1e300)}) {
    GltfBuilder b = one_triangle();
    b.document["accessors"][0]["count"] = value;
    expect_load_error(b, {"accessors[0].count", "expected an integer"});
  }
}

TEST(GltfValid, IntegersWithADecimalPointInEyes) {
  Eye eye;
  eye.position_m = {{0, 0, 0}, {1, 2, 3}};
  eye.axis = {{0, 0, -1}, {0, 1, 0}};
  eye.acceptance_angle_rad = {0.1f, 0.2f};
  eye.focal_offset_m = {0, 0};
  eye.eye_id = {0, 1};
  eye.acceptances.resize(1);
  eye.acceptances[0].width_rad = 0.1;
  eye.acceptance_of = {0, -1};
  const Eye plain = parse_oces(oces_bytes(eye, false), "eye.gltf");
  json document = json::parse(oces_bytes(eye, false));
  json& extension = document["extensions"]["OCES_eyes"];
  extension["mirrorPlanes"] = {{{"normal", "X"}}};
  document["nodes"][1]["extensions"]["OCES_eyes"]["mirrorPlanes"] = {0};
  for (json& property : extension["ommatidialProperties"]) property["dataStride"] = 1;
  const Eye read = parse_oces(with_decimal_points(document).dump(), "eye.gltf");
  EXPECT_EQ(read.size(), plain.size() + 1);  // one of the two has a mirror image
  expect_near(read.axis.back(), plain.axis.back());
  json sphere = {{"ommatidialCount", 3.0},
                 {"type", "SPHERICAL"},
                 {"ommatidialProperties", {{"DIAMETER", 0.0}}}};
  extension["eyes"] = {sphere, sphere};
  extension["ommatidialProperties"] = {{{"type", "COARSE"}, {"value", 0.1}}};
  EXPECT_EQ(parse_oces(document.dump(), "eye.gltf").size(), 9u);
}

TEST(GltfValid, BuffersThatNobodyUsesAreNotRead) {
  // Without data, with data that is not there, and such that nothing could read.
  for (const json& buffer : {json{{"byteLength", 1}}, json{{"byteLength", 74}, {"uri", ""}},
                             json{{"byteLength", 1}, {"uri", "not-there.bin"}},
                             json{{"byteLength", 1}, {"uri", "http://example.org/buffer.bin"}},
                             json{{"byteLength", 1}, {"uri", "data:;base64,!!!!"}},
                             json{{"byteLength", 99}, {"uri", "data:;base64,AA=="}}}) {
    GltfBuilder b = one_triangle();
    b.document = b.with_buffer();
    b.push("buffers", buffer);
    const int view = b.push("bufferViews", {{"buffer", 1}, {"byteLength", 74}});
    // Accessors, images and materials of it, as an animation or an extension may have them.
    b.push("accessors",
           {{"bufferView", view}, {"componentType", 5126}, {"count", 4}, {"type", "SCALAR"}});
    b.push("images", {{"bufferView", view}, {"mimeType", "image/png"}});
    b.document["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = 1;
    EXPECT_EQ(triangle_count(load(b)), 1u) << buffer;
    b.document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 1;
    expect_load_error(b, {"buffer"});
  }
}

TEST(GltfValid, IndicesWithoutABufferViewAreZero) {
  GltfBuilder b = one_triangle();
  b.document["meshes"][0]["primitives"][0]["indices"] =
      b.push("accessors", {{"componentType", 5123}, {"count", 6}, {"type", "SCALAR"}});
  EXPECT_EQ(triangle_count(load(b)), 2u);
}

TEST(GltfValid, TextureWithoutAnImageMayUseAnyCoordinates) {
  GltfBuilder b = one_triangle();
  b.push("textures", json::object());
  b.push("materials", {{"emissiveTexture", {{"index", 0}, {"texCoord", 4}}}});
  b.document["meshes"][0]["primitives"][0]["material"] = 0;
  const Scene scene = load(b);
  EXPECT_EQ(scene.materials.at(0).emissive_texture.texture, -1);
  EXPECT_TRUE(has_warning(scene, "a texture has no PNG, JPEG or WebP image"));
}

TEST(GltfBudget, RepeatedBuffersEarnNoMemory) {
  // What a file may grow into follows from its bytes, however often buffers name them.
  const TemporaryFolder folder;
  folder.write("data.bin", std::string(1 << 16, '\0'));
  GltfBuilder b;
  json primitives = json::array();
  for (int i = 0; i < 2000; ++i) {
    b.push("buffers", {{"byteLength", 1 << 16}, {"uri", "data.bin"}});
    const int view = b.push("bufferViews", {{"buffer", i}, {"byteLength", 1 << 16}});
    primitives.push_back({{"attributes",
                           {{"POSITION", b.push("accessors", {{"bufferView", view},
                                                              {"componentType", 5120},
                                                              {"count", (1 << 16) / 3},
                                                              {"type", "VEC3"}})}}}});
  }
  b.document["meshes"] = {{{"primitives", primitives}}};
  b.root({{"mesh", 0}});
  // 2,000 times 21,845 vertices of 12 bytes and as many corners of 4: 700 MB from 0.5 MB.
  expect_error([&] { load_scene(folder.write("scene.gltf", b.gltf())); }, {"too large"});
}

}  // namespace
}  // namespace omma::test
