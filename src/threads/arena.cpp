// oneTBB's limit of threads, raised for all of the process.
#include "threads/arena.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <mutex>
#include <string>

#include "omma/error.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Tests of the same bits ask for more threads than small machines have.
constexpr int always_allowed = 64, allowed_per_core = 4;

}  // namespace

void check_threads(int threads) {
  const int cores = oneapi::tbb::info::default_concurrency();
  const int most = std::max(always_allowed, allowed_per_core * cores);
  if (threads >= 0 && threads <= most) return;
  throw Error("threads: expected 0 (all) to " + std::to_string(most) + ", found " +
              std::to_string(threads) + " (this machine runs " + std::to_string(cores) +
              " at once)");
}

using oneapi::tbb::global_control;

std::unique_ptr<oneapi::tbb::task_arena> make_thread_arena(int threads) {
  // One limit for all renderers, the highest that was asked for: of several the lowest counts, and
  // an arena that asks for more makes oneTBB print a warning. It is raised by putting the new one
  // beside the old, so that it never falls, and stays until the process ends.
  static std::mutex mutex;
  static global_control* limit = nullptr;
  static std::size_t raised_to = 0;
  const std::lock_guard lock(mutex);
  const auto wanted = static_cast<std::size_t>(threads);
  const auto allowed = [] {
    return global_control::active_value(global_control::max_allowed_parallelism);
  };
  if (allowed() < wanted && raised_to < wanted) {
    auto* higher = new global_control(global_control::max_allowed_parallelism, wanted);
    delete limit;
    limit = higher;
    raised_to = wanted;
  }
  auto arena =
      std::make_unique<oneapi::tbb::task_arena>(static_cast<int>(std::min(wanted, allowed())));
  arena->initialize();
  return arena;
}

ThreadArena::ThreadArena(int wanted) {
  if (threads_are_gone()) {
    arena = std::make_unique<oneapi::tbb::task_arena>(1);
    return;
  }
  note_threads_are_used();
  arena = make_thread_arena(wanted > 0 ? wanted : oneapi::tbb::info::default_concurrency());
  threads = arena->max_concurrency();
}

ThreadArena::~ThreadArena() {
  if (threads_are_gone()) (void)arena.release();
}

}  // namespace omma
