// Embree 3 and Embree 4 under one set of names. Only the Embree backend includes this.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace omma {

// Rays of one ommatidium run close together, which is what coherent traversal is for.
#if RTC_VERSION_MAJOR >= 4
struct IntersectArguments {
  RTCIntersectArguments arguments;
  IntersectArguments() {
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  }
};
__attribute__((always_inline)) inline void intersect_16(RTCScene scene, const int* valid,
                                                        RTCRayHit16& rays,
                                                        IntersectArguments& arguments) {
  rtcIntersect16(valid, scene, &rays, &arguments.arguments);
}
#else
struct IntersectArguments {
  RTCIntersectContext context;
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
