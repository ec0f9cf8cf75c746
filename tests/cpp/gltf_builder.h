// Small glTF files for tests, made field by field, and the bytes of small images. Everything is
// written into a folder of its own that goes when the test ends.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "omma/omma.h"

namespace omma::test {

using nlohmann::json;

// A fresh folder, removed with all that is in it.
struct TemporaryFolder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() /
      ("omma-test-" + std::to_string(std::random_device{}()) + std::to_string(next()++));
  TemporaryFolder() { std::filesystem::create_directories(path); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::filesystem::path target = path / name;
    std::filesystem::create_directories(target.parent_path());
    std::ofstream(target, std::ios::binary) << bytes;
    return target.string();
  }
  static std::atomic<int>& next() {
    static std::atomic<int> counter{0};
    return counter;
  }
};

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

inline std::string little_endian_u32(std::uint32_t v) {
  return {static_cast<char>(v), static_cast<char>(v >> 8), static_cast<char>(v >> 16),
          static_cast<char>(v >> 24)};
}

inline std::string big_endian_u32(std::uint32_t v) {
  const std::string little = little_endian_u32(v);
  return {little.rbegin(), little.rend()};
}

inline std::string base64(const std::string& bytes) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

inline std::string data_uri(const std::string& bytes,
                            const std::string& media_type = "application/octet-stream") {
  return "data:" + media_type + ";base64," + base64(bytes);
}

inline std::string from_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> (count -= 8));
  }
  return bytes;
}

// A chunk of a PNG with its checksum.
inline std::string png_chunk(const std::string& type, const std::string& data) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const char c : type + data) {
    crc ^= static_cast<unsigned char>(c);
    for (int k = 0; k < 8; ++k) crc = crc & 1 ? crc >> 1 ^ 0xEDB88320 : crc >> 1;
  }
  return big_endian_u32(static_cast<std::uint32_t>(data.size())) + type + data +
         big_endian_u32(~crc);
}

// A PNG with its data stored, not packed. `samples` are of 8 or 16 bit, [height][width][component];
// components 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA.
template <typename T>
std::string png(int width, int height, int components, const std::vector<T>& samples) {
  std::string rows;
  const auto row = static_cast<std::size_t>(width * components);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i % row == 0) rows += '\0';  // filter: none
    if (sizeof(T) == 2) rows += static_cast<char>(samples[i] >> 8 & 0xFF);
    rows += static_cast<char>(samples[i]);
  }
  std::string packed = "\x78\x01";
  std::uint32_t a = 1, b = 0;
  for (const char c : rows) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  for (std::size_t i = 0; i < rows.size(); i += 65535) {
    const std::size_t n = std::min<std::size_t>(65535, rows.size() - i);
    packed += i + n == rows.size() ? '\1' : '\0';
    const auto length = static_cast<std::uint32_t>(n | (~n & 0xFFFF) << 16);
    packed += little_endian_u32(length) + rows.substr(i, n);
  }
  packed += big_endian_u32(b << 16 | a);
  const char color_type[] = {'\0', '\0', '\4', '\2', '\6'};
  std::string header = big_endian_u32(static_cast<std::uint32_t>(width)) +
                       big_endian_u32(static_cast<std::uint32_t>(height));
  header += static_cast<char>(8 * sizeof(T));
  header += color_type[components];
  header += std::string(3, '\0');
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + png_chunk("IDAT", packed) +
         png_chunk("IEND", "");
}

inline std::string png_1x1(std::uint8_t r, std::uint8_t g, std::uint8_t b, std::uint8_t a = 255) {
  return png<std::uint8_t>(1, 1, 4, {r, g, b, a});
}

// Baseline JPEGs of 8 x 8 pixels: all (200, 100, 50), and all grey 160.
inline std::string color_jpeg() {
  return from_base64(
      "/9j/4AAQSkZJRgABAQAAAQABAAD/2wCEAAIBAQEBAQIBAQECAgICAgQDAgICAgUEBAMEBgUGBgYFBgYGBwkIBgcJ"
      "BwYGCAsICQoKCgoKBggLDAsKDAkKCgoBAgICAgICBQMDBQoHBgcKCgoKCgoKCgoKCgoKCgoKCgoKCgoKCgoKCgoK"
      "CgoKCgoKCgoKCgoKCgoKCgoKCgoKCv/AABEIAAgACAMBEQACEQEDEQH/xAGiAAABBQEBAQEBAQAAAAAAAAAAAQID"
      "BAUGBwgJCgsQAAIBAwMCBAMFBQQEAAABfQECAwAEEQUSITFBBhNRYQcicRQygZGhCCNCscEVUtHwJDNicoIJChYX"
      "GBkaJSYnKCkqNDU2Nzg5OkNERUZHSElKU1RVVldYWVpjZGVmZ2hpanN0dXZ3eHl6g4SFhoeIiYqSk5SVlpeYmZqi"
      "o6Slpqeoqaqys7S1tre4ubrCw8TFxsfIycrS09TV1tfY2drh4uPk5ebn6Onq8fLz9PX29/j5+gEAAwEBAQEBAQEB"
      "AQAAAAAAAAECAwQFBgcICQoLEQACAQIEBAMEBwUEBAABAncAAQIDEQQFITEGEkFRB2FxEyIygQgUQpGhscEJIzNS"
      "8BVictEKFiQ04SXxFxgZGiYnKCkqNTY3ODk6Q0RFRkdISUpTVFVWV1hZWmNkZWZnaGlqc3R1dnd4eXqCg4SFhoeI"
      "iYqSk5SVlpeYmZqio6Slpqeoqaqys7S1tre4ubrCw8TFxsfIycrS09TV1tfY2dri4+Tl5ufo6ery8/T19vf4+fr/"
      "2gAMAwEAAhEDEQA/AKFfywf2wf/Z");
}

