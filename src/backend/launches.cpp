// Launches as parallel loops over their tasks.
#include "backend/launches.h"

#include <algorithm>

#include "physics/block/block_memory.h"
#include "threads/parallel.h"
#include "threads/thread_memory.h"

namespace omma {
namespace {

constexpr std::int64_t ommatidia_to_weigh = 256;  // by one thread at once

// A launch of `run`(frame, task, tracer, memory of the thread) for each task.
template <typename Run>
auto for_each_task(Run* run) {
  return [run](const FrameView& frame, auto tasks, const void* tracer) {
    const std::size_t bytes = block_memory_bytes(frame);
    parallel_for(std::size_t{0}, tasks.size(),
                 [&](std::size_t i) { run(frame, tasks[i], tracer, thread_memory(bytes)); });
  };
}

}  // namespace

std::size_t block_memory_bytes(const FrameView& frame) {
  Scratch scratch;
  lay_out(scratch, frame, packet_rays);
  return scratch.used;
}

Launches launch_on_threads(const BlockFunctions& functions) {
  Launches launches;
  launches.render = for_each_task(functions.render);
  launches.discs = for_each_task(functions.discs);
  launches.gather = for_each_task(functions.gather);
  launches.weigh = [weigh = functions.weigh](const SharedWeights& shared, int outputs,
                                             std::span<const WeighTask> tasks) {
    const std::int64_t ommatidia = shared.ommatidium_count;
    const std::int64_t pieces = (ommatidia + ommatidia_to_weigh - 1) / ommatidia_to_weigh;
    const auto all = static_cast<std::int64_t>(tasks.size()) * pieces;
    parallel_for(std::int64_t{0}, all, [&](std::int64_t i) {
      const WeighTask& task = tasks[static_cast<std::size_t>(i / pieces)];
      const std::int64_t first = i % pieces * ommatidia_to_weigh;
      weigh(shared, task.radiance, outputs, first, std::min(ommatidia, first + ommatidia_to_weigh),
            task.responses);
    });
  };
  launches.closest = [closest = functions.closest](std::span<RayPacket<packet_rays>> packets,
                                                   const void* tracer) {
    parallel_for(std::size_t{0}, packets.size(),
                 [&](std::size_t i) { closest(tracer, (1u << packet_rays) - 1, packets[i]); });
  };
  return launches;
}

}  // namespace omma
