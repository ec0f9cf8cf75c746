// Gaussian splats of glTF: points with KHR_gaussian_splatting.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "io/gltf_container.h"
#include "io/gltf_warnings.h"
#include "io/gltf_writer.h"
#include "omma/splats.h"

namespace omma {

inline constexpr const char* splats_extension = "KHR_gaussian_splatting";

bool has_splats(const nlohmann::json& primitive);

// `place` names the primitive in errors. They are not placed.
SplatCloud read_gltf_splats(GltfContainer& gltf, const nlohmann::json& primitive,
                            const std::string& place, GltfWarnings& warnings);

// A primitive of them, not placed.
nlohmann::json written_splats(GltfWriter& writer, const SplatCloud& cloud);

}  // namespace omma
