// glTF containers and URIs, and everything that may be wrong with a file: each is an omma::Error
// that names the file and the place; nothing aborts, nothing is replaced in silence.
#include <limits>

#include "gltf_builder.h"

namespace omma::test {
namespace {

Scene load_bytes(const std::string& bytes, const std::string& name = "scene.gltf") {
  const TemporaryFolder folder;
  return load_scene(folder.write(name, bytes));
}

TEST(GltfContainer, TextAndBinary) {
  const GltfBuilder b = one_triangle();
  EXPECT_EQ(triangle_count(load_bytes(b.gltf())), 1u);
  const Scene scene = load_bytes(b.glb(), "scene.glb");
  EXPECT_EQ(triangle_count(scene), 1u);
  expect_near(scene.meshes[0].positions[1], {1, 0, 0});
  EXPECT_EQ(triangle_count(load_bytes(b.glb(), "misnamed.gltf")), 1u);   // told by its content
  EXPECT_EQ(triangle_count(load_bytes("\xEF\xBB\xBF" + b.gltf())), 1u);  // byte order mark
}

TEST(GltfContainer, EveryTruncationIsAnError) {
  const GltfBuilder b = one_triangle();
  for (const std::string& whole : {b.gltf(), b.glb()})
    for (std::size_t size = 0; size < whole.size(); ++size)
      expect_error([&] { load_bytes(whole.substr(0, size)); }, {"scene.gltf"});
}

TEST(GltfContainer, BrokenBinaryHeaders) {
  const std::string good = one_triangle().glb();
  const auto with = [&](std::size_t at, std::uint32_t value) {
    std::string bad = good;
    return bad.replace(at, 4, little_endian_u32(value));
  };
  expect_error([&] { load_bytes(with(4, 1)); }, {"version 2", "found 1"});
  expect_error([&] { load_bytes(with(8, 0xFFFFFFFF)); }, {"claims 4294967295 bytes"});
  expect_error([&] { load_bytes(with(12, 0xFFFFFFFF)); }, {"chunk 0", "claims 4294967295"});
  expect_error([&] { load_bytes(with(16, 0)); }, {"first chunk is not JSON"});
  expect_error([&] { load_bytes(good.substr(0, 8) + little_endian_u32(12)); }, {"no JSON chunk"});
}

TEST(GltfContainer, DataUris) {
  GltfBuilder b = one_triangle();
  const auto with_uri = [&](const std::string& uri) {
    b.document["buffers"] = json::array({{{"byteLength", b.binary.size()}, {"uri", uri}}});
    return load(b);
  };
  for (const char* type : {"application/octet-stream", "application/gltf-buffer", "", "text/plain",
                           "made/up;charset=x"})
    EXPECT_EQ(triangle_count(with_uri(data_uri(b.binary, type))), 1u);
  std::string unpadded = data_uri(b.binary + "x");
  while (unpadded.back() == '=') unpadded.pop_back();
  EXPECT_EQ(triangle_count(with_uri(unpadded)), 1u);
  std::string percent = "data:,";
  for (const char c : b.binary) {
    const char* digits = "0123456789ABCDEF";
    percent += {'%', digits[static_cast<unsigned char>(c) >> 4], digits[c & 15]};
  }
  EXPECT_EQ(triangle_count(with_uri(percent)), 1u);
  expect_error([&] { with_uri("data:;base64,!!!!"); }, {"buffer 0", "base64"});
  expect_error([&] { with_uri("data:;base64"); }, {"buffer 0", "comma"});
  expect_error([&] { with_uri("data:;base64,QUJD"); },
               {"buffer 0", "claims 36 bytes, there are 3"});
}

// A triangle whose buffer is at `uri`, in a folder "scenes" of a folder that also has "secret.bin".
struct ExternalBuffer {
  TemporaryFolder folder;
  GltfBuilder b = one_triangle();
  Scene load_with(const std::string& uri) {
    b.document["buffers"] = json::array({{{"byteLength", b.binary.size()}, {"uri", uri}}});
    folder.write("secret.bin", b.binary);
    return load_scene(folder.write("scenes/scene.gltf", b.gltf()));
  }
};

TEST(GltfUri, FilesBesideTheScene) {
  ExternalBuffer e;
  e.folder.write("scenes/plain.bin", e.b.binary);
  e.folder.write("scenes/with space \xC3\xA4.bin", e.b.binary);
  e.folder.write("scenes/sub/deep.bin", e.b.binary);
  for (const char* uri :
       {"plain.bin", "./plain.bin", "with%20space%20%C3%A4.bin", "with space \xC3\xA4.bin",
        "sub/deep.bin", "sub/../plain.bin", "sub%2Fdeep.bin"})
    EXPECT_EQ(triangle_count(e.load_with(uri)), 1u) << uri;
  e.folder.write("scenes/long.bin", e.b.binary + "more");  // longer than claimed is fine
  EXPECT_EQ(triangle_count(e.load_with("long.bin")), 1u);
}

TEST(GltfUri, NothingOutsideTheFolder) {
  ExternalBuffer e;
  std::filesystem::create_symlink(e.folder.path / "secret.bin",
                                  (std::filesystem::create_directories(e.folder.path / "scenes"),
                                   e.folder.path / "scenes/link.bin"));
  const std::string absolute = (e.folder.path / "secret.bin").string();
  for (const std::string& uri :
       {std::string("../secret.bin"), std::string("sub/../../secret.bin"),
        std::string("..%2Fsecret.bin"), std::string("%2e%2e/secret.bin"), absolute,
        "%2F" + absolute.substr(1), std::string("link.bin"), "file://" + absolute,
        std::string("http://example.org/x.bin"), std::string("C:/x.bin")})
    expect_error([&] { e.load_with(uri); }, {"scene.gltf", "buffer 0", uri});
}

TEST(GltfUri, NoFileOrNotOne) {
  ExternalBuffer e;
  expect_error([&] { e.load_with("none.bin"); },
               {"scene.gltf", "buffer 0", "none.bin", "no such file"});
  expect_error([&] { e.load_with("%FF.bin"); },
               {"buffer 0", "\"%FF.bin\" cannot be read: there is"});
  expect_error([&] { e.load_with("."); }, {"buffer 0", "directory"});
  expect_error([&] { e.load_with(""); }, {"buffer 0", "empty"});
  expect_error([&] { e.load_with("a%00b"); }, {"buffer 0", "null"});
  e.folder.write("scenes/short.bin", "abc");
  expect_error([&] { e.load_with("short.bin"); }, {"buffer 0", "claims 36 bytes, there are 3"});
}

TEST(GltfUri, PathWithoutAFolder) {
  const TemporaryFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  GltfBuilder b = one_triangle();
  folder.write("data.bin", b.binary);
  b.document["buffers"] = json::array({{{"byteLength", b.binary.size()}, {"uri", "data.bin"}}});
  folder.write("scene.gltf", b.gltf());
  std::filesystem::current_path(folder.path);
  EXPECT_NO_THROW(load_scene("scene.gltf"));
  std::filesystem::current_path(before);
}

TEST(GltfBadInput, MissingFilesAndDirectories) {
  const TemporaryFolder folder;
  const std::string missing = (folder.path / "none.glb").string();
  expect_error([&] { load_scene(missing); }, {missing, "no such file"});
  expect_error([&] { load_scene(folder.path.string()); }, {folder.path.string(), "directory"});
  expect_error([&] { load_scene("/dev/null"); }, {"/dev/null", "not a regular file"});
  expect_error([&] { load_scene(""); }, {"no such file"});
}

TEST(GltfBadInput, NotGltf) {
  for (const char* text :
       {"", " ", "hello", "[]", "1", "null", "{}", "{\"asset\":{}}", "{\"asset\":{\"version\":2}}"})
    expect_error([&] { load_bytes(text); }, {"scene.gltf"});
  expect_error([&] { load_bytes("{\"asset\":{\"version\":\"1.0\"}}"); }, {"glTF 2.0", "1.0"});
  expect_error([&] { load_bytes("{\"asset\":{\"version\":\"2.1\",\"minVersion\":\"2.1\"}}"); },
               {"minVersion", "2.1"});
  expect_error([&] { load_bytes("{\"asset\":{\"version\":\"2.0\"},\"x\":1e999}"); },
               {"scene.gltf"});
  expect_error([&] { load_bytes("{\"asset\":{\"version\":\"2.0\"},\"x\":\"\xFF\"}"); },
               {"malformed"});
  expect_error([&] { load_bytes("{"); }, {"cut off at byte 1 of 1"});
}

TEST(GltfBadInput, NestingBombs) {
  const std::size_t depth = 1000000;
  expect_error([&] { load_bytes(std::string(depth, '[')); }, {"nested"});
  std::string objects;
  for (std::size_t i = 0; i < depth; ++i) objects += "{\"a\":";
  expect_error([&] { load_bytes(objects); }, {"nested"});
  const std::string extras = std::string(depth, '[') + std::string(depth, ']');
  expect_error([&] { load_bytes("{\"asset\":{\"version\":\"2.0\"},\"extras\":" + extras + "}"); },
               {"nested"});
  // Brackets in text nest nothing.
  EXPECT_NO_THROW(load_bytes("{\"asset\":{\"version\":\"2.0\"},\"extras\":\"\\\"" +
                             std::string(1000, '[') + "\"}"));
}

// A property of the wrong type must not be passed over.
TEST(GltfBadInput, WrongTypes) {
  const auto changed = [](const char* pointer, const json& value, const std::string& place) {
    GltfBuilder b = one_triangle();
    b.document[json::json_pointer(pointer)] = value;
    expect_load_error(b, {place, "expected"});
  };
  changed("/nodes", "foo", "nodes");
  changed("/nodes/0", 1, "nodes");
  changed("/scene", "0", "scene");
  changed("/scene", -1, "scene");
  changed("/scene", 4294967296, "scene");
  changed("/scenes/0/nodes", json::array({0.5}), "scenes[0].nodes");
  changed("/nodes/0/mesh", "0", "nodes[0].mesh");
  changed("/nodes/0/mesh", nullptr, "nodes[0].mesh");
  changed("/nodes/0/scale", json::array({1, 2}), "nodes[0].scale");
  changed("/nodes/0/matrix", json::array({1, 2}), "nodes[0].matrix");
  changed("/nodes/0/rotation", json::array({"a", 0, 0, 1}), "nodes[0].rotation");
  changed("/meshes/0/primitives", json::object(), "meshes[0].primitives");
  changed("/meshes/0/primitives/0/attributes", 3, "meshes[0].primitives[0].attributes");
  changed("/meshes/0/primitives/0/attributes/POSITION", -1, "meshes[0].primitives[0].attributes");
  changed("/meshes/0/primitives/0/indices", true, "meshes[0].primitives[0].indices");
  changed("/accessors/0/byteOffset", -4, "accessors[0].byteOffset");
  changed("/accessors/0/count", 1e40, "accessors[0].count");
  changed("/bufferViews/0/byteLength", "36", "bufferViews[0].byteLength");
}

TEST(GltfBadInput, HandlesThatLeadNowhere) {
  const auto changed = [](const char* pointer, const json& value,
                          const std::vector<std::string>& parts) {
    GltfBuilder b = one_triangle();
    b.document[json::json_pointer(pointer)] = value;
    expect_load_error(b, parts);
  };
  changed("/scenes/0/nodes/0", 9, {"scene 0", "node 9", "there are 1"});
  changed("/nodes/0/mesh", 9, {"node 0 \"node\"", "mesh 9", "there are 1"});
  changed("/nodes/0/children", json::array({9}), {"node 0", "child 9", "there are 1"});
  changed("/meshes/0/primitives/0/attributes/POSITION", 9,
          {"mesh 0", "primitive 0", "POSITION", "accessor 9"});
  changed("/meshes/0/primitives/0/mode", 9, {"mesh 0", "primitive 0", "mode", "found 9"});
  changed("/accessors/0/bufferView", 9, {"accessor 0", "buffer view 9"});
  changed("/accessors/0/componentType", 5130, {"accessor 0", "component type 5130"});
  changed("/accessors/0/componentType", 1, {"componentType"});
  changed("/accessors/0/type", "VEC2", {"POSITION", "2 components, expected 3"});
  changed("/accessors/0/type", "MAT4", {"POSITION", "accessor 0", "matrices"});
  changed("/accessors/0/type", "VEC9", {"VEC9"});
  changed("/bufferViews/0/buffer", 9, {"buffer view 0", "buffer 9", "there are 1"});
}

TEST(GltfBadInput, AccessorsPastTheirBuffer) {
  const auto changed = [](const char* pointer, const json& value,
                          const std::vector<std::string>& parts) {
    GltfBuilder b = one_triangle();
    b.document[json::json_pointer(pointer)] = value;
    expect_load_error(b, parts);
  };
  changed("/accessors/0/count", 4, {"accessor 0", "past the end"});
  changed("/accessors/0/count", std::uint64_t{1} << 40, {"accessor 0", "past the end"});
  changed("/accessors/0/count", std::uint64_t(-1), {"accessor 0", "past the end"});
  changed("/accessors/0/byteOffset", 4, {"accessor 0", "past the end"});
  changed("/accessors/0/byteOffset", std::uint64_t(-4), {"accessor 0", "past the end"});
  changed("/bufferViews/0/byteStride", 16, {"accessor 0", "past the end"});
  changed("/bufferViews/0/byteStride", 8, {"accessor 0", "overlap"});
  changed("/bufferViews/0/byteLength", 37, {"buffer view 0", "past the end of buffer 0"});
  changed("/bufferViews/0/byteLength", std::uint64_t(-1),
          {"buffer view 0", "past the end of buffer 0"});
  changed("/bufferViews/0/byteOffset", std::uint64_t(-36),
          {"buffer view 0", "past the end of buffer 0"});
}

TEST(GltfBadInput, ClaimsWithoutBytes) {
  // Accessors without a view are zeros and cost the file nothing.
  for (const std::uint64_t count :
       {std::uint64_t{1} << 40, std::uint64_t{1} << 31, std::uint64_t(-1)}) {
    GltfBuilder b;
    b.push("accessors", {{"componentType", 5126}, {"count", count}, {"type", "VEC3"}});
    b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", 0}}}})}});
    expect_load_error(b, {"too large"});
  }
  GltfBuilder b = one_triangle();
  b.document["buffers"] =
      json::array({{{"byteLength", std::uint64_t{1} << 40}, {"uri", data_uri(b.binary)}}});
  expect_load_error(b, {"buffer 0", "claims 1099511627776 bytes, there are 36"});
  b.document["buffers"] = json::array({{{"byteLength", 36}}});
  expect_load_error(b, {"buffer 0", "there are 0"});
}

TEST(GltfBadInput, SmallFilesThatGrow) {
  // Many primitives of many zeros, under many nodes.
  GltfBuilder b;
  b.push("accessors", {{"componentType", 5126}, {"count", 1000000}, {"type", "VEC3"}});
  const json primitive = {{"attributes", {{"POSITION", 0}}}};
  b.document["meshes"] = json::array({{{"primitives", json::array()}}});
  for (int i = 0; i < 1000; ++i) b.document["meshes"][0]["primitives"].push_back(primitive);
  b.root({{"mesh", 0}});
  expect_load_error(b, {"too large"});

  GltfBuilder nodes = one_triangle();
  json& primitives = nodes.document["meshes"][0]["primitives"];
  const json one = primitives[0];
  for (int i = 0; i < 3000; ++i) primitives.push_back(one);
  for (int i = 0; i < 3000; ++i) nodes.root({{"mesh", 0}});
  expect_load_error(nodes, {"too large"});
}

TEST(GltfBadInput, IndicesPastTheirVertices) {
  GltfBuilder b = one_triangle();
  b.document["meshes"][0]["name"] = "Cube";
  b.document["meshes"][0]["primitives"][0]["indices"] =
      b.accessor<std::uint16_t>({0, 1, 3}, "SCALAR");
  expect_load_error(b, {"mesh 0 \"Cube\"", "primitive 0", "index 2 is 3", "3 vertices"});
}

TEST(GltfBadInput, IndicesOfWrongTypes) {
  GltfBuilder b = one_triangle();
  json& primitive = b.document["meshes"][0]["primitives"][0];
  primitive["indices"] = b.accessor<float>({0, 1, 2}, "SCALAR");
  expect_load_error(b, {"accessor 1", "unsigned integer"});
  primitive["indices"] = b.accessor<std::int16_t>({0, 1, 2}, "SCALAR");
  expect_load_error(b, {"accessor 2", "unsigned integer"});
  primitive["indices"] = b.accessor<std::uint8_t>({0, 1, 2, 0}, "VEC2");
  expect_load_error(b, {"accessor 3", "scalars"});
  primitive["indices"] = 99;
  expect_load_error(b, {"accessor"});
}

TEST(GltfBadInput, PrimitiveRestart) {
  const auto with_last = [](int accessor_of(GltfBuilder&)) {
    GltfBuilder b;
    const int positions = b.accessor(std::vector<float>(3 * 70000), "VEC3");
    const int indices = accessor_of(b);
    b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}})}});
    expect_load_error(b, {"accessor 1", "index 2", "restart"});
  };
  with_last([](GltfBuilder& b) { return b.accessor<std::uint8_t>({0, 1, 255}, "SCALAR"); });
  with_last([](GltfBuilder& b) { return b.accessor<std::uint16_t>({0, 1, 65535}, "SCALAR"); });
  with_last([](GltfBuilder& b) { return b.accessor<std::uint32_t>({0, 1, 0xFFFFFFFF}, "SCALAR"); });
}

