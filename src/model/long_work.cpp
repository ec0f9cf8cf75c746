// Long work on a thread of its own, its caller waiting and reporting meanwhile.
#include "model/long_work.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "omma/error.h"
#include "threads/parallel.h"

namespace omma {

void WorkState::reach(double finished) {
  // Threads and readers of several things do not report in order.
  double before = fraction;
  while (finished > before && !fraction.compare_exchange_weak(before, finished)) {
  }
  if (cancelled) throw Cancelled();
}

void run_watched(const Progress& progress, const std::function<void(WorkState&)>& work) {
  WorkState state;
  if (!progress) {
    work(state);
    return;
  }
  std::mutex mutex;
  std::condition_variable ended;
  bool has_ended = false, cancelled = false;
  std::exception_ptr failure;
  {
    // The worker is joined however this scope is left, also by an exception of `progress` or a
    // cancelled thread.
    struct Worker {
      WorkState& state;
      std::thread thread;
      ~Worker() {
        state.cancelled = true;
        thread.join();
      }
    };
    bool goes_on = true;
    const Worker worker{state, std::thread([&] {
                          try {
                            const TakingPart part(&state.cancelled);
                            work(state);
                          } catch (...) {
                            failure = std::current_exception();
                          }
                          const std::lock_guard lock(mutex);
                          has_ended = true;
                          ended.notify_one();
                        })};
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, std::chrono::milliseconds(100), [&] { return has_ended; })) {
      if (!goes_on) continue;
      lock.unlock();
      goes_on = progress(state.fraction);
      if (!goes_on) state.cancelled = true;
      lock.lock();
    }
    cancelled = !goes_on;
  }
  if (failure) std::rethrow_exception(failure);
  if (cancelled || !progress(1.0)) throw Cancelled();
}

}  // namespace omma
