// Haze: what is left of light between two places, exp(-sigma d) (Bouguer's law), sigma the scene's
// extinction coefficient, alike everywhere and in all bands. It takes light and gives none. Light
// from afar and backgrounds are what arrives through it, as skies are measured from the ground:
// they are not dimmed once more.
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/rays/rays.h"
#include "physics/views/path_memory.h"
#include "physics/views/scene_view.h"

namespace omma {

// Beyond this exponent, 10^-26, haze hides no more: so what it leaves can be divided by.
inline constexpr float densest_haze = 60.0f;

// exp(-x), 0 <= x <= densest_haze, within 2 units in the last place; the same steps for one lane
// and for many, as a library's function differs between processors. x = k ln 2 + f (Cody and
// Waite), and of exp(-f), |f| <= ln 2 / 2, the series to the seventh power, which errs by 10^-8 of
// it.
template <typename F>
OMMA_HD F exp_minus(F x) {
  const F k = floor_lanes(x * 1.44269504f + 0.5f);
  const F f = (x - k * 0.693359375f) + k * 2.12194440e-4f;
  F sum = broadcast<F>(1.0f);
  for (int n = 7; n > 0; --n) sum = 1.0f - sum * f * (1.0f / static_cast<float>(n));
  return sum * float_of((127 - to_int(k)) << 23);
}

OMMA_HD bool has_haze(const SceneView& scene) {
  return scene.extinction_per_m > 0.0f;
}

// What haze leaves of light over a distance, m; all of it where that has no end.
template <typename F>
OMMA_HD F haze_transmittance(const SceneView& scene, F distance_m) {
  const F depth = distance_m * scene.extinction_per_m, most = broadcast<F>(densest_haze);
  const F left = exp_minus(depth < most ? depth : most);
  return distance_m < INFINITY ? left : broadcast<F>(1.0f);
}

// Dims the throughput of some lanes' paths by the haze before what their rays have met: all that
// this sends back then counts so much less. `left` [lane]: by how much.
template <typename L>
OMMA_HD_CALLED void dim_by_haze(const SceneView& scene, const RayPacket<L::count>& rays,
                                LaneMask<L> met, const SpectraMemory& memory, float* left) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    const F dims =
        met.at(l) ? haze_transmittance(scene, load<F>(rays.t_far_m + l)) : broadcast<F>(1.0f);
    store(left + l, dims);
    for (int b = 0; b < scene.bands; ++b) {
      float* const at = memory.throughput + b * L::count + l;
      store(at, load<F>(at) * dims);
    }
  }
}

// Takes that back for paths that go straight on: what they meet next is dimmed by all of the way.
template <typename L>
OMMA_HD_CALLED void undo_haze(const SceneView& scene, LaneMask<L> straight,
                              const SpectraMemory& memory, const float* left) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    const auto is = straight.at(l);
    for (int b = 0; b < scene.bands; ++b) {
      float* const at = memory.throughput + b * L::count + l;
      const F dimmed = load<F>(at);
      store(at, is ? dimmed / load<F>(left + l) : dimmed);
    }
  }
}

}  // namespace omma
