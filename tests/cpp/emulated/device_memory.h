// The emulated card's memory, as the host sees it: shared with the process that runs the card's
// threads, at the same address in both. Nothing else of the host is there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace omma::test {

// Where the memory is mapped; far from what systems map by themselves.
inline constexpr std::uintptr_t device_address = 0x6000'0000'0000;
inline constexpr std::size_t device_bytes = std::size_t{1}
                                            << 34;  // of which what is touched is had

// Copies of arrays, for ArrayCopies: one behind the other from the beginning of the memory on.
class DeviceCopies {
 public:
  template <typename T>
  const T* read(const T* array, std::size_t count) {
    return static_cast<const T*>(copy(array, count * sizeof(T)));
  }
  template <typename T>
  T* written(T* array, std::size_t count) {
    void* const place = copy(array, count * sizeof(T));
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

  void* copy(const void* from, std::size_t bytes);

  std::size_t used_ = 0;
  std::vector<Output> outputs_;
};

}  // namespace omma::test
