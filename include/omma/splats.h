// Gaussian splats (Kerbl et al. 2023, doi:10.1145/3592433): a place as photographs have it, a cloud
// of soft ellipsoids, each with an opacity and a colour that depends on the direction in which it
// is seen. They hold the light of their capture: nothing lights them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "omma/vec.h"

namespace omma {

// The space in which splats are composited, that in which they were trained: encoded as sRGB, or
// linear.
enum class SplatColor : std::uint8_t { srgb, linear };

// The direction of which a splat's colour is a function: from where the ray starts to the middle of
// the splat (Kerbl et al. 2023), or the ray's own (Moenne-Loccoz et al. 2024,
// doi:10.1145/3687934).
enum class SplatDirection : std::uint8_t { center, ray };

inline constexpr int most_splat_channels = 16;

// Splats of one capture, in their own frame.
struct SplatCloud {
  std::string name;
  std::vector<Vec3> positions;   // [splat], m, of their middles
  std::vector<Vec3> scales;      // [splat], m, standard deviations along their own axes
  std::vector<Vec4> rotations;   // [splat], unit quaternions x, y, z, w: cloud from own axes
  std::vector<float> opacities;  // [splat], 0 to 1, in the middle
  // [splat][term][channel], real spherical harmonics as Kerbl et al. have them: the colour in a
  // direction is 0.5 + Σ_k Y_k c_k, where that is positive.
  std::vector<float> harmonics;
  int terms = 1;  // 1, 4, 9 or 16: of degree 0 to 3
  // [channel], nm: from where to where the light of each channel is, 3 to 16 of them. Empty: three,
  // red, green and blue as materials have them. Where nothing is lit, the first three are those.
  std::vector<std::array<double, 2>> bands_nm;
  SplatColor color_space = SplatColor::srgb;
  SplatDirection direction = SplatDirection::center;
  std::vector<float> white{1, 1, 1};  // [channel], linear, of a colour of 1, behind decoding
  Mat4 world_from_splats;
  bool operator==(const SplatCloud&) const = default;
};

inline std::size_t channels_of(const SplatCloud& cloud) {
  return cloud.bands_nm.empty() ? 3 : cloud.bands_nm.size();
}

}  // namespace omma
