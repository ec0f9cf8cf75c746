// The host's side of the emulated backend.
#include "emulated/emulated_backend.h"

#include <algorithm>
#include <mutex>

#include "backend/portable/portable_backend.h"
#include "backend/portable/portable_tracer.h"
#include "threads/cancel.h"

namespace omma::test {
namespace {

// Of a launch, so many tasks are run between two looks at whether all is cancelled.
constexpr std::size_t tasks_at_once = 4;

std::mutex one_at_a_time;
DeviceUse most;

template <typename Task>
void launch(LaunchKind kind, std::span<Task> tasks, const void* built, DeviceLaunch made) {
  const auto* tracer = static_cast<const PortableTracer*>(built);
  made.kind = kind;
  if (tracer != nullptr) {
    made.searched = tracer->scene_view;
    made.bvh = &tracer->view;
  }
  const std::lock_guard lock(one_at_a_time);
  for (std::size_t k = 0; k < tasks.size(); k += tasks_at_once) {
    check_cancelled();
    made.tasks = tasks.data() + k;
    made.count = static_cast<std::int64_t>(std::min(tasks_at_once, tasks.size() - k));
    const DeviceUse used = run_on_device(made);
    most.stack = std::max(most.stack, used.stack);
    most.memory = std::max(most.memory, used.memory);
  }
}

Launches launches() {
  Launches all;
  all.render = [](const FrameView& frame, std::span<const BlockTask> tasks, const void* tracer) {
    launch(LaunchKind::render, tasks, tracer, {.frame = &frame});
  };
  all.discs = [](const FrameView& frame, std::span<const BlockTask> tasks, const void* tracer) {
    launch(LaunchKind::discs, tasks, tracer, {.frame = &frame});
  };
  all.gather = [](const FrameView& frame, std::span<const GatherTask> tasks, const void* tracer) {
    launch(LaunchKind::gather, tasks, tracer, {.frame = &frame});
  };
  all.weigh = [](const SharedWeights& shared, int outputs, std::int64_t ommatidia,
                 std::span<const WeighTask> tasks) {
    launch(LaunchKind::weigh, tasks, nullptr,
           {.shared = &shared, .outputs = outputs, .ommatidia = ommatidia});
  };
  all.closest = [](std::span<RayPacket<packet_rays>> packets, const void* tracer) {
    launch(LaunchKind::closest, packets, tracer, {});
  };
  return all;
}

}  // namespace

Backend emulated_backend() {
  const Backend portable = portable_backend();
  return {"emulated", portable.build, portable.move, launches};
}

DeviceUse most_device_use() {
  const std::lock_guard lock(one_at_a_time);
  return most;
}

}  // namespace omma::test
