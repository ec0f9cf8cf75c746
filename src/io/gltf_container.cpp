// Containers, JSON text and URIs of glTF files. Sizes claimed by a file are compared with the bytes
// that are there before anything is allocated for them.
#include "io/gltf_container.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <optional>
#include <system_error>

#include "io/atomic_file.h"
#include "io/meshopt.h"
#include "model/text.h"
#include "omma/error.h"
#include "system/files.h"

namespace omma {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Deep enough for any exporter; shallow enough for code that walks JSON by recursion.
constexpr int max_json_depth = 200;

std::uint32_t little_endian_u32(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}

// Nested brackets outside strings. Only counts: malformed JSON is the parser's to report.
bool deeper_than(std::string_view text, int limit) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > limit) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

// Text that the work may be cancelled in: buffers as base64 make it long.
struct WatchedText {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;
  static constexpr std::ptrdiff_t piece = 1 << 20;

  const char *at, *end, *next_look;
  const WorkPart* work;
  std::ptrdiff_t size;

  static WatchedText begin_of(std::string_view text, const WorkPart& work) {
    const auto size = static_cast<std::ptrdiff_t>(text.size());
    const char* first = text.data();
    return {first, first + size, first + std::min(piece, size), &work, size};
  }
  static WatchedText end_of(std::string_view text) {
    const char* end = text.data() + text.size();
    return {end, end, end, nullptr, 0};
  }
  reference operator*() const { return *at; }
  WatchedText& operator++() {
    if (++at == next_look) look();
    return *this;
  }
  bool operator==(const WatchedText& other) const { return at == other.at; }
  void look() {
    work->reach(1.0 - static_cast<double>(end - at) / static_cast<double>(size));
    next_look = at + std::min(piece, end - at);
  }
};

json parse_json(std::string_view text, const std::string& path, const WorkPart& work) {
  if (deeper_than(text, max_json_depth))
    throw Error(path + ": its JSON is nested more than " + std::to_string(max_json_depth) +
                " levels deep");
  try {
    return json::parse(WatchedText::begin_of(text, work), WatchedText::end_of(text));
  } catch (const json::parse_error& error) {
    // The parser's own message may quote bytes that are no text.
    throw Error(path + ": is not a glTF file: its JSON is malformed or cut off at byte " +
                std::to_string(std::min(error.byte, text.size())) + " of " +
                std::to_string(text.size()));
  } catch (const json::exception& error) {
    throw Error(path + ": is not a glTF file: " + error.what());
  }
}

// The JSON chunk of a GLB; notes where the binary chunk is (glTF 2.0, section 4.4).
std::string_view open_glb(GltfContainer& gltf) {
  const std::string& file = gltf.file;
  const std::string place = gltf.path + ": binary glTF: ";
  if (file.size() < 12) throw Error(place + "ends within its header");
  const std::uint32_t version = little_endian_u32(file, 4);
  if (version != 2)
    throw Error(place + "expected container version 2, found " + std::to_string(version));
  const std::uint64_t length = little_endian_u32(file, 8);
  if (length > file.size())
    throw Error(place + "claims " + std::to_string(length) + " bytes, the file has " +
                std::to_string(file.size()));

  std::string_view text;
  std::uint64_t at = 12;
  for (int chunk = 0; at + 8 <= length; ++chunk) {
    const std::uint64_t size = little_endian_u32(file, at);
    const std::uint32_t type = little_endian_u32(file, at + 4);
    at += 8;
    if (size > length - at)
      throw Error(place + "chunk " + std::to_string(chunk) + " claims " + std::to_string(size) +
                  " bytes, " + std::to_string(length - at) + " are left");
    constexpr std::uint32_t json_type = 0x4E4F534A, binary_type = 0x004E4942;
    if (chunk == 0 && type != json_type) throw Error(place + "its first chunk is not JSON");
    if (chunk == 0) text = std::string_view(file).substr(at, size);
    if (chunk == 1 && type == binary_type) {
      gltf.binary_begin = at;
      gltf.binary_size = size;
    }
    at += size;
  }
  if (text.empty()) throw Error(place + "has no JSON chunk");
  return text;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string percent_decoded(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 &&
        hex_digit(text[i + 2]) >= 0) {
      decoded += static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2]));
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

// RFC 4648, padded or not. Empty where the text is not base64.
std::optional<std::string> base64_decoded(std::string_view text, const WorkPart& work) {
  static const auto values = [] {
    std::array<std::int8_t, 256> table;
    table.fill(-1);
    const std::string_view digits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t i = 0; i < digits.size(); ++i)
      table[static_cast<unsigned char>(digits[i])] = static_cast<std::int8_t>(i);
    return table;
  }();
  for (int padding = 0; padding < 2 && text.ends_with('='); ++padding) text.remove_suffix(1);
  if (text.size() % 4 == 1) return std::nullopt;

  std::string bytes(text.size() * 3 / 4, '\0');
  int all = 0;  // negative once any character is no digit
  for (std::size_t i = 0, out = 0; i < text.size(); i += 4) {
    if (i % (1 << 20) == 0) work.reach(static_cast<double>(i) / static_cast<double>(text.size()));
    std::uint32_t bits = 0;
    for (std::size_t k = i; k < i + 4; ++k) {
      const int value = k < text.size() ? values[static_cast<unsigned char>(text[k])] : 0;
      all |= value;
      bits = bits << 6 | static_cast<std::uint32_t>(value);
    }
    const std::size_t end = std::min(out + 3, bytes.size());
    for (int shift = 16; out < end; shift -= 8) bytes[out++] = static_cast<char>(bits >> shift);
  }
  if (all < 0) return std::nullopt;
  return bytes;
}

