// Opacity maps of cut-outs: which parts of their triangles are surely there and which surely not,
// so that tracing seldom asks their images (physics/surface/opacity.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/views/scene_view.h"

namespace omma {

// The states of a scene's maps take no more than this, as much as an image of 360 x 360 texels, and
// so much for each triangle of a cut-out, less than half of what that takes in Embree and as
// shading data. Cards of leaves that are cut out alike share their states and take far less.
inline constexpr std::size_t most_opacity_bytes = std::size_t(1) << 20;
inline constexpr std::size_t most_opacity_bytes_per_triangle = 32;

struct OpacityMaps {
  // [mesh][triangle], MeshView::opacity; empty where a mesh is no cut-out.
  std::vector<std::vector<std::int32_t>> triangles;
  std::vector<std::int32_t> states;  // SceneView::opacity_states
};

// `triangle_counts`: [mesh]. A map decides only what is_above_cutoff would decide alike, in float
// arithmetic, at every place of a triangle.
OpacityMaps make_opacity_maps(const SceneView& scene, std::span<const std::size_t> triangle_counts);

}  // namespace omma
