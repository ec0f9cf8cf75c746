// Paths that have been turned aside wait here until there are as many as a packet holds, as in a
// wavefront path tracer (Laine, Karras and Aila 2013, Megakernels considered harmful): most packets
// would go on with few lanes, each at the price of all.
#pragma once

#include "physics/path/flight.h"

namespace omma {

// All [slot], those before `count` wait. Stores are a vector wide: some slots more are written.
template <typename L>
struct WaitingPaths {
  static constexpr int n = L::count, capacity = 3 * n;
  static constexpr std::size_t aligned = n * 4;
  int count = 0;
  alignas(aligned) float origin[3][capacity], direction[3][capacity], density[capacity];
  alignas(aligned) float reference[3][capacity], mueller[9][capacity];  // where light is polarised
  alignas(aligned) std::int32_t hash[capacity], sample[capacity],
      scatterings[capacity], flight[capacity], sampled_all[capacity];
  alignas(aligned) float footprint_rad[capacity];
  alignas(aligned) float chose_far[capacity], chose_surface[capacity], lit_normal[3][capacity];
  alignas(aligned) std::uint32_t mask[capacity];
  alignas(aligned) std::int32_t material[capacity], came[capacity];  // RayMedia
  alignas(aligned) std::int32_t ray[capacity];  // where its radiance goes
  float* throughput = nullptr;             // [band][capacity]
  float* by_band = nullptr;  // [9][band][capacity], where there is PathMemory::mueller
};

// Calls `move(waiting, of_packet)` for each number of a path but its throughput.
template <typename L, typename Search, typename Move>
OMMA_HD void for_each_number(const Flight<L, Search>& flight, WaitingPaths<L>& waiting,
                             const Move& move) {
  Packet<L>& packet = flight.packet;
  PathState<L>& state = flight.state;
  for (int r = 0; r < 3; ++r) {
    move(waiting.origin[r], packet.rays.origin[r]);
    move(waiting.direction[r], packet.rays.direction[r]);
  }
  move(waiting.density, state.density);
  move(waiting.hash, packet.hash);
  move(waiting.sample, packet.sample);
  move(waiting.scatterings, state.scatterings);
  move(waiting.flight, state.flight);
  move(waiting.sampled_all, state.sampled_all);
  move(waiting.footprint_rad, packet.footprint_rad);
  move(waiting.chose_far, state.chose_far);
  if (chooses_lights(flight.scene)) {
    move(waiting.chose_surface, state.chose_surface);
    for (int r = 0; r < 3; ++r) move(waiting.lit_normal[r], state.lit_normal[r]);
  }
  move(waiting.mask, packet.rays.mask);
  if (flight.scene.has_volumes) {
    move(waiting.material, flight.memory.media.material);
    move(waiting.came, flight.memory.media.came);
  }
  if (!flight.scene.polarized) return;
  for (int r = 0; r < 3; ++r) move(waiting.reference[r], packet.reference[r]);
  for (int k = 0; k < 9; ++k) move(waiting.mueller[k], state.mueller[k]);
}

// Adds the paths of some lanes; at most a packet waits before.
template <typename L, typename Search>
OMMA_HD void enqueue(const Flight<L, Search>& flight, LaneMask<L> lanes,
                     const std::int32_t (&ray)[L::count], WaitingPaths<L>& waiting) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  int count = waiting.count;
  for (int l = 0; l < L::count; l += L::width) {
    const unsigned here = lanes.word(l);
    if (here == 0) continue;
    for_each_number(flight, waiting, [&](auto* to, const auto* from) {
      store_some(to + count, load<F>(from + l), here);
    });
    store_some(waiting.ray + count, load<F>(ray + l), here);
    for (int b = 0; b < scene.bands; ++b)
      store_some(waiting.throughput + b * waiting.capacity + count,
                 load<F>(flight.memory.throughput + b * L::count + l), here);
    if (flight.memory.mueller != nullptr)
      for (int i = 0; i < 9 * scene.bands; ++i)
        store_some(waiting.by_band + i * waiting.capacity + count,
                   load<F>(flight.memory.mueller + i * L::count + l), here);
    count += bits_in(here);
  }
  waiting.count = count;
}

// Takes as many paths as a packet holds, or all; returns the lanes that hold one.
template <typename L, typename Search>
OMMA_HD LaneMask<L> dequeue(const Flight<L, Search>& flight, WaitingPaths<L>& waiting,
                            std::int32_t (&ray)[L::count]) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  Packet<L>& packet = flight.packet;
  constexpr int n = L::count;
  const int taken = waiting.count < n ? waiting.count : n, from = waiting.count - taken;
  for (int l = 0; l < n; l += L::width) {
    for_each_number(flight, waiting,
                    [&](const auto* kept, auto* to) { store(to + l, load<F>(kept + from + l)); });
    store(ray + l, load<F>(waiting.ray + from + l));
    for (int b = 0; b < scene.bands; ++b)
      store(flight.memory.throughput + b * n + l,
            load<F>(waiting.throughput + b * waiting.capacity + from + l));
    if (flight.memory.mueller != nullptr)
      for (int i = 0; i < 9 * scene.bands; ++i)
        store(flight.memory.mueller + i * n + l,
              load<F>(waiting.by_band + i * waiting.capacity + from + l));
  }
  // Nothing of their rays lies behind them.
  for (int l = 0; l < n; ++l) {
    packet.rays.t_near_m[l] = packet.acceptance_sr[l] = flight.state.seen_m[l] = 0;
    if (scene.has_volumes) flight.memory.media.from_m[l] = 0;
  }
  if (flight.passed != nullptr) clear<L>(*flight.passed);
  // Rays that are not traced must be such as could be: Embree checks all.
  for (int l = taken; l < n; ++l)
    for (int r = 0; r < 3; ++r) {
      packet.rays.origin[r][l] = 0;
      packet.rays.direction[r][l] = r == 1 ? 1.0f : 0.0f;
    }
  waiting.count = from;
  return LaneMask<L>::first(taken);
}

}  // namespace omma
