// Gaussian splats on lit paths. They hold the light of their capture, which is added as emission
// is, and dim all light that comes from behind them; nothing lights them.
#pragma once

#include "physics/path/path_light.h"
#include "physics/path/splat_light.h"

namespace omma {

// Light of splats on the way of a flight to what it met, and what they leave of the throughput.
// `first`: has what the rays met, and takes the splats before it; or null.
template <typename L, typename Search>
OMMA_HD_CALLED void pass_splats(const Flight<L, Search>& flight, LaneMask<L> on,
                                FirstHits<L>* first) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  float(&seen_m)[L::count] = flight.state.seen_m;
  SplatLight<L> light;
  light.channels = scene.splats->channels;
  SplatDepths<L> depths;
  eval_splats<L>({*scene.splats, flight.search.visits_of_trees()}, on, flight.packet.rays, seen_m,
                 light, first == nullptr ? nullptr : &depths);
  if (first != nullptr) meet_splats(scene, depths, *first);
  alignas(L::count * 4) float weight[L::count];
  for (int l = 0; l < L::count; l += L::width) {
    store(weight + l, keep(on.at(l), broadcast<F>(1.0f)));
    for (int b = 0; b < scene.bands; ++b) {
      const float* row = scene.splat_emission + light.channels * b;
      F sum{};
      for (int i = 0; i < light.channels; ++i) sum += load<F>(light.color[i] + l) * row[i];
      store(flight.memory.light + b * L::count + l, sum);
    }
  }
  add_light<L>(flight, weight, nullptr, flight.memory.light);
  for (int l = 0; l < L::count; l += L::width) {
    const F through = on.at(l) ? load<F>(light.transmittance + l) : broadcast<F>(1.0f);
    for (int b = 0; b < scene.bands; ++b) {
      float* const at = flight.memory.throughput + b * L::count + l;
      store(at, load<F>(at) * through);
    }
    store(seen_m + l, on.at(l) ? load<F>(flight.packet.rays.t_far_m + l) : load<F>(seen_m + l));
  }
}

}  // namespace omma
