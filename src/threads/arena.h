// Threads of renderers: oneTBB starts no more than the process allows, and says so on stderr where
// an arena asks for more.
#pragma once

#include <oneapi/tbb/task_arena.h>

#include <memory>

namespace omma {

// Throws omma::Error where so many make no sense: below 0, and far more than the machine runs at
// once, which only cost memory and time to start.
void check_threads(int threads);

// An arena of `threads` threads, or as many as oneTBB allows: 257 on most machines, and fewer where
// something else in the process has set a limit. The machine may have fewer.
std::unique_ptr<oneapi::tbb::task_arena> make_thread_arena(int threads);

// The threads of a world or a renderer.
struct ThreadArena {
  std::unique_ptr<oneapi::tbb::task_arena> arena;
  int threads = 1;  // that it has

  // 0: one per hardware thread. In a process without threads (threads_are_gone) nobody enters it.
  explicit ThreadArena(int wanted);
  ThreadArena(const ThreadArena&) = delete;
  ThreadArena& operator=(const ThreadArena&) = delete;
  // There what has to do with threads is left where it is.
  ~ThreadArena();
};

}  // namespace omma
