// The hot loop of the CPU backend: one block of neighbouring ommatidia at one pose, from directions
// to responses. Built once per instruction set from block.cpp; dispatch chooses at run time.
#pragma once

#include <cstdint>
#include <vector>

#include "backend/embree/tracer.h"
#include "backend/eye_arrays.h"
#include "sampling/directions.h"
#include "sampling/shared_rays.h"

namespace omma {

// Most ommatidia in one block, times their scrambles.
inline constexpr int block_capacity = 256;
// Most ommatidia at one ray each, so that a thousand keep sixteen cores busy; 256 gain 2 %.
inline constexpr int most_per_block = 64;
// Rays that a block has about; it has no more where an ommatidium has less than a packet's.
inline constexpr int block_rays = 512;

// Everything that stays the same between frames.
struct BlockContext {
  const EmbreeTracer* tracer = nullptr;
  const SceneView* scene = nullptr;
  const EyeArrays* eye = nullptr;
  const DirectionTables* directions = nullptr;  // [rounds]
  int scrambles = 1;                            // independent estimates of each response
  // Rendering to an error: a round of directions[k].samples rays, twice as many for each k, goes to
  // the ommatidia that need it until their standard error is `error` or their rays are
  // most_samples.
  int rounds = 1;
  double error = 0;
  int most_samples = 0;
  const std::uint8_t* nearest = nullptr;  // nearest_in_blocks
};

struct BlockTask {
  float world_from_head[3][4] = {};  // row major
  std::uint64_t pose = 0;            // index, for the random numbers
  int first = 0, count = 0;          // ommatidia, in the order of EyeArrays
  float* responses = nullptr;        // [ommatidium][channel] of this pose
  float* standard_error = nullptr;   // the same, or null
  std::int32_t* rays = nullptr;      // [ommatidium] of this pose, spent; or null
  float* ray_radiance = nullptr;     // [ommatidium][sample][channel] of this pose, or null
};

using RenderBlock = void (*)(const BlockContext&, const BlockTask&);
// Only writes the packets that a block traces, for measuring what tracing alone takes.
using PrepareBlock = void (*)(const BlockContext&, const BlockTask&, RTCRayHit16* packets);

// Responses [ommatidium][channel] of ommatidia first to end, from the radiance [ray][channel] of
// the rays they share (sampling/shared_rays.h).
using WeighRays = void (*)(const SharedRays&, const float* radiance, std::int64_t first,
                           std::int64_t end, float* responses);

struct BlockFunctions {
  RenderBlock render = nullptr;
  WeighRays weigh = nullptr;
  PrepareBlock prepare = nullptr;
};

namespace baseline {
void render_block(const BlockContext& context, const BlockTask& task);
void weigh_rays(const SharedRays& shared, const float* radiance, std::int64_t first,
                std::int64_t end, float* responses);
void prepare_block(const BlockContext& context, const BlockTask& task, RTCRayHit16* packets);
}  // namespace baseline
namespace avx2 {
void render_block(const BlockContext& context, const BlockTask& task);
void weigh_rays(const SharedRays& shared, const float* radiance, std::int64_t first,
                std::int64_t end, float* responses);
void prepare_block(const BlockContext& context, const BlockTask& task, RTCRayHit16* packets);
}  // namespace avx2
namespace avx512 {
void render_block(const BlockContext& context, const BlockTask& task);
void weigh_rays(const SharedRays& shared, const float* radiance, std::int64_t first,
                std::int64_t end, float* responses);
void prepare_block(const BlockContext& context, const BlockTask& task, RTCRayHit16* packets);
}  // namespace avx512

// The fastest of these that this processor runs.
BlockFunctions choose_block_functions();

}  // namespace omma
