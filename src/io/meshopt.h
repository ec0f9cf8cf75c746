// EXT_meshopt_compression: buffer views of glTF files that are packed for meshoptimizer.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace omma {

inline constexpr const char* meshopt_extension = "EXT_meshopt_compression";

// Whether this build has meshoptimizer.
bool has_meshopt();

// How many bytes a view unpacks to, by what its extension says. Throws omma::Error that starts with
// `place` where what it says is not allowed.
std::uint64_t meshopt_size(const nlohmann::json& extension, const std::string& place);

// The unpacked bytes. Throws likewise where the packed ones are not whole.
std::vector<std::uint8_t> meshopt_unpacked(const nlohmann::json& extension,
                                           std::span<const std::uint8_t> packed,
                                           const std::string& place);

}  // namespace omma
