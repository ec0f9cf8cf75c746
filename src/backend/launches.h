// What a backend is asked for: launches, each of a span of tasks that know nothing of each other. A
// processor runs them on the threads of the arena that it is called in, a graphics card as a grid.
#pragma once

#include <functional>
#include <span>

#include "backend/block_functions.h"

namespace omma {

// `tracer`: what the backend built of the scene (Acceleration). Each returns when all its tasks are
// done, throws omma::Cancelled where its work is cancelled, and may be called by several threads at
// once.
struct Launches {
  std::function<void(const FrameView&, std::span<const BlockTask>, const void* tracer)> render;
  // Adds what the tasks' ommatidia see of discs of the sky to their responses.
  std::function<void(const FrameView&, std::span<const BlockTask>, const void* tracer)> discs;
  // Radiance of rays that neighbouring ommatidia share into responses.
  std::function<void(const SharedWeights&, int outputs, std::span<const WeighTask>)> weigh;
  std::function<void(const FrameView&, std::span<const GatherTask>, const void* tracer)> gather;
  // Closest accepted hits, between t_near_m and t_far_m, of all rays.
  std::function<void(std::span<RayPacket<packet_rays>>, const void* tracer)> closest;
};

// Launches of a processor.
Launches launch_on_threads(const BlockFunctions& functions);

}  // namespace omma