// data:[media type][;base64],data (RFC 2397). The media type is not trusted, so not looked at.
std::string read_data_uri(std::string_view uri, const std::string& place, const WorkPart& work) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) throw Error(place + ": its data URI has no comma");
  const std::string_view data = uri.substr(comma + 1);
  if (!uri.substr(0, comma).ends_with(";base64")) return percent_decoded(data);
  auto bytes = data.find('%') == std::string_view::npos
                   ? base64_decoded(data, work)
                   : base64_decoded(percent_decoded(data), work);
  if (!bytes) throw Error(place + ": its data URI is not valid base64");
  return *std::move(bytes);
}

// Where a URI that is no data URI leads: a file in the scene's folder or below, links resolved.
std::string uri_file(const std::string& scene_path, const std::string& uri,
                     const std::string& place) {
  const std::string name = percent_decoded(uri);
  const std::string refused = place + ": URI \"" + uri + "\" ";
  if (name.empty()) throw Error(refused + "is empty");
  if (name.find('\0') != std::string::npos) throw Error(refused + "has a null character");
  // A scheme (http:, file:, C:) is letters and digits before a colon, ahead of any slash.
  const std::size_t colon = uri.find(':');
  if (colon != std::string::npos && colon < uri.find('/'))
    throw Error(refused + "has a scheme; expected a data URI or a relative path");
  const fs::path relative = system::path_of(name);
  if (relative.has_root_path())
    throw Error(refused + "is an absolute path; expected one relative to the scene");

  // Symbolic links are resolved first, so that they cannot lead out either.
  std::error_code error;
  const fs::path parent = system::path_of(scene_path).parent_path();
  const fs::path folder = system::resolved(parent.empty() ? "." : parent, error);
  const fs::path target = error ? fs::path() : system::resolved(folder / relative, error);
  if (error) throw Error(refused + "cannot be followed: " + error.message());
  const auto [folder_end, ignored] =
      std::mismatch(folder.begin(), folder.end(), target.begin(), target.end());
  if (folder_end != folder.end()) throw Error(refused + "leads out of the scene's folder");
  return system::text_of(target);
}

std::string read_uri_file(const std::string& path, const std::string& uri, const std::string& place,
                          const WorkPart& work) {
  try {
    return read_file(path, work);
  } catch (const Error& problem) {
    // Without the decoded path, which begins the text of the problem.
    throw Error(place + ": URI \"" + uri + "\" cannot be read" +
                std::string(problem.what()).substr(readable_text(path).size()));
  }
}

// All bytes of a buffer. Buffers that name one file share what was read of it.
std::string_view read_buffer(GltfContainer& gltf, json& description, std::size_t index,
                             const std::string& place) {
  if (!description.contains("uri"))
    return index == 0 ? std::string_view(gltf.file).substr(gltf.binary_begin, gltf.binary_size)
                      : std::string_view();
  std::string& uri = description["uri"].get_ref<std::string&>();
  const bool data = uri.starts_with("data:");
  const std::string file = data ? "" : uri_file(gltf.path, uri, place);
  const auto [bytes, is_new] = gltf.read.try_emplace(data ? place : file);
  if (is_new) {
    const double each = 1.0 / static_cast<double>(gltf.buffers.size());
    const double before = each * static_cast<double>(index);
    const WorkPart work = gltf.reading.part(before, before + each);
    bytes->second = data ? read_data_uri(uri, place, work) : read_uri_file(file, uri, place, work);
    gltf.budget.grow(bytes->second.size());
  }
  uri = std::string();  // it may be most of the file
  return bytes->second;
}

// The bytes of a buffer, cut to its byteLength.
std::span<const std::uint8_t> buffer_bytes(GltfContainer& gltf, std::size_t index) {
  json& description = gltf.document["buffers"][index];
  const std::string place = gltf.path + ": buffer " + std::to_string(index);
  std::string_view& bytes = gltf.buffers[index];
  if (bytes.data() == nullptr) bytes = read_buffer(gltf, description, index, place);
  const auto length = description["byteLength"].get<std::uint64_t>();
  if (bytes.size() < length)
    throw Error(place + ": claims " + std::to_string(length) + " bytes, there are " +
                std::to_string(bytes.size()));
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<std::size_t>(length)};
}

