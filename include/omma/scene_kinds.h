// The plain values of a scene that device code knows too, which has no standard library: how images
// are read, what surfaces, lamps and backgrounds are, how many bands there may be. omma/scene.h
// includes it.
#pragma once

#include <cstdint>

namespace omma {

// Radiance comes in bands: those of linear RGB (sRGB primaries), unless the caller says otherwise,
// and at most so many.
inline constexpr int rgb_bands = 3, most_bands = 128;

enum class Wrap : std::uint8_t { repeat, mirrored_repeat, clamp_to_edge };
enum class Filter : std::uint8_t { nearest, linear };

enum class AlphaMode : std::uint8_t { opaque, mask, blend };

enum class PunctualLightType : std::uint8_t { directional, point, spot };

enum class BackgroundType : std::uint8_t { constant, simple_sky, test_pattern, image };

}  // namespace omma