TEST(GltfBadInput, NumbersThatAreNone) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf, -inf}) {
    GltfBuilder b;
    const int positions = b.accessor<float>({0, 0, 0, 1, bad, 0, 0, 1, 0}, "VEC3");
    b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}}}})}});
    expect_load_error(b, {"accessor 0", "element 1", "not finite"});
  }
  GltfBuilder b = one_triangle();
  b.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
      b.accessor<float>({0, 0, 0, nan, 0, 0}, "VEC2");
  expect_load_error(b, {"accessor 1", "not finite"});
  b = one_triangle();
  b.document["nodes"][0]["scale"] = {1e300, 1e300, 1e300};
  b.document["nodes"][0]["children"] = {1};
  b.push("nodes", {{"scale", {1e300, 1, 1}}, {"mesh", 0}});
  expect_load_error(b, {"not finite"});
}

TEST(GltfBadInput, SparseAccessors) {
  const auto sparse = [](int count, int index, int index_type, std::vector<std::string> parts) {
    GltfBuilder b = one_triangle();
    const int indices = b.view(bytes_of(std::vector<std::int32_t>{index}));
    const int values = b.view(bytes_of(std::vector<float>{1, 2, 3}));
    b.document["accessors"][0]["sparse"] = {
        {"count", count},
        {"indices", {{"bufferView", indices}, {"componentType", index_type}}},
        {"values", {{"bufferView", values}}}};
    parts.push_back("accessor 0");
    expect_load_error(b, parts);
  };
  sparse(1, 3, 5125, {"sparse index 3", "3 elements"});
  sparse(1, -1, 5125, {"sparse index 4294967295"});
  sparse(2, 0, 5125, {"sparse indices", "past the end"});
  sparse(2, 0, 5123, {"sparse values", "past the end"});
  sparse(2147483647, 0, 5125, {"past the end"});
  sparse(1, 0, 5126, {"sparse indices of component type 5126"});
}