// The bytes that an object with buffer, byteOffset and byteLength means.
std::span<const std::uint8_t> part_of_buffer(GltfContainer& gltf, const json& description,
                                             const std::string& inside) {
  const int buffer = description["buffer"].get<int>();
  gltf_element(gltf, "buffers", "buffer", buffer, inside);
  const std::span<const std::uint8_t> bytes = buffer_bytes(gltf, static_cast<std::size_t>(buffer));
  const std::uint64_t offset = description.value("byteOffset", std::uint64_t{0});
  const auto length = description["byteLength"].get<std::uint64_t>();
  if (offset > bytes.size() || length > bytes.size() - offset)
    throw Error(inside + ": its " + std::to_string(length) + " bytes from byte " +
                std::to_string(offset) + " on reach past the end of buffer " +
                std::to_string(buffer) + ", which has " + std::to_string(bytes.size()));
  return bytes.subspan(offset, length);
}

void check_version(const GltfContainer& gltf) {
  const json& asset = gltf.document.at("asset");
  const std::string version = asset.at("version").get<std::string>();
  if (!version.starts_with("2."))
    throw Error(gltf.path + ": asset.version: expected glTF 2.0, found \"" + version + "\"");
  if (asset.contains("minVersion") && asset["minVersion"].get<std::string>() != "2.0")
    throw Error(gltf.path + ": asset.minVersion: expected at most \"2.0\", found \"" +
                asset["minVersion"].get<std::string>() + "\"");
}

}  // namespace

void GltfBudget::grow(std::uint64_t bytes_read) {
  total += 256 * bytes_read;
  left += 256 * bytes_read;
}

void GltfBudget::spend(std::uint64_t count, std::uint64_t bytes_each) {
  if (count > left / bytes_each)
    throw Error(path + ": the scene is too large for its file: it asks for " +
                std::to_string(count) + " elements of " + std::to_string(bytes_each) +
                " bytes where at most " + std::to_string(total >> 20) +
                " MiB may come from a file of this size");
  left -= count * bytes_each;
}

const json& gltf_list(const json& document, const char* array) {
  static const json none = json::array();
  const auto found = document.find(array);
  return found == document.end() ? none : *found;
}

const json& gltf_element(const GltfContainer& gltf, const char* array, const char* what, int index,
                         const std::string& place) {
  const json& list = gltf_list(gltf.document, array);
  if (static_cast<std::size_t>(index) >= list.size())
    throw Error(place + ": refers to " + what + " " + std::to_string(index) + ", there are " +
                std::to_string(list.size()));
  return list[static_cast<std::size_t>(index)];
}

const json& gltf_extension(const json& object, const char* name) {
  static const json none = json::object();
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return none;
  const auto found = extensions->find(name);
  return found == extensions->end() ? none : *found;
}

float gltf_number(const json& values, std::size_t i) {
  return values[i].get<float>();
}

Vec3 gltf_vec3(const json& values) {
  return {gltf_number(values, 0), gltf_number(values, 1), gltf_number(values, 2)};
}

std::string gltf_name(const json& object) {
  const std::string name = object.value("name", "");
  return name.empty() ? name : " \"" + name + "\"";
}

std::string read_uri(const std::string& scene_path, const std::string& uri,
                     const std::string& place, const WorkPart& work) {
  if (uri.starts_with("data:")) return read_data_uri(uri, place, work);
  return read_uri_file(uri_file(scene_path, uri, place), uri, place, work);
}

std::span<const std::uint8_t> buffer_view_bytes(GltfContainer& gltf, int view,
                                                const std::string& place) {
  const json& description = gltf_element(gltf, "bufferViews", "buffer view", view, place);
  const std::string inside = place + ": buffer view " + std::to_string(view);
  const json& packing = gltf_extension(description, meshopt_extension);
  if (packing.empty() || !has_meshopt()) return part_of_buffer(gltf, description, inside);
  const auto [bytes, is_new] = gltf.unpacked.try_emplace(view);
  if (!is_new) return bytes->second;
  const std::uint64_t size = meshopt_size(packing, inside);
  const auto length = description["byteLength"].get<std::uint64_t>();
  if (size != length)
    throw Error(inside + ": claims " + std::to_string(length) + " bytes, " + meshopt_extension +
                " " + std::to_string(size));
  const std::span<const std::uint8_t> packed = part_of_buffer(gltf, packing, inside);
  gltf.budget.spend(size, 1);
  bytes->second = meshopt_unpacked(packing, packed, inside);
  return bytes->second;
}

GltfContainer open_gltf(std::string file, const std::string& path, const WorkPart& work) {
  GltfContainer gltf;
  gltf.path = path;
  gltf.file = std::move(file);
  if (gltf.file.empty()) throw Error(path + ": is empty, expected a glTF file");
  gltf.budget = {path, std::uint64_t{1} << 28, std::uint64_t{1} << 28};
  gltf.budget.grow(gltf.file.size());
  const bool binary = gltf.file.starts_with("glTF");
  gltf.document = parse_json(binary ? open_glb(gltf) : std::string_view(gltf.file), path, work);
  if (!binary) gltf.file = std::string();
  gltf.unknown_extensions = check_gltf_schema(gltf.document, path);
  check_version(gltf);
  gltf.buffers.resize(gltf_list(gltf.document, "buffers").size());
  return gltf;
}

}  // namespace omma