inline std::string grey_jpeg() {
  return from_base64(
      "/9j/2wBDAAgBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEB"
      "AQEBAQH/wAALCAAIAAgBAREA/8QAFAABAAAAAAAAAAAAAAAAAAAABv/EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAI"
      "AQEAAD8AQP/Z");
}

// glTF component type of a C++ type.
template <typename T>
constexpr int component_type() {
  if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
  if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
  if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
  if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
  if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
  return 5126;
}

// A glTF document with one buffer, in `binary`. The document may be changed freely.
struct GltfBuilder {
  json document = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  std::string binary;

  int push(const char* array, json element) {
    document[array].push_back(std::move(element));
    return static_cast<int>(document[array].size()) - 1;
  }

  int view(const std::string& bytes, int stride = 0) {
    binary.resize((binary.size() + 3) / 4 * 4);
    json v = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}};
    if (stride > 0) v["byteStride"] = stride;
    binary += bytes;
    return push("bufferViews", v);
  }

  // Tightly packed elements; `type` such as "VEC3".
  template <typename T>
  int accessor(const std::vector<T>& values, const char* type, bool normalized = false) {
    const std::size_t components =
        std::string(type) == "SCALAR" ? 1 : static_cast<std::size_t>(type[3] - '0');
    json a = {{"bufferView", view(bytes_of(values))},
              {"componentType", component_type<T>()},
              {"count", values.size() / components},
              {"type", type}};
    if (normalized) a["normalized"] = true;
    return push("accessors", a);
  }

  int mesh(json primitive) {
    return push("meshes", {{"primitives", json::array({std::move(primitive)})}});
  }

  // A root node of scene 0.
  int root(json node) {
    const int index = push("nodes", std::move(node));
    document["scenes"][0]["nodes"].push_back(index);
    return index;
  }

  json with_buffer() const {
    json d = document;
    if (!binary.empty() && !d.contains("buffers"))
      d["buffers"] = json::array({{{"byteLength", binary.size()}, {"uri", data_uri(binary)}}});
    return d;
  }

  std::string gltf() const { return with_buffer().dump(); }

  std::string glb() const {
    json d = document;
    d["buffers"] = json::array({{{"byteLength", binary.size()}}});
    std::string text = d.dump(), data = binary;
    text.resize((text.size() + 3) / 4 * 4, ' ');
    data.resize((data.size() + 3) / 4 * 4);
    const auto size = [](const std::string& s) { return static_cast<std::uint32_t>(s.size()); };
    return "glTF" + little_endian_u32(2) + little_endian_u32(28 + size(text) + size(data)) +
           little_endian_u32(size(text)) + "JSON" + text + little_endian_u32(size(data)) +
           std::string("BIN\0", 4) + data;
  }
};

// The unit right triangle (0,0,0) (1,0,0) (0,1,0).
inline const std::vector<float> triangle_positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};

// A scene of one node with that triangle.
inline GltfBuilder one_triangle() {
  GltfBuilder b;
  const int positions = b.accessor(triangle_positions, "VEC3");
  b.root({{"name", "node"}, {"mesh", b.mesh({{"attributes", {{"POSITION", positions}}}})}});
  return b;
}

// The same with texture coordinates and a material that shows an image; `image` as in glTF.
inline GltfBuilder textured_triangle(json image) {
  GltfBuilder b = one_triangle();
  const int uv = b.accessor<float>({0, 0, 1, 0, 0, 1}, "VEC2");
  json& primitive = b.document["meshes"][0]["primitives"][0];
  primitive["attributes"]["TEXCOORD_0"] = uv;
  primitive["material"] = 0;
  b.push("images", std::move(image));
  b.push("textures", {{"source", 0}});
  b.push("materials",
         {{"name", "painted"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  return b;
}

inline Scene load(const GltfBuilder& b, const SceneOptions& options = {}) {
  const TemporaryFolder folder;
  return load_scene(folder.write("scene.gltf", b.gltf()), options);
}

// Runs `action`, which must throw an omma::Error whose message has all the parts.
template <typename Action>
void expect_error(Action action, const std::vector<std::string>& parts) {
  try {
    action();
  } catch (const Error& error) {
    for (const std::string& part : parts)
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
          << "\"" << part << "\" is missing in: " << error.what();
    return;
  }
  ADD_FAILURE() << "no omma::Error";
}

inline void expect_load_error(const GltfBuilder& b, std::vector<std::string> parts) {
  parts.push_back("scene.gltf");
  expect_error([&] { load(b); }, parts);
}

inline bool has_warning(const Scene& scene, const std::string& part) {
  for (const std::string& warning : scene.warnings)
    if (warning.find(part) != std::string::npos) return true;
  return false;
}

inline void expect_near(Vec3 a, Vec3 b, float tolerance = 0) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

inline void expect_near(Vec4 a, Vec4 b, float tolerance = 0) {
  expect_near(Vec3{a.x, a.y, a.z}, Vec3{b.x, b.y, b.z}, tolerance);
  EXPECT_NEAR(a.w, b.w, tolerance);
}

}  // namespace omma::test
