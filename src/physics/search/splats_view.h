// Gaussian splats (omma/splats.h) as the physics sees them: those of all clouds of a scene under
// one hierarchy of boxes. Made by backend/splat_data.
#pragma once

#include <cstdint>

#include "physics/search/bvh.h"
#include "physics/views/version.h"

namespace omma {

// Thresholds of the model with which splats are trained (Kerbl et al. 2023, and their program):
// a splat covers at most so much of what is behind, counts where it covers no less, and light from
// where less than this gets through is left out.
inline constexpr float most_splat_alpha = 0.99f, least_splat_alpha = 1.0f / 255;
inline constexpr float least_splat_transmittance = 1e-4f;

inline constexpr int most_harmonics = 16;       // of degree 3
inline constexpr int splat_channels_kept = 16;  // most_splat_channels

// A splat as rays search it.
struct alignas(64) TracedSplat {
  float center[3];        // m, in the frame in which the world was traced at first
  float whitening[3][3];  // [row][column]: of offsets from the middle, to standard deviations
  float opacity;
  // Where the square of what whitening gives is larger, it covers less than counts; below 0 where
  // nothing is in this place.
  float most_square;
  std::uint32_t cloud, splat;  // index into SplatsView::clouds, and in it
};
static_assert(sizeof(TracedSplat) == 64);

struct SplatCloudView {
  float cloud_from_frame[3][3] = {};  // of directions
  const float* harmonics = nullptr;   // [splat][term][channel]
  std::int32_t splat_count = 0, terms = 1, channels = 3;
  bool by_ray = false;  // SplatDirection::ray
};

inline constexpr int splats_per_leaf = 4, splats_per_block = 2;

struct SplatsView {
  const WideNode* nodes = nullptr;      // the first is the root; leaves are blocks of splats
  const TracedSplat* splats = nullptr;  // [block][splats_per_block]
  const SplatCloudView* clouds = nullptr;
  const float* first_origin_m = nullptr;  // [3], of the frame of splats in the traced one
  bool is_srgb = true;                    // SplatColor::srgb
  float white[splat_channels_kept] = {};  // linear, of a colour of 1
  std::int32_t channels = 3;
  std::int64_t node_count = 0, splat_count = 0;
  std::int32_t cloud_count = 0;
  Version version = 0;  // of all but first_origin_m
};

}  // namespace omma