TEST(GltfBadInput, AttributesOfOtherLengths) {
  GltfBuilder b = one_triangle();
  json& attributes = b.document["meshes"][0]["primitives"][0]["attributes"];
  const int uv = b.accessor<float>({0, 0, 1, 1}, "VEC2");
  attributes["TEXCOORD_0"] = uv;
  expect_load_error(b, {"mesh 0", "TEXCOORD_0", "2 elements", "POSITION has 3"});
  attributes.erase("TEXCOORD_0");
  attributes["COLOR_0"] = b.accessor<std::uint8_t>({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, "VEC4");
  expect_load_error(b, {"COLOR_0", "not normalised"});
}

TEST(GltfBadInput, NodeGraphs) {
  const auto graph = [](const json& nodes, const std::vector<std::string>& parts) {
    GltfBuilder b = one_triangle();
    b.document["nodes"] = nodes;
    expect_load_error(b, parts);
  };
  graph({{{"children", {0}}}}, {"node 0", "cycle"});
  graph({{{"children", {1}}}, {{"children", {2}}}, {{"children", {1}}}}, {"node 1", "cycle"});
  graph({{{"mesh", 0}}, {{"children", {2}}}, {{"children", {1}}}}, {"cycle"});  // out of sight, too
  graph({{{"children", {1, 2}}}, {{"children", {3}}}, {{"children", {3}}}, json::object()},
        {"node 3", "two parents", "1 and 2"});
  graph({{{"children", {1, 1}}}, json::object()}, {"node 1", "two parents"});
  graph({{{"matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}}, {"node 0", "bottom row"});
  graph({{{"rotation", {0, 0, 0, 0}}}}, {"node 0", "quaternion"});
  GltfBuilder b = one_triangle();
  b.document["scenes"][0]["nodes"] = {0, 0};
  expect_load_error(b, {"scene 0", "node 0 twice"});
  b.document["nodes"] = {{{"children", {1}}}, json::object()};
  b.document["scenes"][0]["nodes"] = {1};
  expect_load_error(b, {"scene 0", "node 1", "no root"});
}

TEST(GltfBadInput, ManyPropertiesChangedAtRandom) {
  // Whatever one property becomes, the file loads or an omma::Error says why not.
  const GltfBuilder b = textured_triangle({{"uri", data_uri(png_1x1(1, 2, 3))}});
  const json whole = b.with_buffer();
  const json flat = whole.flatten();
  const TemporaryFolder folder;
  const std::vector<json> values = {nullptr,
                                    true,
                                    -1,
                                    0,
                                    1,
                                    2147483648u,
                                    1e300,
                                    -0.5,
                                    "",
                                    "x",
                                    json::array(),
                                    json::object(),
                                    json::array({1, 2, 3})};
  int loaded = 0, refused = 0;
  for (const auto& [pointer, ignored] : flat.items())
    for (const json& value : values) {
      json changed = whole;
      changed[json::json_pointer(pointer)] = value;
      try {
        load_scene(folder.write("scene.gltf", changed.dump()));
        ++loaded;
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("scene.gltf"), std::string::npos) << error.what();
        ++refused;
      }
    }
  EXPECT_GT(loaded, 0);
  EXPECT_GT(refused, loaded);  // most values are wrong in most places
}

}  // namespace
}  // namespace omma::test
