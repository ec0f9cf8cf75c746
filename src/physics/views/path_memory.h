// Scratch memory of a packet's paths: numbers by band, whose count is known at run time only, so that
// they do not lie on the stack. block_memory.h lays it out.
#pragma once

#include <cstddef>
#include <cstdint>

#include "physics/views/scene_view.h"

namespace omma {

// A surface that a ray has passed (rays/passed.h), as a search names it (RayPacket), and where it
// was met.
struct PassedSurface {
  std::uint32_t instance, geometry, triangle;
  float t_m, u, v;
};

// Of each lane; scratch memory of a thread.
struct PassedSurfaces {
  // Most surfaces in one place, which is a hundred-thousandth of the distance; a ray goes on behind
  // that place where there are more.
  static constexpr int capacity = 64;
  std::int32_t* count = nullptr;     // [lane]
  PassedSurface* surface = nullptr;  // [lane][capacity], in the order they were met
};

// How a ray has come to be in a volume: it begins at a surface within; straight through the
// boundary, or mirrored by that.
enum class Came : std::int32_t { from_within, straight, mirrored };

// What rays are in (path/media.h), [lane].
struct RayMedia {
  std::int32_t* material = nullptr;  // of the volume's boundary; no_medium, or seen_by_eye
  std::int32_t* came = nullptr;      // Came
  float* from_m = nullptr;  // up to where along the ray what the volume absorbs has counted
};

// What is known of a packet's rays and of the surfaces they met, all [band][lane].
struct SpectraMemory {
  float* throughput = nullptr;  // what light from the path's end still counts
  // Of the surfaces that were met; see LitSurface.
  float *reflectance = nullptr, *transmittance = nullptr, *emission = nullptr, *tint = nullptr;
  PassedSurfaces passed;  // where surfaces let rays through
  RayMedia media;         // where there are volumes
};

// Random signs under which errors of cells of baked light are summed up, at most: the mean square
// of so many such sums is the variance of a response, within a third of it.
inline constexpr int most_error_signs = 16;

// Of a scene: fewer where there are sums of Q and U too, so that a card's thread stays small. The
// standard error is within 30 % then.
OMMA_HD int error_signs(const SceneView& scene) {
  return scene.polarized ? 5 : most_error_signs;
}

// Such sums of an ommatidium.
OMMA_HD std::ptrdiff_t cell_error_count(const SceneView& scene) {
  return std::ptrdiff_t{scene.bands} * (scene.polarized ? 3 : 1) * error_signs(scene);
}

// Of a packet's paths; null where worlds are not lit.
struct PathMemory : SpectraMemory {
  float* light = nullptr;  // [component][band][lane], arriving
  // [9][band][lane], where Mueller matrices of paths differ by band (mirrors_by_band); else null.
  float* mueller = nullptr;
  // [band][lane], what white surfaces would send back of baked light, before and behind the one
  // that was met.
  float *front = nullptr, *back = nullptr;
  SpectraMemory shadow;  // of rays to lights
  // [band][slot], of paths that wait to go on, and of those that wait for their last flight; behind
  // it their [9][band][slot] where there is `mueller`.
  float *waiting = nullptr, *waiting_for_last = nullptr;
  float* found = nullptr;  // [component][band][lane], by paths that have waited
  // [ommatidium of the block][component][band][sign], sums over all rays; null where none
  // are asked for.
  float* cell_errors = nullptr;
};

}  // namespace omma
