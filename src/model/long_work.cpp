// Long work on a thread of its own, its caller waiting and reporting meanwhile.
#include "model/long_work.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "omma/error.h"

namespace omma {

void WorkState::reach(double finished_share) {
  share = finished_share;
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
  bool has_ended = false;
  std::exception_ptr failure;
  std::thread worker([&] {
    try {
      work(state);
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    has_ended = true;
    ended.notify_one();
  });

  std::exception_ptr refusal;  // what `progress` threw
  std::unique_lock lock(mutex);
  while (!ended.wait_for(lock, std::chrono::milliseconds(100), [&] { return has_ended; })) {
    if (state.cancelled) continue;
    lock.unlock();
    try {
      if (!progress(state.share)) state.cancelled = true;
    } catch (...) {
      refusal = std::current_exception();
      state.cancelled = true;
    }
    lock.lock();
  }
  lock.unlock();
  worker.join();
  if (refusal) std::rethrow_exception(refusal);
  if (failure) std::rethrow_exception(failure);
  if (state.cancelled || !progress(1.0)) throw Cancelled();
}

}  // namespace omma
