// What lies around the structure of a glTF file: the binary container, the JSON text, and the bytes
// that URIs point to. Nothing here knows meshes; nothing outside follows a URI.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/gltf_schema.h"
#include "model/long_work.h"
#include "omma/vec.h"

namespace omma {

// Memory that a file may still ask for: ample for meshes that share their vertices and nodes that
// share their meshes, too little for a file made to exhaust the memory. A small file can name the
// same bytes again and again.
struct GltfBudget {
  std::string path;
  std::uint64_t total = 0, left = 0;  // bytes
  void grow(std::uint64_t bytes_read);
  void spend(std::uint64_t count, std::uint64_t bytes_each);
};

struct GltfContainer {
  std::string path;
  nlohmann::json document;                  // the JSON, checked by check_gltf_schema
  std::map<std::string, GltfUnknownExtension> unknown_extensions;  // which that has taken out
  GltfBudget budget;                        // grows with every byte that is read
  std::string file;                         // the whole file where it is a GLB, for its chunk
  std::size_t binary_begin = 0;             // of the GLB's binary chunk in `file`
  std::size_t binary_size = 0;              // bytes; 0 where there is none
  std::map<std::string, std::string> read;  // bytes by the file they came from; each once
  std::vector<std::string_view> buffers;    // [buffer], null until it is first asked for
  std::map<int, std::vector<std::uint8_t>> unpacked;  // by buffer view, of those that are packed
  WorkPart reading;                         // of the buffers
};

// From the bytes of a .gltf or .glb file at `path` (which names it in errors and whose folder its
// URIs are relative to). Buffers and images are not read yet: files may list some that nobody uses.
GltfContainer open_gltf(std::string file, const std::string& path, const WorkPart& work);

// A top-level array of the document, empty where it is not there.
const nlohmann::json& gltf_list(const nlohmann::json& document, const char* array);

// Element `index` of a top-level array such as "bufferViews"; where there is none an omma::Error
// that says that `place` refers to, say, "buffer view" 7.
const nlohmann::json& gltf_element(const GltfContainer& gltf, const char* array, const char* what,
                                   int index, const std::string& place);

// What Omma calls itself in the files that it writes.
inline constexpr const char* omma_generator = "Omma";

// An extension of an object; an empty object where it is not there.
const nlohmann::json& gltf_extension(const nlohmann::json& object, const char* name);

// Of arrays of numbers.
float gltf_number(const nlohmann::json& values, std::size_t i);
Vec3 gltf_vec3(const nlohmann::json& values);

// " \"name\"" of an object that has one, else "".
std::string gltf_name(const nlohmann::json& object);

// The bytes of a buffer view; its buffer is read when it is first asked for. Throws omma::Error
// that starts with `place` where there is no such view or it reaches past its buffer.
std::span<const std::uint8_t> buffer_view_bytes(GltfContainer& gltf, int view,
                                                const std::string& place);

// The bytes a URI stands for: a data URI, or a file in the scene's folder or below; everything
// else is an omma::Error that starts with `place` and names the URI.
std::string read_uri(const std::string& scene_path, const std::string& uri,
                     const std::string& place, const WorkPart& work);

}  // namespace omma
