// Arithmetic of the hot loop: denormal numbers count as zero.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

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
#else
  DenormalsAreZero() = default;
#endif
  DenormalsAreZero(const DenormalsAreZero&) = delete;
  DenormalsAreZero& operator=(const DenormalsAreZero&) = delete;
};

}  // namespace omma
