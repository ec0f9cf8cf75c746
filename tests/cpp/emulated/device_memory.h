// The emulated card's memory, as the host sees it: shared with the process that runs the card's
// threads, at the same address in both. Nothing else of the host is there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <tuple>
#include <vector>

#include "physics/views/version.h"

namespace omma::test {

// Where the memory is mapped; far from what systems map by themselves.
inline constexpr std::uintptr_t device_address = 0x6000'0000'0000;
inline constexpr std::size_t device_bytes = std::size_t{1}
                                            << 34;  // of which what is touched is had

// A part of the memory, filled from its beginning on.
struct DevicePart {
  std::uintptr_t begin;
  std::size_t size, used = 0;  // bytes

  void* copy(const void* from, std::size_t bytes);
};

// Copies that stay from launch to launch, by where the arrays are and their version: a launch
// copies only what has changed. What has, and has kept its version, is an error.
class KeptCopies {
 public:
  const void* read(const void* array, std::size_t bytes, Version version);
  // Before a launch: all is forgotten when half of the memory is full.
  void make_room();
  std::size_t copied = 0;  // bytes since this was set

 private:
  DevicePart part_{device_address, device_bytes / 2};
  std::map<std::tuple<const void*, std::size_t, Version>, const void*> kept_;
};

// Copies of arrays for one launch, for ArrayCopies.
class DeviceCopies {
 public:
  explicit DeviceCopies(KeptCopies& kept) : kept_(kept) { kept.make_room(); }

  template <typename T>
  const T* read(const T* array, std::size_t count, Version version) {
    const std::size_t bytes = count * sizeof(T);
    return static_cast<const T*>(version != 0 ? kept_.read(array, bytes, version)
                                              : part_.copy(array, bytes));
  }
  template <typename T>
  T* written(T* array, std::size_t count) {
    void* const place = part_.copy(array, count * sizeof(T));
    outputs_.push_back({array, place, count * sizeof(T)});
    return static_cast<T*>(place);
  }
  // What was written goes to where it was asked for.
  void bring_back() const {
    for (const Output& output : outputs_) std::memcpy(output.host, output.place, output.bytes);
  }

 private:
  struct Output {
    void* host;
    const void* place;
    std::size_t bytes;
  };

  KeptCopies& kept_;
  DevicePart part_{device_address + device_bytes / 2, device_bytes / 2};
  std::vector<Output> outputs_;
};

}  // namespace omma::test
