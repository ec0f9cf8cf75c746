// A thread's memory.
#include "threads/thread_memory.h"

#include <memory>
#include <new>

namespace omma {
namespace {

constexpr std::align_val_t alignment{64};

struct Free {
  void operator()(std::byte* memory) const {
    ::operator delete(memory, alignment);
  }
};

struct Kept {
  std::unique_ptr<std::byte, Free> memory;
  std::size_t size = 0;
};

}  // namespace

std::byte* thread_memory(std::size_t bytes) {
  thread_local Kept kept;
  auto& [memory, size] = kept;
  if (size < bytes || size / 4 > bytes) {
    memory.reset();
    size = 0;
    memory.reset(static_cast<std::byte*>(::operator new(bytes, alignment)));
    size = bytes;
  }
  return memory.get();
}

}  // namespace omma
