// Who takes part in which work, and whether there are threads.
#include "threads/parallel.h"

#include "omma/error.h"
#include "system/process.h"

namespace omma {
namespace {

thread_local const std::atomic<bool>* flag_of_this_thread = nullptr;

std::atomic<bool> used = false, gone = false;

// Run in the child of a fork.
void lose_threads() {
  if (used) gone = true;
}

// Once, when the library is loaded: before any fork that matters, and after oneTBB, whose
// destructor waits for locks that threads of the process before the fork may have held.
[[maybe_unused]] const bool registered =
    system::at_fork_in_child(lose_threads) && system::end_early_at_exit(threads_are_gone);

}  // namespace

const std::atomic<bool>* cancel_flag() {
  return flag_of_this_thread;
}

void check_cancelled() {
  if (flag_of_this_thread != nullptr && *flag_of_this_thread) throw Cancelled();
}

TakingPart::TakingPart(const std::atomic<bool>* flag) : before_(flag_of_this_thread) {
  flag_of_this_thread = flag;
}

TakingPart::~TakingPart() {
  flag_of_this_thread = before_;
}

bool threads_are_gone() {
  return gone.load(std::memory_order_relaxed);
}

void note_threads_are_used() {
  if (!used.load(std::memory_order_relaxed)) used = true;
}

}  // namespace omma
