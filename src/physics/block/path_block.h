// The paths of a block in a lit world: those of many packets are followed together, so that packets
// are full on all their flights (waiting_paths.h). In one lane a path is followed to its end.
#pragma once

#include <type_traits>

#include "physics/block/block_memory.h"
#include "physics/path/lit_path.h"
#include "physics/path/polarized_paths.h"
#include "physics/path/waiting_paths.h"

namespace omma {

// Where paths of a block are put together.
template <typename L>
struct PathQueues {
  WaitingPaths<L> waiting, waiting_for_last;
  Packet<L> onward;                                               // of paths that have waited
  std::int32_t ommatidium[packets_at_once(L::count) * L::count];  // [ray], as Packet has it
};
struct NoQueues {};

// `radiance` [packet][component][band][lane] is of the rays from the eye.
template <typename L, typename Search>
struct PathBlock {
  const SceneView& scene;
  Search& search;
  const PathMemory& memory;
  float* radiance;
  std::conditional_t<(L::count > 1), PathQueues<L>, NoQueues> queues;
};

template <typename L, typename Search>
OMMA_HD void begin_block(std::uint32_t light_sees, PathBlock<L, Search>& block) {
  if constexpr (L::count > 1) {
    PathQueues<L>& queues = block.queues;
    const int throughputs = block.scene.bands * WaitingPaths<L>::capacity;
    queues.waiting.throughput = block.memory.waiting;
    queues.waiting.by_band = block.memory.waiting + throughputs;
    queues.waiting_for_last.throughput = block.memory.waiting_for_last;
    queues.waiting_for_last.by_band = block.memory.waiting_for_last + throughputs;
    clear<L>(queues.onward.rays);
    queues.onward.light_sees = light_sees;
  }
}

template <typename L>
OMMA_HD int packet_floats(const SceneView& scene) {
  return (scene.polarized ? 3 : 1) * scene.bands * L::count;
}

// Paths of some lanes wait; those whose last flight comes next, by themselves.
template <typename L, typename Search>
OMMA_HD void enqueue_paths(PathBlock<L, Search>& block, const Flight<L, Search>& flight,
                           LaneMask<L> lanes, const std::int32_t (&ray)[L::count]) {
  const LaneMask<L> last = lanes & on_last_flight(block.scene, flight.state);
  if (last.any()) enqueue(flight, last, ray, block.queues.waiting_for_last);
  if (!(last == lanes)) enqueue(flight, lanes & ~last, ray, block.queues.waiting);
}

// A later flight of the paths of some lanes, which finds what is added to the rays `ray` from the
// eye.
template <typename L, typename Search>
OMMA_HD Onward<L> trace_later_flight(const PathBlock<L, Search>& block,
                                     const Flight<L, Search>& flight, LaneMask<L> lanes,
                                     const std::int32_t (&ray)[L::count]) {
  constexpr int n = L::count;
  const SceneView& scene = block.scene;
  const int floats = packet_floats<L>(scene);
  float* const found = flight.radiance;
  const LaneMask<L> polarised =
      scene.polarized ? bringing_polarisation<L>(flight.state) : LaneMask<L>{};
  for (int i = 0; i < floats; ++i) found[i] = 0;
  const Onward<L> on = trace_flight(flight, lanes, Spread::scattered);
  // What they found goes to the rays from the eye that they began as.
  lanes.for_each([&](int l) {
    float* const to = block.radiance + ray[l] / n * floats + ray[l] % n;
    const int end = polarised.has(l) ? floats : scene.bands * n;
    for (int i = 0; i < end; i += n) to[i] += found[i + l];
  });
  return on;
}

// Paths of some lanes go on: those that were turned aside wait. What rays have passed does not wait
// with them, so that those that go straight on are followed until they are turned.
template <typename L, typename Search>
OMMA_HD void continue_block(PathBlock<L, Search>& block, const Flight<L, Search>& flight,
                            Onward<L> on, const std::int32_t (&ray)[L::count]) {
  for (;;) {
    if (on.turned.any()) enqueue_paths(block, flight, on.turned, ray);
    if (!on.straight.any()) return;
    on = trace_later_flight(block, flight, on.straight, ray);
  }
}

// What flights of a packet of the block work on; what they find is added to `radiance`.
template <typename L, typename Search>
OMMA_HD Flight<L, Search> flight_of(const PathBlock<L, Search>& block, Packet<L>& packet,
                                    PathState<L>& state, float* radiance) {
  const PathMemory& memory = block.memory;
  return {block.scene,
          block.search,
          packet,
          state,
          memory,
          radiance,
          passed_in(block.scene, memory),
          memory.cell_errors};
}

// One more flight of as many paths as a packet holds, of those that wait.
template <typename L, typename Search>
OMMA_HD void trace_waiting_flight(PathBlock<L, Search>& block, WaitingPaths<L>& waiting) {
  PathQueues<L>& queues = block.queues;
  PathState<L> state;
  alignas(L::count * 4) std::int32_t ray[L::count];
  const Flight<L, Search> flight = flight_of(block, queues.onward, state, block.memory.found);
  const LaneMask<L> lanes = dequeue(flight, waiting, ray);
  lanes.for_each([&](int l) { queues.onward.ommatidium[l] = queues.ommatidium[ray[l]]; });
  continue_block(block, flight, trace_later_flight(block, flight, lanes, ray), ray);
}

// Follows paths that wait, until fewer than `least` do.
template <typename L, typename Search>
OMMA_HD void trace_waiting(PathBlock<L, Search>& block, int least) {
  PathQueues<L>& queues = block.queues;
  for (;;) {
    while (queues.waiting_for_last.count >= L::count)
      trace_waiting_flight(block, queues.waiting_for_last);
    if (queues.waiting.count < least) break;
    trace_waiting_flight(block, queues.waiting);
  }
  while (queues.waiting_for_last.count >= least)
    trace_waiting_flight(block, queues.waiting_for_last);
}

// Follows what still waits.
template <typename L, typename Search>
OMMA_HD void end_block(PathBlock<L, Search>& block) {
  if constexpr (L::count > 1) trace_waiting(block, 1);
}

// Begins the paths of some lanes of a packet, whose radiance is that of number `packet_index`;
// others are followed as soon as there are as many as a packet holds.
template <typename L, typename Search>
OMMA_HD_CALLED void begin_paths(PathBlock<L, Search>& block, int packet_index, LaneMask<L> lanes,
                                Packet<L>& packet, FirstHits<L>* first) {
  constexpr int n = L::count;
  const SceneView& scene = block.scene;
  const int floats = packet_floats<L>(scene);
  float* const radiance = block.radiance + packet_index * floats;
  PathState<L> state;
  Flight<L, Search> flight = flight_of(block, packet, state, radiance);
  for (int i = 0; i < floats; ++i) radiance[i] = 0;
  reset_paths<L>(scene, state, block.memory);
  if (flight.passed != nullptr) clear<L>(*flight.passed);
  const Onward<L> on = trace_flight(flight, lanes, Spread::together, first);
  if (!on.all().any()) return;
  alignas(n * 4) std::int32_t ray[n];
  for (int l = 0; l < n; ++l) ray[l] = packet_index * n + l;
  flight.radiance = block.memory.found;
  if constexpr (n == 1) {
    LaneMask<L> one = on.all();
    while (one.any()) one = trace_later_flight(block, flight, one, ray).all();
  } else {
    for (int l = 0; l < n; ++l) block.queues.ommatidium[ray[l]] = packet.ommatidium[l];
    continue_block(block, flight, on, ray);
    trace_waiting(block, n);
  }
}

}  // namespace omma
