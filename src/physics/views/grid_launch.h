// What the kernels of a graphics card are given (physics/block/grid.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace omma {

struct FrameView;
struct SceneView;
struct BvhView;
struct SharedWeights;

// All behind these pointers is in the card's memory.
struct GridLaunch {
  const FrameView* frame = nullptr;     // of render, discs, gather
  const SceneView* searched = nullptr;  // whose surfaces say which hits count
  const BvhView* bvh = nullptr;
  const void* tasks = nullptr;            // BlockTask, GatherTask, WeighTask or RayPacket
  std::int64_t count = 0;                 // of tasks
  std::int64_t threads_each = 1;          // of a task
  const SharedWeights* shared = nullptr;  // of weigh
  std::int32_t outputs = 0;               // of weigh
  // [block of the grid][block_bytes, thread_bytes of each thread]
  std::byte* memory = nullptr;
  std::size_t block_bytes = 0, thread_bytes = 0;
};

}  // namespace omma
