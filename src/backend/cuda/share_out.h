// A launch shared out among several cards, each asked by a host thread of its own.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <future>
#include <span>
#include <vector>

#include "backend/launches.h"
#include "threads/parallel.h"

namespace omma {

// Where a task writes to. Tasks that follow each other and have that in common, as those of a pose
// its responses, stay together: a card brings back all of the array.
inline const void* written_by(const BlockTask& task) {
  return task.responses;
}
inline const void* written_by(const WeighTask& task) {
  return task.responses;
}
inline const void* written_by(const GatherTask& task) {
  return task.mean;
}
inline const void* written_by(const RayPacket<packet_rays>& packet) {
  return &packet;
}

// So many pieces of about equal length; the last ones may be empty.
template <typename Task>
std::vector<std::span<Task>> cut_between_poses(std::span<Task> tasks, std::size_t pieces) {
  std::vector<std::span<Task>> cut;
  std::size_t begin = 0;
  for (std::size_t k = 1; k <= pieces; ++k) {
    std::size_t end = std::max(begin, (tasks.size() * k + pieces - 1) / pieces);
    while (end > begin && end < tasks.size() &&
           written_by(tasks[end - 1]) == written_by(tasks[end]))
      ++end;
    cut.push_back(tasks.subspan(begin, end - begin));
    begin = end;
  }
  return cut;
}

// run(card, piece of the tasks) for each card; by this thread alone where one has all of them. What
// is thrown is thrown when all have ended, that of the first of the cards.
template <typename Task, typename Run>
void share_out(std::span<const int> cards, std::span<Task> tasks, const Run& run) {
  if (cards.size() == 1) return run(cards.front(), tasks);
  const std::vector<std::span<Task>> pieces = cut_between_poses(tasks, cards.size());
  std::vector<std::exception_ptr> errors(cards.size());
  const std::atomic<bool>* const flag = cancel_flag();
  const auto run_piece = [&](std::size_t k) {
    const TakingPart part(flag);
    try {
      run(cards[k], pieces[k]);
    } catch (...) {
      errors[k] = std::current_exception();
    }
  };
  {
    std::vector<std::future<void>> others;  // the destructor of each waits for its end
    for (std::size_t k = 1; k < cards.size(); ++k)
      if (!pieces[k].empty()) others.push_back(std::async(std::launch::async, run_piece, k));
    run_piece(0);
  }
  for (const std::exception_ptr& error : errors)
    if (error != nullptr) std::rethrow_exception(error);
}

}  // namespace omma
