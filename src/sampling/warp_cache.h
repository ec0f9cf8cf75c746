// Warps that renderers of one lineage have made (Renderer(same_world, eye)), so that an eye whose
// acceptances change before each frame makes each width's once.
#pragma once

#include <array>
#include <cstddef>

#include "optics/acceptance_hash.h"
#include "optics/acceptance_warp.h"
#include "threads/made_once.h"

namespace omma {

// A hash table with linear probing from which nothing is ever taken. No lock, as a forked process may
// call.
class WarpCache {
 public:
  AcceptanceWarp get(const Acceptance& acceptance) {
    const auto make = [&] { return make_acceptance_warp(acceptance); };
    // A map's warp is 4 MB.
    if (acceptance.table != nullptr) return make();
    const std::size_t first = AcceptanceHash{}(acceptance);
    for (std::size_t k = 0; k < probes; ++k) {
      const AcceptanceWarp& kept = slots_[(first + k) % slots].get(make);
      if (kept.acceptance == acceptance) return kept;
    }
    return make();
  }

 private:
  static constexpr std::size_t slots = 1024;  // of 32 kB at most each
  static constexpr std::size_t probes = 8;
  std::array<MadeOnce<AcceptanceWarp>, slots> slots_;
};

}  // namespace omma
