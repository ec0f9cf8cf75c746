// The frame that scripts read: RGBA bytes, bottom row first, and how radiance becomes a byte.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace omma::compat {

using Rgba = std::array<std::uint8_t, 4>;

struct Frame {
  int width = 0, height = 0;
  std::vector<Rgba> pixels;  // [height][width], bottom row first
};

// Sizes under 1 become 1, as in CompoundRay; throws omma::Error where it would be enormous.
Frame make_frame(int width, int height);

// CompoundRay's display value: clamped to 0..1, to the power 1/2.2, times 255, truncated.
Rgba display_color(const float* rgb);

// Binary PPM (P6), top row first. Throws omma::Error.
void save_ppm(const std::string& path, const Frame& frame);

}  // namespace omma::compat
