// What lies around the structure of a glTF file: the binary container, the JSON text, and the bytes
// that URIs point to. Nothing here knows meshes; nothing outside follows a URI.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/long_work.h"

namespace omma {

struct GltfContainer {
  std::string path;
  nlohmann::json document;                   // the JSON, checked by check_gltf_schema
  std::size_t file_size = 0;                 // bytes
  std::string file;                          // the whole file where it is a GLB, for its chunk
  std::size_t binary_begin = 0;              // of the GLB's binary chunk in `file`
  std::size_t binary_size = 0;               // bytes; 0 where there is none
  std::vector<std::string> buffers;          // [buffer], bytes from URIs
  std::vector<bool> buffer_is_binary_chunk;  // [buffer]
};

// From the bytes of a .gltf or .glb file at `path` (which names it in errors and whose folder its
// URIs are relative to). Buffers are read; images are not.
GltfContainer open_gltf(std::string file, const std::string& path, const WorkPart& work);

// The bytes of a buffer view. Throws omma::Error that starts with `place` where there is no such
// view or it reaches past its buffer.
std::span<const std::uint8_t> buffer_view_bytes(const GltfContainer& gltf, int view,
                                                const std::string& place);

// The bytes a URI stands for: a data URI, or a file in the scene's folder or below; everything
// else is an omma::Error that starts with `place` and names the URI.
std::string read_uri(const std::string& scene_path, const std::string& uri,
                     const std::string& place, const WorkPart& work);

}  // namespace omma
