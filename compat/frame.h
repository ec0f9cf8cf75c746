// The frame that scripts read: RGBA bytes, bottom row first, and how radiance becomes a byte.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace omma::compat {

using Rgba = std::array<std::uint8_t, 4>;

struct Frame {
  int width = 400, height = 400;
  // [height][width], bottom row first.
  std::vector<Rgba> pixels = std::vector<Rgba>(std::size_t{400} * 400);
};

// Makes it that large and all zeros. Sizes under 1 become 1, as in CompoundRay; throws omma::Error
// where it would be enormous. A frame that is made smaller stays where it is, so that scripts may
// still hold the old one.
void resize(Frame& frame, int width, int height);

// CompoundRay's display value: clamped to 0..1, to the power 1/2.2, times 255, truncated.
Rgba display_color(const float* rgb);

// Binary PPM (P6), top row first. Throws omma::Error.
void save_ppm(const std::string& path, const Frame& frame);

}  // namespace omma::compat
