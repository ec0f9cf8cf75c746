// Opacity maps of cut-outs: which parts of their triangles are surely there and which surely not,
// so that tracing seldom asks their images (physics/opacity.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/scene_view.h"

namespace omma {

// The states of a scene's maps take no more than this and so much for each triangle of a cut-out,
// which is a fifth of what the triangle itself takes in Embree and as shading data.
inline constexpr std::size_t most_opacity_bytes = std::size_t(1) << 20;
inline constexpr std::size_t most_opacity_bytes_per_triangle = 32;

struct OpacityMaps {
  std::vector<std::vector<std::int32_t>>
      triangles;                     // [mesh][triangle], MeshView::opacity; or empty
  std::vector<std::int32_t> states;  // SceneView::opacity_states
};

// `triangle_counts`: [mesh]. A map decides only what is_above_cutoff would decide alike, in float
// arithmetic, at every place of a triangle.
OpacityMaps make_opacity_maps(const SceneView& scene, std::span<const std::size_t> triangle_counts);

}  // namespace omma
