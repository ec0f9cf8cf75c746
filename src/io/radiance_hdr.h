// Radiance HDR pictures (.hdr): red, green, blue and a common exponent. stb reads them too, but
// some of its versions never return from one that is cut off.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "omma/scene.h"

namespace omma {

bool is_radiance_hdr(std::span<const std::uint8_t> bytes);

// Linear RGBA, alpha 1. `place` names the bytes in errors.
Image decode_radiance_hdr(std::span<const std::uint8_t> bytes, const std::string& place);

}  // namespace omma
