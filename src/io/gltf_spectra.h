// Spectra in the extras of materials and lights, for which glTF has no place: {"omma": {...}}, see
// docs/materials.md.
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "omma/spectrum.h"

namespace omma {

// What the extras of an object say to Omma; an empty object where that is nothing.
const nlohmann::json& omma_extras(const nlohmann::json& object);

// The member of that name, which check_gltf_schema has passed; empty where it is not there or null.
Spectrum read_spectrum(const nlohmann::json& parent, std::string_view name);
Spectrum read_spectrum(const nlohmann::json& spectrum);

nlohmann::json written_spectrum(const Spectrum& spectrum);

}  // namespace omma
