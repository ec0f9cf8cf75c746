// Embree 3 and Embree 4 under one set of names. Only the Embree backend includes this.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "backend/embree/passed.h"

namespace omma {

// While it lives, this thread's denormal numbers count as zero, as Embree's manual asks: idle lanes
// of a packet may hold some, and each would cost a hundred cycles.
struct DenormalsAreZero {
#if defined(__SSE__)
  unsigned before = _mm_getcsr();
  DenormalsAreZero() {
    _mm_setcsr(before | 0x8040u);
  }  // flush to zero, denormals are zero
  ~DenormalsAreZero() {
    _mm_setcsr(before);
  }
#else
  DenormalsAreZero() = default;
#endif
  DenormalsAreZero(const DenormalsAreZero&) = delete;
  DenormalsAreZero& operator=(const DenormalsAreZero&) = delete;
};

// Rays of one ommatidium run close together, which is what coherent traversal is for. Filters find
// the context again, and in it what the rays have passed.
#if RTC_VERSION_MAJOR >= 4
struct QueryContext : RTCRayQueryContext {
  const PassedSurfaces* passed = nullptr;
};
struct IntersectArguments {
  QueryContext context;
  RTCIntersectArguments arguments;
  IntersectArguments() {
    rtcInitRayQueryContext(&context);
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    arguments.context = &context;
  }
  IntersectArguments(const IntersectArguments&) = delete;
  IntersectArguments& operator=(const IntersectArguments&) = delete;
};
__attribute__((always_inline)) inline void intersect_16(RTCScene scene, const int* valid,
                                                        RTCRayHit16& rays,
                                                        IntersectArguments& arguments) {
  rtcIntersect16(valid, scene, &rays, &arguments.arguments);
}
#else
struct QueryContext : RTCIntersectContext {
  const PassedSurfaces* passed = nullptr;
};
struct IntersectArguments {
  QueryContext context;
  IntersectArguments() {
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  }
};
__attribute__((always_inline)) inline void intersect_16(RTCScene scene, const int* valid,
                                                        RTCRayHit16& rays,
                                                        IntersectArguments& arguments) {
  rtcIntersect16(valid, scene, &arguments.context, &rays);
}
#endif

}  // namespace omma
