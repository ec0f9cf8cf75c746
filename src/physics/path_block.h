// The paths of a block in a lit world: those of many packets are followed together, so that packets are
// full on all their flights.
#pragma once

#include "physics/lit_path.h"
#include "physics/waiting_paths.h"

namespace omma {

// Where paths of a block are put together; `radiance` [packet][component][band][lane] is of the
// rays from the eye.
template <typename L, typename Search>
struct PathBlock {
  const SceneView& scene;
  Search& search;
  const PathMemory& memory;
  float* radiance;
  WaitingPaths<L> waiting, waiting_for_last;
  Packet<L> onward;  // of paths that have waited
  std::int32_t ommatidium[block_rays];  // [ray], as Packet has it
};

template <typename L>
OMMA_HD int packet_floats(const SceneView& scene) {
  return (scene.polarized ? 3 : 1) * scene.bands * L::count;
}

template <typename L, typename Search>
OMMA_HD void put(PathBlock<L, Search>& block, unsigned lanes, Packet<L>& packet,
                 PathState<L>& state, const std::int32_t (&ray)[L::count]) {
  using I = typename L::I;
  unsigned last = 0;
  if (ends_in_the_dark(block.scene))
    last = lanes & bits_where<L>([&](int l) {
      return load<I>(state.scatterings + l) >= block.scene.depth;
    });
  if (last != 0)
    put<L>(block.scene, last, packet, state, ray, block.memory, block.waiting_for_last);
  if (last != lanes)
    put<L>(block.scene, lanes & ~last, packet, state, ray, block.memory, block.waiting);
}

// One more flight of paths that wait.
template <typename L, typename Search>
OMMA_HD void fly_waiting(PathBlock<L, Search>& block, WaitingPaths<L>& waiting) {
  constexpr int n = L::count;
  const SceneView& scene = block.scene;
  const int floats = packet_floats<L>(scene);
  PathState<L> state;
  alignas(n * 4) std::int32_t ray[n];
  const unsigned lanes = take<L>(scene, waiting, block.onward, state, ray, block.memory);
  for (unsigned bits = lanes; bits != 0; bits &= bits - 1) {
    const int l = lowest_bit(bits);
    block.onward.ommatidium[l] = block.ommatidium[ray[l]];
  }
  const unsigned polarised = scene.polarized ? bringing_polarisation<L>(state) : 0;
  float* const found = block.memory.found;
  for (int i = 0; i < floats; ++i) found[i] = 0;
  const unsigned on = fly<L>(scene, block.search, Spread::scattered, lanes, block.onward, state,
                             nullptr, block.memory, found);
  for (unsigned bits = lanes; bits != 0; bits &= bits - 1) {
    const int l = lowest_bit(bits);
    float* const to = block.radiance + ray[l] / n * floats + ray[l] % n;
    const int end = (polarised >> l & 1u) != 0 ? floats : scene.bands * n;
    for (int i = 0; i < end; i += n) to[i] += found[i + l];
  }
  if (on != 0) put<L>(block, on, block.onward, state, ray);
}

// Follows paths that wait, until fewer than `least` do.
template <typename L, typename Search>
OMMA_HD void follow(PathBlock<L, Search>& block, int least) {
  for (;;) {
    while (block.waiting_for_last.count >= L::count) fly_waiting<L>(block, block.waiting_for_last);
    if (block.waiting.count < least) break;
    fly_waiting<L>(block, block.waiting);
  }
  while (block.waiting_for_last.count >= least) fly_waiting<L>(block, block.waiting_for_last);
}

// Begins the paths of a packet, whose radiance goes to place number `packet_index`; others are
// followed as soon as there are as many as a packet holds.
template <typename L, typename Search>
OMMA_HD void begin_paths(PathBlock<L, Search>& block, int packet_index, const std::int32_t* valid,
                         Packet<L>& packet, FirstHits<L>* first) {
  constexpr int n = L::count;
  const SceneView& scene = block.scene;
  const int floats = packet_floats<L>(scene);
  float* const radiance = block.radiance + packet_index * floats;
  if (lets_through(scene))
    return eval_lit_path<L>(scene, block.search, valid, packet, block.memory, radiance, false, first);
  for (int i = 0; i < floats; ++i) radiance[i] = 0;
  PathState<L> state;
  begin_paths<L>(scene, state, block.memory);
  const unsigned on = fly<L>(scene, block.search, Spread::together, packet_bits<L>(valid), packet,
                             state, nullptr, block.memory, radiance, first);
  if (on == 0) return;
  alignas(n * 4) std::int32_t ray[n];
  for (int l = 0; l < n; ++l) {
    ray[l] = packet_index * n + l;
    block.ommatidium[ray[l]] = packet.ommatidium[l];
  }
  put<L>(block, on, packet, state, ray);
  follow<L>(block, n);
}

}  // namespace omma
