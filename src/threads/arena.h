// Threads of renderers: oneTBB starts no more than the process allows, and says so on stderr where
// an arena asks for more.
#pragma once

#include <oneapi/tbb/task_arena.h>

#include <memory>

namespace omma {

// An arena of `threads` threads, or as many as oneTBB allows: 257 on most machines, and fewer where
// something else in the process has set a limit. The machine may have fewer.
std::unique_ptr<oneapi::tbb::task_arena> make_thread_arena(int threads);

}  // namespace omma
