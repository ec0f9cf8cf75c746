// Arithmetic of the hot loop: denormal numbers count as zero.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include <cstdint>

#include "omma/vec.h"

namespace omma {

// While it lives, this thread's denormal numbers count as zero, as Embree's manual asks: idle lanes
// of a packet may hold some, and each would cost a hundred cycles.
struct DenormalsAreZero {
#if defined(__SSE__)
  unsigned before = _mm_getcsr();
  OMMA_HD DenormalsAreZero() {
    _mm_setcsr(before | 0x8040u);
  }  // flush to zero, denormals are zero
  OMMA_HD ~DenormalsAreZero() {
    _mm_setcsr(before);
  }
#elif defined(__aarch64__)
  std::uint64_t before = 0;
  DenormalsAreZero() {
    asm volatile("mrs %0, fpcr" : "=r"(before));
    set(before | std::uint64_t{1} << 24);  // FZ: of arguments and results
  }
  ~DenormalsAreZero() {
    set(before);
  }
  static void set(std::uint64_t control) {
    asm volatile("msr fpcr, %0" : : "r"(control));
  }
#else
  DenormalsAreZero() {}
  ~DenormalsAreZero() {}  // so that one that lives is no unused variable
#endif
  DenormalsAreZero(const DenormalsAreZero&) = delete;
  DenormalsAreZero& operator=(const DenormalsAreZero&) = delete;
};

}  // namespace omma
