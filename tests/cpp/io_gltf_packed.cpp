// What is packed in glTF files: WebP pictures and buffer views for meshoptimizer.
#include <webp/encode.h>

#include "gltf_builder.h"
#include "io/image.h"

#ifdef OMMA_HAS_DRACO
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#endif
#ifdef OMMA_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace omma::test {
namespace {

// 4 x 2 pixels, without loss.
const std::vector<std::uint8_t> pixels = {
    255, 0, 0, 255, 0, 255, 0,  255, 0, 0, 255, 255, 9, 8, 7, 128,
    1,   2, 3, 255, 0, 255, 17, 0,   0, 9, 255, 255, 9, 8, 7, 1};

std::string webp() {
  std::uint8_t* encoded = nullptr;
  WebPConfig config;
  WebPPicture picture;
  WebPMemoryWriter writer;
  WebPConfigInit(&config);
  WebPPictureInit(&picture);
  WebPMemoryWriterInit(&writer);
  config.lossless = 1;
  config.exact = 1;  // colours stay where nothing is seen of them
  picture.use_argb = 1;
  picture.width = 4;
  picture.height = 2;
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  WebPPictureImportRGBA(&picture, pixels.data(), 16);
  EXPECT_TRUE(WebPEncode(&config, &picture));
  encoded = writer.mem;
  std::string bytes(reinterpret_cast<const char*>(encoded), writer.size);
  WebPMemoryWriterClear(&writer);
  WebPPictureFree(&picture);
  return bytes;
}

EncodedImage as_image(const std::string& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

TEST(Webp, WithoutLossIsReadToTheBit) {
  const Image image = decode_image(as_image(webp()), "picture");
  EXPECT_EQ(image.width, 4);
  EXPECT_EQ(image.height, 2);
  EXPECT_EQ(image.rgba_srgb8, pixels);
}

TEST(Webp, WithLossIsNear) {
  std::vector<std::uint8_t> grey(16 * 16 * 4, 120);
  std::uint8_t* encoded = nullptr;
  const std::size_t size = WebPEncodeRGBA(grey.data(), 16, 16, 64, 90, &encoded);
  const Image image = decode_image({encoded, size}, "picture");
  WebPFree(encoded);
  ASSERT_EQ(image.rgba_srgb8.size(), grey.size());
  for (std::size_t i = 0; i < grey.size(); ++i)
    EXPECT_NEAR(image.rgba_srgb8[i], 120, 2);  // an even grey, rounded in two colour spaces
}

TEST(Webp, CutOffOrDamagedIsAnError) {
  const std::string whole = webp();
  for (std::size_t size = 12; size < whole.size(); ++size)
    expect_error([&] { decode_image(as_image(whole.substr(0, size)), "picture"); }, {"picture: "});
  for (std::size_t at = 12; at < whole.size(); ++at)
    for (const int bit : {1, 16, 128}) {
      std::string bad = whole;
      bad[at] = static_cast<char>(bad[at] ^ bit);
      try {
        decode_image(as_image(bad), "picture");
      } catch (const Error& error) {
        EXPECT_TRUE(std::string(error.what()).starts_with("picture: ")) << error.what();
      }
    }
}

TEST(Webp, OfGltf) {
  GltfBuilder b = textured_triangle({{"uri", data_uri(png_1x1(1, 2, 3))}});
  b.push("images", {{"uri", data_uri(webp(), "image/webp")}});
  b.document["extensionsUsed"] = b.document["extensionsRequired"] = {"EXT_texture_webp"};
  b.document["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
  EXPECT_EQ(load(b).images.at(0).rgba_srgb8, pixels);  // in place of the one for others
  b.document["textures"][0].erase("source");
  EXPECT_EQ(load(b).images.at(0).rgba_srgb8, pixels);
  b.document["textures"][0]["extensions"] = {{"KHR_texture_basisu", {{"source", 1}}}};
  b.document.erase("extensionsRequired");
  EXPECT_TRUE(has_warning(load(b), "gltf-transform ktxdecompress in.glb out.glb (texture 0)"));
}

#ifdef OMMA_HAS_MESHOPTIMIZER

// A triangle whose positions and indices are packed, and nothing else of them in the file.
struct Packed {
  GltfBuilder b;
  json& positions() { return b.document["bufferViews"][0]["extensions"][extension]; }
  json& indices() { return b.document["bufferViews"][1]["extensions"][extension]; }
  static constexpr const char* extension = "EXT_meshopt_compression";
};

std::string packed_vertices(const void* vertices, std::size_t count, std::size_t stride) {
  std::string bytes(meshopt_encodeVertexBufferBound(count, stride), '\0');
  bytes.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(bytes.data()),
                                          bytes.size(), vertices, count, stride));
  return bytes;
}

json packing(int view, const GltfBuilder& b, std::size_t count, std::size_t stride,
             const char* mode) {
  json made = b.document["bufferViews"][static_cast<std::size_t>(view)];
  made["count"] = count;
  made["byteStride"] = stride;
  made["mode"] = mode;
  return made;
}

Packed packed_triangle(const char* mode) {
  Packed p;
  const std::vector<unsigned> corners = {0, 1, 2};
  std::string indices(256, '\0');
  auto* target = reinterpret_cast<unsigned char*>(indices.data());
  meshopt_encodeIndexVersion(1);
  indices.resize(std::string(mode) == "TRIANGLES"
                     ? meshopt_encodeIndexBuffer(target, indices.size(), corners.data(), 3)
                     : meshopt_encodeIndexSequence(target, indices.size(), corners.data(), 3));
  const int v = p.b.view(packed_vertices(triangle_positions.data(), 3, 12));
  const int i = p.b.view(indices);
  const json vertex_packing = packing(v, p.b, 3, 12, "ATTRIBUTES"),
             index_packing = packing(i, p.b, 3, 4, mode);
  p.b.document["bufferViews"] = {{{"buffer", 1}, {"byteLength", 36}, {"byteStride", 12}},
                                 {{"buffer", 1}, {"byteLength", 12}}};
  p.positions() = vertex_packing;
  p.indices() = index_packing;
  p.b.push("accessors", {{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  p.b.push("accessors",
           {{"bufferView", 1}, {"componentType", 5125}, {"count", 3}, {"type", "SCALAR"}});
  p.b.root({{"mesh", p.b.mesh({{"attributes", {{"POSITION", 0}}}, {"indices", 1}})}});
  p.b.document["buffers"] = {{{"byteLength", p.b.binary.size()}, {"uri", data_uri(p.b.binary)}},
                             {{"byteLength", 48}, {"extensions", {{Packed::extension, {{"fallback", true}}}}}}};
  p.b.document["extensionsRequired"] = {Packed::extension};
  return p;
}

TEST(Meshopt, BuffersAreUnpacked) {
  for (const char* mode : {"TRIANGLES", "INDICES"}) {
    const Scene scene = load(packed_triangle(mode).b);
    ASSERT_EQ(scene.meshes.size(), 1u);
    expect_near(scene.meshes[0].positions.at(1), {1, 0, 0});
    expect_near(scene.meshes[0].positions.at(2), {0, 1, 0});
    EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
    EXPECT_TRUE(scene.warnings.empty());
  }
}

TEST(Meshopt, FiltersAreUndone) {
  // Normals in bytes (within 1 / 127), turns in shorts, positions in 24 bits of floats.
  const std::vector<float> normals = {0, 0, 1, 0, 0.6f, 0, 0.8f, 0, 0, 1, 0, 0};
  std::string codes(12, '\0');
  meshopt_encodeFilterOct(codes.data(), 3, 4, 8, normals.data());
  std::string exponents(36, '\0');
  meshopt_encodeFilterExp(exponents.data(), 3, 12, 23, triangle_positions.data());
  GltfBuilder b;
  const int n = b.view(packed_vertices(codes.data(), 3, 4));
  const int p = b.view(packed_vertices(exponents.data(), 3, 12));
  json of_normals = packing(n, b, 3, 4, "ATTRIBUTES"),
       of_positions = packing(p, b, 3, 12, "ATTRIBUTES");
  of_normals["filter"] = "OCTAHEDRAL";
  of_positions["filter"] = "EXPONENTIAL";
  const int size = static_cast<int>(b.binary.size());
  b.document["bufferViews"] = {
      {{"buffer", 0}, {"byteLength", 12}, {"byteStride", 4}, {"extensions", {{Packed::extension, of_normals}}}},
      {{"buffer", 0}, {"byteLength", 36}, {"byteStride", 12}, {"extensions", {{Packed::extension, of_positions}}}}};
  b.document["buffers"] = {{{"byteLength", size}, {"uri", data_uri(b.binary)}}};
  b.push("accessors", {{"bufferView", 0}, {"componentType", 5120}, {"normalized", true}, {"count", 3}, {"type", "VEC3"}});
  b.push("accessors", {{"bufferView", 1}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", 1}, {"NORMAL", 0}}}})}});
  const Mesh mesh = load(b).meshes.at(0);
  expect_near(mesh.positions.at(1), {1, 0, 0}, 1e-6f);
  expect_near(mesh.normals.at(0), {0, 0, 1}, 0.01f);
  expect_near(mesh.normals.at(1), {0.6f, 0, 0.8f}, 0.01f);
}

TEST(Meshopt, WhatIsWrongIsSaid) {
  const auto with = [](const char* member, const json& value, const std::vector<std::string>& parts,
                       bool of_indices = false) {
    Packed p = packed_triangle("TRIANGLES");
    (of_indices ? p.indices() : p.positions())[member] = value;
    expect_load_error(p.b, parts);
  };
  const std::string place = "buffer view 0: EXT_meshopt_compression.";
  with("mode", "SQUARES", {place + "mode: expected ATTRIBUTES, TRIANGLES or INDICES"});
  with("filter", "SEPIA", {place + "filter: expected NONE"});
  with("byteStride", 6, {place + "byteStride: expected a multiple of 4"});
  with("byteStride", 0, {"byteStride"});
  with("count", 4, {"claims 36 bytes, EXT_meshopt_compression 48"});
  with("byteLength", 5, {"do not unpack to 3 elements of 12 bytes"});
  with("byteOffset", 100000, {"past the end of buffer 0"});
  with("buffer", 7, {"buffer 7"});
  with("byteStride", 8, {"byteStride: expected 2 or 4"}, true);
  with("filter", "OCTAHEDRAL", {"filter: expected NONE for TRIANGLES"}, true);
  Packed huge = packed_triangle("TRIANGLES");
  huge.positions()["count"] = 2147483647;
  huge.b.document["bufferViews"][0]["byteLength"] = std::uint64_t{2147483647} * 12;
  expect_load_error(huge.b, {"too large"});
}

#endif

#ifdef OMMA_HAS_DRACO

// A square of two triangles with normals, as Draco packs it.
std::string packed_square(int method) {
  const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, up[3] = {0, 0, 1};
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int normal = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
  for (std::uint32_t f = 0; f < 2; ++f) {
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(f), corners[0], corners[f + 1],
                                      corners[f + 2]);
    builder.SetAttributeValuesForFace(normal, draco::FaceIndex(f), up, up, up);
  }
  const auto mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer packed;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &packed).ok());
  return {packed.data(), packed.size()};
}

GltfBuilder draco_square(int method) {
  GltfBuilder b;
  const int view = b.view(packed_square(method));
  b.push("accessors", {{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  b.push("accessors", {{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  b.push("accessors", {{"componentType", 5125}, {"count", 6}, {"type", "SCALAR"}});
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}},
                           {"indices", 2},
                           {"extensions",
                            {{"KHR_draco_mesh_compression",
                              {{"bufferView", view},
                               {"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}}}}}})}});
  b.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return b;
}

TEST(Draco, MeshesAreUnpacked) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const Scene scene = load(draco_square(method));
    ASSERT_EQ(scene.meshes.size(), 1u);
    const Mesh& mesh = scene.meshes[0];
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(mesh.triangles.size(), 2u);
    ASSERT_EQ(mesh.positions.size(), 4u);
    double area = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3 p = mesh.positions[a], q = mesh.positions[b], r = mesh.positions[c];
      area += 0.5 * ((q.x - p.x) * (r.y - p.y) - (r.x - p.x) * (q.y - p.y));
    }
    EXPECT_NEAR(area, 1, 1e-6);
    for (const Vec3 normal : mesh.normals) expect_near(normal, {0, 0, 1}, 1e-5f);
  }
}

TEST(Draco, WhatIsWrongIsSaid) {
  const auto with = [](const char* pointer, const json& value,
                       const std::vector<std::string>& parts) {
    GltfBuilder b = draco_square(draco::MESH_EDGEBREAKER_ENCODING);
    b.document[json::json_pointer(pointer)] = value;
    expect_load_error(b, parts);
  };
  const std::string primitive = "/meshes/0/primitives/0/";
  const std::string extension = primitive + "extensions/KHR_draco_mesh_compression/";
  with("/accessors/0/count", 5, {"POSITION", "accessor 0 has 5 elements", "4"});
  with("/accessors/0/type", "VEC2", {"attribute 0 is not of 2 components"});
  with((primitive + "mode").c_str(), 5, {"mode: expected 4", "found 5"});
  with((extension + "bufferView").c_str(), 9, {"buffer view 9"});
  with((extension + "attributes/POSITION").c_str(), 7, {"has no attribute 7"});
  with((extension + "attributes/COLOR_0").c_str(), 1, {"has no \"COLOR_0\""});
  GltfBuilder cut = draco_square(draco::MESH_EDGEBREAKER_ENCODING);
  cut.document["bufferViews"][0]["byteLength"] = 20;
  expect_load_error(cut, {"primitive 0: KHR_draco_mesh_compression: its 20 bytes do not unpack"});
}

TEST(Draco, ChangedBytesAreReadOrRefused) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const GltfBuilder b = draco_square(method);
    for (std::size_t at = 0; at < b.binary.size(); ++at)
      for (const int change : {1, 64, 128, 255}) {
        GltfBuilder bad = b;
        bad.binary[at] = static_cast<char>(bad.binary[at] ^ change);
        try {
          load(bad);
        } catch (const Error& error) {
          EXPECT_NE(std::string(error.what()).find("scene.gltf"), std::string::npos);
        }
      }
  }
}

#endif

}  // namespace
}  // namespace omma::test
