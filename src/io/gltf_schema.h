// The types and ranges that the glTF 2.0 schema gives to every property Omma reads. Parsers tend to
// pass silently over a property of the wrong type; after this check there is none.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace omma {

// Throws omma::Error that names the path, the place (such as "meshes[0].primitives[1].indices"),
// what was expected and what was found.
void check_gltf_schema(const nlohmann::json& document, const std::string& path);

}  // namespace omma
