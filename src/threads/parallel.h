// Parallel loops that can be ended from outside, and that a forked process goes through alone. All
// of the engine's loops run through these, so that long work ends soon after it was cancelled and
// results never depend on who helped.
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <atomic>
#include <cstddef>

#include "omma/error.h"
#include "threads/cancel.h"

namespace omma {

// Of work that may be cancelled, on each thread that takes part in it; null where nobody can.
const std::atomic<bool>* cancel_flag();

// While this lives its thread takes part in work that `flag` cancels.
class TakingPart {
 public:
  explicit TakingPart(const std::atomic<bool>* flag);
  TakingPart(const TakingPart&) = delete;
  TakingPart& operator=(const TakingPart&) = delete;
  ~TakingPart();

 private:
  const std::atomic<bool>* before_;
};

// True in a process that was forked from one which had used its threads. A fork takes along the
// calling thread only: TBB and Embree still count on the others there, and on locks that those may
// have held. All loops are then run by the thread that calls.
bool threads_are_gone();

// To be called before threads are used in any way that does not go through here.
void note_threads_are_used();

// body(range) for ranges that together are begin to end, none longer than need be nor, where that
// can be, shorter than `grain`. Throws omma::Cancelled, and what `body` throws. Where a loop that
// this one is a part of fails on another thread, oneTBB ends this one without a word: it throws
// Cancelled then, as not all is done.
template <typename Index, typename Body>
void parallel_ranges(Index begin, Index end, Index grain, const Body& body) {
  using Range = oneapi::tbb::blocked_range<Index>;
  const std::atomic<bool>* const flag = cancel_flag();
  const auto run = [&](const Range& range) {
    const TakingPart part(flag);
    check_cancelled();
    body(range.begin(), range.end());
  };
  if (!threads_are_gone()) {
    note_threads_are_used();
    oneapi::tbb::task_group_context context;
    oneapi::tbb::parallel_for(Range(begin, end, static_cast<std::size_t>(grain)), run, context);
    if (context.is_group_execution_cancelled()) throw Cancelled();
    return;
  }
  while (begin < end) {
    const Index next = end - begin > grain ? begin + grain : end;
    run(Range(begin, next));
    begin = next;
  }
}

// body(i) for i from begin to end.
template <typename Index, typename Body>
void parallel_for(Index begin, Index end, const Body& body) {
  parallel_ranges(begin, end, Index{1}, [&](Index first, Index last) {
    for (Index i = first; i < last; ++i) {
      check_cancelled();
      body(i);
    }
  });
}

// Runs work() with the threads of `arena`.
template <typename Work>
void run_in_arena(oneapi::tbb::task_arena& arena, const Work& work) {
  if (threads_are_gone()) return work();
  note_threads_are_used();
  // Where the arena is full, another thread runs it.
  const std::atomic<bool>* const flag = cancel_flag();
  arena.execute([&] {
    const TakingPart part(flag);
    work();
  });
}

// Runs work() so that its thread, where it waits for others in a loop, takes up no task of any
// other loop.
template <typename Work>
void run_isolated(const Work& work) {
  if (threads_are_gone()) return work();
  note_threads_are_used();
  oneapi::tbb::this_task_arena::isolate(work);
}

}  // namespace omma
