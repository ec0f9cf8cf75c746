// Threads of a grid, one after the other. Their memory and stacks are painted before each launch,
// so that what they use is known, and what they have not written is not a zero by chance.
#include "emulated/device.h"

#include <pthread.h>

#include <cstdlib>
#include <cstring>
#include <functional>
#include <vector>

#include "backend/denormals.h"
#include "physics/block/thread.h"
#include "physics/path/gather.h"
#include "physics/surface/scene_search.h"

namespace omma::test {
namespace {

using Search = SceneSearch<OneLane>;

constexpr std::size_t stack_bytes = 1u << 17;
constexpr unsigned char paint = 0xff;  // not a number, as floats and as doubles

// Where the stack of a thread of the grid begins, which goes down from there.
const unsigned char* thread_begins = nullptr;

// Runs work() on a stack of its own; returns how much of that threads of the grid used.
std::size_t run_on_painted_stack(const std::function<void()>& work) {
  static unsigned char* const stack =
      static_cast<unsigned char*>(std::aligned_alloc(4096, stack_bytes));
  std::memset(stack, paint, stack_bytes);
  thread_begins = stack;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstack(&attributes, stack, stack_bytes);
  pthread_t thread;
  const auto run = [](void* given) -> void* {
    (*static_cast<const std::function<void()>*>(given))();
    return nullptr;
  };
  void* const given = const_cast<std::function<void()>*>(&work);
  if (pthread_create(&thread, &attributes, run, given) != 0) std::abort();
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  const unsigned char* deepest = stack;
  while (deepest < thread_begins && *deepest == paint) ++deepest;
  return static_cast<std::size_t>(thread_begins - deepest);
}

struct Threads {
  std::vector<std::byte> memory;
  DeviceUse use;

