// What a graphics card would run, run by a processor: each launch a grid of threads, each of which
// has one lane, a stack and memory of its own. All that it reads and writes is behind the pointers
// of a launch.
#pragma once

#include <cstddef>
#include <cstdint>

#include "backend/launches.h"
#include "physics/search/bvh.h"

namespace omma::test {

enum class LaunchKind : std::int32_t { render, discs, weigh, gather, closest };

struct DeviceLaunch {
  LaunchKind kind = LaunchKind::render;
  const FrameView* frame = nullptr;     // of render, discs, gather
  const SceneView* searched = nullptr;  // whose surfaces say which hits count
  const BvhView* bvh = nullptr;
  const void* tasks = nullptr;            // BlockTask, WeighTask, GatherTask or RayPacket
  std::int64_t count = 0;                 // of tasks
  const SharedWeights* shared = nullptr;  // of weigh, with these
  std::int32_t outputs = 0;
};

// The most that a thread had of a launch in one lane, bytes.
struct DeviceUse {
  std::size_t stack = 0, memory = 0;
};

DeviceUse run_on_device(const DeviceLaunch& launch);

}  // namespace omma::test
