// What of a glTF document may be read: each member of the schema (gltf_schema_rows.h) is of its type
// and in its range, and all else is taken out, so that nothing is read that was not checked.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace omma {

// An extension that Omma does not read, where the document has it.
struct GltfUnknownExtension {
  std::string first_place;  // such as "nodes[3]"; "" for the document itself
  int count = 0;            // objects that have it
  bool is_surface = true;   // all of them are materials, textures and images
};

// Throws omma::Error that names the path, the place (such as "meshes[0].primitives[1].indices"),
// what was expected and what was found. Takes out of the document what the schema does not know;
// returns the extensions among that by name.
std::map<std::string, GltfUnknownExtension> check_gltf_schema(nlohmann::json& document,
                                                              const std::string& path);

// Of every member of the schema the path, such as "materials[].normalTexture.index".
std::vector<std::string> gltf_schema_paths();

// A number that is whole and not negative, which JSON may write as 1 or 1.0 or 10e-1; none for all
// else. After the check above, get<int> and the like read either.
std::optional<std::uint64_t> gltf_whole_number(const nlohmann::json& value);

}  // namespace omma
