// The host's side of the emulated backend: copies what a launch reads and the card does not have
// yet, asks the card's process to run it, and brings back what it wrote.
#include "emulated/emulated_backend.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "backend/copy_arrays.h"
#include "backend/portable/portable_backend.h"
#include "backend/portable/portable_tracer.h"
#include "emulated/device_memory.h"
#include "omma/error.h"
#include "threads/cancel.h"

namespace omma::test {
namespace {

// Of a launch, so many tasks are run between two looks at whether all is cancelled: some tenths of a
// second.
std::size_t tasks_at_once(LaunchKind kind) {
  return kind == LaunchKind::closest ? 4096 : 32;
}

// The card: a process and the memory that it shares.
class Device {
 public:
  Device() {
    const int memory = memfd_create("emulated device", 0);
    int ends[2];
    if (memory < 0 || ftruncate(memory, static_cast<off_t>(device_bytes)) != 0 ||
        socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0)
      throw Error("emulated device: no memory for it");
    void* const wanted = reinterpret_cast<void*>(device_address);
    if (mmap(wanted, device_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED_NOREPLACE, memory,
             0) != wanted)
      throw Error("emulated device: its address is taken");
    const std::string memory_text = std::to_string(memory), end_text = std::to_string(ends[1]);
    if (fork() == 0) {
      close(ends[0]);
      execl(OMMA_EMULATED_DEVICE, OMMA_EMULATED_DEVICE, memory_text.c_str(), end_text.c_str(),
            static_cast<char*>(nullptr));
      _exit(127);
    }
    close(ends[1]);
    close(memory);
    socket_ = ends[0];
    fcntl(socket_, F_SETFD, FD_CLOEXEC);
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device() { close(socket_); }  // ends the process

  DeviceUse run(const DeviceLaunch& launch) {
    DeviceUse use;
    if (send(socket_, &launch, sizeof launch, MSG_NOSIGNAL) != sizeof launch ||
        read(socket_, &use, sizeof use) != sizeof use)
      throw Error("emulated device: it has died of a launch");
    return use;
  }

 private:
  int socket_ = -1;
};

std::mutex one_at_a_time;
DeviceUse most;
KeptCopies kept;

// The card is there from its first launch on.
Device& device() {
  static Device the_one;
  return the_one;
}

// What a launch searches and from where it is seen, in the card's memory.
struct Copied {
  Device& card = device();
  DeviceCopies memory{kept};
  ArrayCopies<DeviceCopies> arrays{memory};

  template <typename View, typename... More>
  const View* view(View copied, const More&... more) {
    arrays.point_to_copies(copied, more...);
    return memory.read(&copied, 1, 0);
  }
  DeviceLaunch searching(LaunchKind kind, const void* built) {
    const auto* tracer = static_cast<const PortableTracer*>(built);
    DeviceLaunch made;
    made.kind = kind;
    made.searched = view(*tracer->scene_view);
    made.bvh = view(tracer->view);
    return made;
  }
  // `tasks`: in the card's memory.
  template <typename Task>
  void run(DeviceLaunch made, const Task* tasks, std::size_t count) {
    const std::size_t step = tasks_at_once(made.kind);
    for (std::size_t k = 0; k < count; k += step) {
      check_cancelled();
      made.tasks = tasks + k;
      made.count = static_cast<std::int64_t>(std::min(step, count - k));
      const DeviceUse used = card.run(made);
      most.stack = std::max(most.stack, used.stack);
      most.memory = std::max(most.memory, used.memory);
    }
    memory.bring_back();
  }
  template <typename Task, typename... More>
  void run_tasks(const DeviceLaunch& made, std::span<const Task> tasks, const More&... more) {
    std::vector<Task> own(tasks.begin(), tasks.end());
    for (Task& task : own) arrays.point_to_copies(task, more...);
    run(made, memory.read(own.data(), own.size(), 0), own.size());
  }
};

// Blocks or receivers.
template <typename Task, typename... More>
void launch_frame(LaunchKind kind, const FrameView& frame, std::span<const Task> tasks,
                  const void* built, const More&... more) {
  const std::lock_guard lock(one_at_a_time);
  Copied copied;
  DeviceLaunch made = copied.searching(kind, built);
  made.frame = copied.view(frame);
  copied.run_tasks(made, tasks, more...);
}

Launches launches() {
  Launches all;
  all.render = [](const FrameView& frame, std::span<const BlockTask> tasks, const void* tracer) {
    launch_frame(LaunchKind::render, frame, tasks, tracer, frame);
  };
  all.discs = [](const FrameView& frame, std::span<const BlockTask> tasks, const void* tracer) {
    launch_frame(LaunchKind::discs, frame, tasks, tracer, frame);
  };
  all.gather = [](const FrameView& frame, std::span<const GatherTask> tasks, const void* tracer) {
    launch_frame(LaunchKind::gather, frame, tasks, tracer, frame.scene->bands);
  };
  all.weigh = [](const SharedWeights& shared, int outputs, std::span<const WeighTask> tasks) {
    const std::lock_guard lock(one_at_a_time);
    Copied copied;
    DeviceLaunch made;
    made.kind = LaunchKind::weigh;
    made.shared = copied.view(shared);
    made.outputs = outputs;
    copied.run_tasks(made, tasks, shared, outputs);
  };
  all.closest = [](std::span<RayPacket<packet_rays>> packets, const void* tracer) {
    const std::lock_guard lock(one_at_a_time);
    Copied copied;
    const DeviceLaunch made = copied.searching(LaunchKind::closest, tracer);
    copied.run(made, copied.memory.written(packets.data(), packets.size()), packets.size());
  };
  return all;
}

}  // namespace

void* DevicePart::copy(const void* from, std::size_t bytes) {
  const std::size_t room = (bytes + 127) / 64 * 64;  // something lies between arrays
  if (used + room > size) throw Error("emulated device: its memory is full");
  void* const place = reinterpret_cast<void*>(begin + used);
  used += room;
  if (bytes > 0) std::memcpy(place, from, bytes);
  return place;
}

const void* KeptCopies::read(const void* array, std::size_t bytes, Version version) {
  const void*& place = kept_[{array, bytes, version}];
  if (place == nullptr) {
    place = part_.copy(array, bytes);
    copied += bytes;
  } else if (std::memcmp(place, array, bytes) != 0) {
    throw Error("emulated device: an array of " + std::to_string(bytes) +
                " bytes has changed, and has the version that it had");
  }
  return place;
}

void KeptCopies::make_room() {
  if (part_.used < part_.size / 2) return;
  kept_.clear();
  part_.used = 0;
}

Backend emulated_backend() {
  const auto build = [](const Scene& scene, const SceneView& view, const Placement& placement,
                        WorkState* work) {
    return Acceleration{portable_backend().build(scene, view, placement, work).tracer, "emulated"};
  };
  return {"emulated", build, portable_backend().move, launches};
}

DeviceUse take_device_use() {
  const std::lock_guard lock(one_at_a_time);
  return std::exchange(most, {});
}

std::size_t take_kept_bytes() {
  const std::lock_guard lock(one_at_a_time);
  return std::exchange(kept.copied, 0);
}

}  // namespace omma::test