  explicit Threads(std::size_t bytes) : memory(bytes + 64) { use.memory = bytes; }
  // Painted anew.
  std::byte* painted() {
    std::memset(memory.data(), paint, memory.size());
    void* at = memory.data();
    std::size_t room = memory.size();
    return static_cast<std::byte*>(std::align(64, use.memory, at, room));
  }
};

template <typename Each>
[[gnu::noinline]] void run_thread(const Each& each, int i) {
  thread_begins = static_cast<const unsigned char*>(__builtin_frame_address(0));
  each(i);
}

template <typename Each>
void for_each_ommatidium(const BlockTask& task, const Each& each) {
  for (int i = 0; i < task.count; ++i) run_thread(each, i);
}

std::size_t bytes_of(const DeviceLaunch& launch) {
  Scratch counting;
  if (launch.kind == LaunchKind::closest) lay_out_visits(counting);
  if (launch.kind == LaunchKind::gather) lay_out(counting, *launch.frame, packet_rays);
  const bool is_block = launch.kind == LaunchKind::render || launch.kind == LaunchKind::discs;
  return is_block ? thread_bytes(*launch.frame) : counting.used;
}

void render_to_error(const DeviceLaunch& launch, const BlockTask& task, Threads& threads) {
  const FrameView& frame = *launch.frame;
  Scratch counting;
  lay_out_error(counting, frame);
  Threads of_block(counting.used);
  Scratch block{of_block.painted()};
  const ErrorMemory known = lay_out_error(block, frame);
  const auto for_each = [&](const auto& run) {
    for_each_ommatidium(task, [&](int i) {
      BlockMemory& memory = lay_out_thread(threads.painted(), frame);
      share_error(frame, known, i, memory);
      Search search{launch.searched, launch.bvh, memory.visits};
      run(BlockRun<Search>{frame, task, search, memory}, i);
    });
  };
  begin_error(frame, task, known);
  int rounds = 1;
  for (int scramble = 0; rounds > 0; ++scramble) {
    for (int k = 0; k < rounds; ++k)
      for_each([&](const BlockRun<Search>& run, int i) {
        trace_round_of_ommatidium(run, {k, scramble}, i);
      });
    rounds = choose_rounds(frame, task, known);
  }
  for_each([](const BlockRun<Search>& run, int i) { end_error_of_ommatidium(run, i); });
}

void run_blocks(const DeviceLaunch& launch, Threads& threads) {
  const FrameView& frame = *launch.frame;
  const auto* tasks = static_cast<const BlockTask*>(launch.tasks);
  for (std::int64_t k = 0; k < launch.count; ++k) {
    const BlockTask& task = tasks[k];
    if (launch.kind == LaunchKind::render && frame.most_samples > 0) {
      render_to_error(launch, task, threads);
      continue;
    }
    for_each_ommatidium(task, [&](int i) {
      const BlockMemory& memory = lay_out_thread(threads.painted(), frame);
      Search search{launch.searched, launch.bvh, memory.visits};
      const BlockRun<Search> run{frame, task, search, memory};
      if (launch.kind == LaunchKind::render)
        render_ommatidium(run, i);
      else
        render_discs_of_ommatidium(run, i);
    });
  }
}

// A thread has a packet, as the paths of a receiver take over points of each other.
void run_gather(const DeviceLaunch& launch, Threads& threads) {
  using Packets = Lanes<packet_rays, 1>;
  SceneSearch<Packets> search{launch.searched, launch.bvh};
  const auto* tasks = static_cast<const GatherTask*>(launch.tasks);
  for (std::int64_t k = 0; k < launch.count; ++k) {
    Scratch scratch{threads.painted()};
    const BlockMemory memory = lay_out(scratch, *launch.frame, packet_rays);
    gather_light<Packets>(*launch.frame->scene, search, tasks[k], memory.paths, memory.radiance);
  }
}

void run_weigh(const DeviceLaunch& launch) {
  const auto* tasks = static_cast<const WeighTask*>(launch.tasks);
  for (std::int64_t k = 0; k < launch.count; ++k)
    for (std::int64_t i = 0; i < launch.shared->ommatidium_count; ++i)
      weigh_rays<Lanes<weight_group, 1>>(*launch.shared, tasks[k].radiance, launch.outputs, i,
                                         i + 1, tasks[k].responses);
}

void run_closest(const DeviceLaunch& launch, Threads& threads) {
  Scratch scratch{threads.painted()};
  const Search search{launch.searched, launch.bvh, lay_out_visits(scratch)};
  // Packets are written: the launch's tasks are the caller's own.
  auto* packets = static_cast<RayPacket<packet_rays>*>(const_cast<void*>(launch.tasks));
  for (std::int64_t k = 0; k < launch.count; ++k)
    for (int l = 0; l < packet_rays; ++l) {
      RayPacket<packet_rays>& packet = packets[k];
      RayPacket<1> ray;
      clear<OneLane>(ray);
      for (int a = 0; a < 3; ++a) {
        ray.origin[a][0] = packet.origin[a][l];
        ray.direction[a][0] = packet.direction[a][l];
      }
      ray.t_near_m[0] = packet.t_near_m[l];
      ray.t_far_m[0] = packet.t_far_m[l];
      ray.mask[0] = packet.mask[l];
      ray.geometry[0] = ray.instance[0] = none;
      search.closest(LaneMask<OneLane>::all(), ray, nullptr);
      for (int a = 0; a < 3; ++a) packet.normal[a][l] = ray.normal[a][0];
      packet.t_far_m[l] = ray.t_far_m[0];
      packet.u[l] = ray.u[0];
      packet.v[l] = ray.v[0];
      packet.triangle[l] = ray.triangle[0];
      packet.geometry[l] = ray.geometry[0];
      packet.instance[l] = ray.instance[0];
    }
}

}  // namespace

DeviceUse run_on_device(const DeviceLaunch& launch) {
  const bool is_gather = launch.kind == LaunchKind::gather;
  Threads threads(bytes_of(launch));
  const std::size_t stack = run_on_painted_stack([&] {
    const DenormalsAreZero denormals_are_zero;
    switch (launch.kind) {
      case LaunchKind::render:
      case LaunchKind::discs:
        run_blocks(launch, threads);
        break;
      case LaunchKind::gather:
        run_gather(launch, threads);
        break;
      case LaunchKind::weigh:
        run_weigh(launch);
        break;
      case LaunchKind::closest:
        run_closest(launch, threads);
        break;
    }
  });
  return is_gather ? DeviceUse{} : DeviceUse{stack, threads.use.memory};
}

}  // namespace omma::test
