// What a graphics card would run, run by a processor: each launch a grid of threads, each of which
// has a stack and memory of its own. All that it reads and writes is behind the pointers of a
// launch, in the emulated card's memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "backend/cuda/card.h"

namespace omma::test {

// A card's memory is shared with the process that runs its threads, at the same address in both,
// far from what systems map by themselves, each card's elsewhere. Of it what is touched is had.
inline constexpr std::size_t device_bytes = std::size_t{1} << 34;
constexpr std::uintptr_t device_address(int ordinal) {
  return 0x6000'0000'0000 + static_cast<std::uintptr_t>(ordinal) * device_bytes;
}

struct DeviceCall {
  CardKernel kernel;
  int blocks;
  GridLaunch launch;
};

// The most that a thread had of a launch in one lane, bytes.
struct DeviceUse {
  std::size_t stack = 0, memory = 0;
};

DeviceUse run_on_device(const DeviceCall& call);

}  // namespace omma::test
