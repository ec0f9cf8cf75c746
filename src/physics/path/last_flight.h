// The last flight of a path, after which the depth allows none. Where only light from afar can be
// found by it, it is a shadow ray.
#pragma once

#include "physics/path/path_light.h"
#include "physics/path/transmittance.h"
#include "physics/rays/search_rays.h"

namespace omma {

// Whether the flight after the last scattering that the depth allows can only find light from afar.
OMMA_HD bool ends_in_the_dark(const SceneView& scene) {
  return scene.depth > 0 && scene.splats == nullptr && scene.light->emissive_count == 0 &&
         !has_air(scene);
}

// Lanes on such a flight: not rays from the eye, which have been mirrored within glass, say.
template <typename L>
OMMA_HD LaneMask<L> on_last_flight(const SceneView& scene, const PathState<L>& state) {
  if (!ends_in_the_dark(scene)) return {};
  const LaneMask<L> scattered = lanes_where<L>([&](int l) {
    return load<typename L::F>(state.density + l) < broadcast<typename L::F>(INFINITY);
  });
  return at_full_depth(scene, state) & scattered;
}

// The last flight of some lanes: whether anything hides the light from afar, and what is left of it
// behind what lets it through.
template <typename L, typename Search>
OMMA_HD_CALLED void trace_last_flight(const Flight<L, Search>& flight, LaneMask<L> on) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  const PathMemory& memory = flight.memory;
  FarLookups<L> far;
  look_up_far(flight, on, far);
  LaneMask<L> open;
  if (lets_through(scene)) {
    if (scene.has_volumes) go_on_in<L>(memory.shadow.media, memory.media);
    open = trace_transmittance<L>(scene, flight.search, on, flight.packet, memory.shadow);
    for (int i = 0; i < flight.stride(); i += L::width)
      store(memory.throughput + i,
            load<F>(memory.throughput + i) * load<F>(memory.shadow.throughput + i));
  } else {
    open = on & ~search_occluded(flight.search, on, flight.packet.rays);
  }
  if (open.any()) add_far(flight, open, far);
}

}  // namespace omma
