// What the flights of a packet's paths work on. A flight is one step of all of them: rays leave,
// meet surfaces or nothing, light is added to what they found, and those that go on have new rays.
// Functions of the lit path take this and what is theirs.
#pragma once

#include "physics/path/path_state.h"
#include "physics/rays/passed.h"
#include "physics/views/light_view.h"
#include "physics/views/path_memory.h"

namespace omma {

template <typename L, typename Search>
struct Flight {
  const SceneView& scene;
  Search& search;
  Packet<L>& packet;
  PathState<L>& state;
  const PathMemory& memory;  // throughput by band, spectra of surfaces, light on its way
  float* radiance;           // [component][band][lane], what paths have found; light is added to it
  const PassedSurfaces* passed;  // where surfaces let light straight through, else null
  float* cell_errors = nullptr;  // as PathMemory has them, where they count for these rays

  // Of Stokes vectors that are followed: I, or I, Q and U.
  OMMA_HD int components() const { return scene.polarized ? 3 : 1; }
  // From one component to the next, in what is [component][band][lane].
  OMMA_HD int stride() const { return scene.bands * L::count; }
};

// Whether surfaces or splats let light straight through: then rays remember which they have passed.
OMMA_HD bool lets_through(const SceneView& scene) {
  return scene.has_blend || scene.has_glass || scene.splats != nullptr;
}

// Whether Mueller matrices of paths differ by band.
OMMA_HD bool mirrors_by_band(const SceneView& scene) {
  return scene.polarized && scene.boundaries != nullptr;
}

// Whether next-event estimation chooses between lights at each surface.
OMMA_HD bool chooses_lights(const SceneView& scene) {
  return has_near_light(*scene.light) ||
         (scene.all_lights != nullptr && has_near_light(*scene.all_lights));
}

// Where a path remembers them.
OMMA_HD const PassedSurfaces* passed_in(const SceneView& scene, const PathMemory& memory) {
  return lets_through(scene) ? &memory.passed : nullptr;
}

}  // namespace omma
