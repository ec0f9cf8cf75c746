// The glTF 2.0 schema, and those of the extensions that Omma reads, as a tree: of each object the
// members that are read. A member that is not here cannot be read (check_gltf_schema).
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace omma {

// What a member may be.
struct GltfKind {
  const char* expected = "";
  bool (*matches)(const nlohmann::json&) = nullptr;
  bool is_whole = false;  // nothing within is looked at; who reads it checks it
};

struct GltfMember {
  GltfKind kind{};
  bool is_required = false;
  bool is_list = false;    // of objects
  bool is_closed = false;  // an object in which an unknown member is an error
  std::map<std::string, GltfMember, std::less<>> members;
};

const GltfMember& gltf_schema();

}  // namespace omma
