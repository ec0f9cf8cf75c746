// The types and ranges that the glTF 2.0 schema gives to every property Omma reads. Parsers tend to
// pass silently over a property of the wrong type; after this check there is none.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace omma {

// Throws omma::Error that names the path, the place (such as "meshes[0].primitives[1].indices"),
// what was expected and what was found.
void check_gltf_schema(const nlohmann::json& document, const std::string& path);

// A number that is whole and not negative, which JSON may write as 1 or 1.0 or 10e-1; none for all
// else. After the check above, get<int> and the like read either.
std::optional<std::uint64_t> gltf_whole_number(const nlohmann::json& value);

}  // namespace omma
