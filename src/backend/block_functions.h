// The hot loop (physics/block/block.h) as a backend has built it for a kind of processor, chosen at run
// time.
#pragma once

#include <cstddef>

#include "physics/block/weigh.h"
#include "physics/views/frame_view.h"
#include "physics/views/gather_task.h"

namespace omma {

static_assert(packet_rays == weight_group);

struct BlockFunctions {
  // `tracer`: what the backend built; `memory`: block_memory_bytes, aligned to 64 bytes.
  void (*render)(const FrameView&, const BlockTask&, const void* tracer,
                 std::byte* memory) = nullptr;
  // Adds what the task's ommatidia see of discs of the sky to its responses.
  void (*discs)(const FrameView&, const BlockTask&, const void* tracer,
                std::byte* memory) = nullptr;
  void (*weigh)(const SharedWeights&, const float* radiance, int outputs, std::int64_t first,
                std::int64_t end, float* responses) = nullptr;
  void (*gather)(const FrameView&, const GatherTask&, const void* tracer,
                 std::byte* memory) = nullptr;
  void (*prepare)(const FrameView&, const BlockTask&, RayPacket<packet_rays>* packets) = nullptr;
  // Closest accepted hits, between t_near_m and t_far_m, of rays whose bit in `lanes` is set.
  void (*closest)(const void* tracer, unsigned lanes, RayPacket<packet_rays>& rays) = nullptr;
};

// What `render` needs, on each thread.
std::size_t block_memory_bytes(const FrameView& frame);

}  // namespace omma
