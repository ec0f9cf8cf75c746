// Threads of a grid, one after the other. Their memory and stacks are painted before they begin, so
// that what they use is known, and what they have not written is not a zero by chance.
#include "emulated/device.h"

#include <pthread.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>

#include "backend/denormals.h"
#include "physics/block/grid.h"

namespace omma::test {
namespace {

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

template <typename Each>
[[gnu::noinline]] void run_thread(const Each& each, int i) {
  thread_begins =
      std::max(thread_begins, static_cast<const unsigned char*>(__builtin_frame_address(0)));
  each(i);
}

struct HostGrid {
  const GridLaunch& launch;
  int block, blocks;

  std::int64_t first() const { return block; }
  std::int64_t step() const { return blocks; }
  template <typename Each>
  void for_each(int count, const Each& each) {
    for (int i = 0; i < count; ++i) {
      std::memset(thread_memory(launch, *this, i), paint, launch.thread_bytes);
      run_thread(each, i);
    }
  }
  template <typename Ask>
  int once(const Ask& ask) {
    return ask();
  }
  std::byte* block_memory() const {
    return launch.memory + static_cast<std::size_t>(block) *
                               (launch.block_bytes + most_per_block * launch.thread_bytes);
  }
};

void run_block(CardKernel kernel, HostGrid grid) {
  switch (kernel) {
    case CardKernel::render:
      return render_tasks(grid.launch, grid);
    case CardKernel::discs:
      return render_discs_of_tasks(grid.launch, grid);
    case CardKernel::gather:
      return gather_tasks(grid.launch, grid);
    case CardKernel::weigh:
      return weigh_tasks(grid.launch, grid);
    case CardKernel::closest:
      return find_closest(grid.launch, grid);
    case CardKernel::count:
      std::abort();
  }
}

}  // namespace

DeviceUse run_on_device(const DeviceCall& call) {
  const std::size_t stack = run_on_painted_stack([&] {
    const DenormalsAreZero denormals_are_zero;
    for (int block = 0; block < call.blocks; ++block)
      run_block(call.kernel, {call.launch, block, call.blocks});
  });
  if (call.kernel == CardKernel::gather) return {};
  return {stack, call.launch.thread_bytes};
}

}  // namespace omma::test
