// Long work that whoever called for it can watch and end: reading a scene, building what traces it.
#pragma once

#include <atomic>
#include <functional>

namespace omma {

// Told of the finished fraction (0 to 1) on the thread that asked for the work; false ends it.
using Progress = std::function<bool(double)>;

// How far the work is. Any thread of it may use this.
struct WorkState {
  std::atomic<double> fraction{0};
  std::atomic<bool> cancelled{false};

  // Notes the fraction, which never falls; throws omma::Cancelled where the work is to end.
  void reach(double finished);
};

// The part of the work between two fractions of it.
struct WorkPart {
  WorkState* state = nullptr;  // null: nobody watches
  double from = 0, to = 1;

  // Notes how much of the part is finished (0 to 1); throws omma::Cancelled.
  void reach(double finished) const {
    if (state != nullptr) state->reach(from + (to - from) * finished);
  }
  WorkPart part(double part_from, double part_to) const {
    return {state, from + (to - from) * part_from, from + (to - from) * part_to};
  }
};

// Runs `work`. With a progress function it runs on a thread of its own, because Embree and parallel
// loops report from any thread, while `progress` must hear of it on this one, several times a
// second and once at the end. Throws what either throws, and omma::Cancelled where `progress`
// returned false; the thread has ended then.
void run_watched(const Progress& progress, const std::function<void(WorkState&)>& work);

}  // namespace omma
