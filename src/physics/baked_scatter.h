// What surfaces make of light that was baked: diffuse lobes send of it to the eye at once; paths that
// gloss sends on are followed while they count.
#pragma once

#include "physics/baked.h"
#include "physics/path_scatter.h"

namespace omma {

// Paths that gloss sends on are all followed that count for so much, as the first on most surfaces
// do. Those that count for less go on by roulette, and then for so much: no path brings less than
// nothing, and none much more than it counts for.
inline constexpr float least_gloss = 1.0f / 64;

// The probability with which such a path goes on, of what it counts for. Paths between mirrors end too.
template <typename F, typename I>
OMMA_HD F gloss_survival(F largest, I scatterings) {
  const F bound = scatterings >= roulette_after ? broadcast<F>(most_survival) : broadcast<F>(1.0f);
  const F survival = largest * (1.0f / least_gloss);
  return survival < bound ? survival : bound;
}

// Adds what the diffuse lobes of some lanes' surfaces send to the eye.
template <typename L>
OMMA_HD void add_baked(const SceneView& scene, const PathState<L>& state,
                       const ScatteringPacket<L>& scattering, unsigned lanes,
                       const PathMemory& memory, float* radiance) {
  using F = typename L::F;
  constexpr int n = L::count;
  const int stride = scene.bands * n;
  for (int l = 0; l < n; l += L::width) {
    const auto scatters = lanes_on<L>(lanes, l);
    if (!any_lane(scatters)) continue;
    const F diffuse = scattering.point[l / L::width].diffuse;
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * n + l;
      // Lanes that met nothing have anything for spectra, also what is not a number.
      const F sent =
          keep(scatters, diffuse * load<F>(memory.throughput + at) *
                             (load<F>(memory.reflectance + at) * load<F>(memory.front + at) +
                              load<F>(memory.transmittance + at) * load<F>(memory.back + at)));
      if (!scene.polarized) {
        store(radiance + at, load<F>(radiance + at) + sent);
        continue;
      }
      for (int p = 0; p < 3; ++p) {
        float* const to = radiance + p * stride + at;
        store(to, load<F>(to) + keep(scatters, load<F>(state.mueller[3 * p] + l) * sent));
      }
    }
  }
}

}  // namespace omma
