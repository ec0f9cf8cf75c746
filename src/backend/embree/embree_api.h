// Embree 3 and Embree 4 under one set of names. Only the Embree backend includes this.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cstddef>

#include "physics/rays/passed.h"

namespace omma {

// A packet of ours is laid out as one of Embree's, which may be longer by what newer versions write.
OMMA_HD RTCRayHit16& rays_of(RayPacket<16>& packet) {
  using Packet = RayPacket<16>;
  static_assert(sizeof(RTCRayHit16) <= sizeof(Packet) && alignof(Packet) == alignof(RTCRayHit16));
  static_assert(offsetof(RTCRayHit16, ray.org_x) == offsetof(Packet, origin));
  static_assert(offsetof(RTCRayHit16, ray.tnear) == offsetof(Packet, t_near_m));
  static_assert(offsetof(RTCRayHit16, ray.dir_x) == offsetof(Packet, direction));
  static_assert(offsetof(RTCRayHit16, ray.time) == offsetof(Packet, time));
  static_assert(offsetof(RTCRayHit16, ray.tfar) == offsetof(Packet, t_far_m));
  static_assert(offsetof(RTCRayHit16, ray.mask) == offsetof(Packet, mask));
  static_assert(offsetof(RTCRayHit16, ray.id) == offsetof(Packet, id));
  static_assert(offsetof(RTCRayHit16, ray.flags) == offsetof(Packet, flags));
  static_assert(offsetof(RTCRayHit16, hit.Ng_x) == offsetof(Packet, normal));
  static_assert(offsetof(RTCRayHit16, hit.u) == offsetof(Packet, u));
  static_assert(offsetof(RTCRayHit16, hit.v) == offsetof(Packet, v));
  static_assert(offsetof(RTCRayHit16, hit.primID) == offsetof(Packet, triangle));
  static_assert(offsetof(RTCRayHit16, hit.geomID) == offsetof(Packet, geometry));
  static_assert(offsetof(RTCRayHit16, hit.instID) == offsetof(Packet, instance));
  return reinterpret_cast<RTCRayHit16&>(packet);
}

// Rays of one ommatidium are coherent; for scattered rays Embree's coherent mode is far slower. The
// context takes the surfaces that rays have passed to the filters.
#if RTC_VERSION_MAJOR >= 4
struct QueryContext : RTCRayQueryContext {
  const PassedSurfaces* passed = nullptr;
};
struct IntersectArguments {
  QueryContext context;
  RTCIntersectArguments arguments;
  OMMA_HD IntersectArguments() {
    rtcInitRayQueryContext(&context);
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    expect(Spread::together);
  }
  OMMA_HD void expect(Spread spread) {
    arguments.flags = spread == Spread::together ? RTC_RAY_QUERY_FLAG_COHERENT
                                                 : RTC_RAY_QUERY_FLAG_INCOHERENT;
  }
  IntersectArguments(const IntersectArguments&) = delete;
  IntersectArguments& operator=(const IntersectArguments&) = delete;
};
OMMA_HD void intersect_16(RTCScene scene, const int* valid,
                                                        RTCRayHit16& rays,
                                                        IntersectArguments& arguments) {
  rtcIntersect16(valid, scene, &rays, &arguments.arguments);
}
OMMA_HD void occluded_16(RTCScene scene, const int* valid, RTCRay16& rays,
                         IntersectArguments& arguments) {
  RTCOccludedArguments occluded;
  rtcInitOccludedArguments(&occluded);
  occluded.flags = arguments.arguments.flags;
  occluded.context = &arguments.context;
  rtcOccluded16(valid, scene, &rays, &occluded);
}
#else
struct QueryContext : RTCIntersectContext {
  const PassedSurfaces* passed = nullptr;
};
struct IntersectArguments {
  QueryContext context;
  OMMA_HD IntersectArguments() {
    rtcInitIntersectContext(&context);
    expect(Spread::together);
  }
  OMMA_HD void expect(Spread spread) {
    context.flags = spread == Spread::together ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                               : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  }
};
OMMA_HD void intersect_16(RTCScene scene, const int* valid,
                                                        RTCRayHit16& rays,
                                                        IntersectArguments& arguments) {
  rtcIntersect16(valid, scene, &arguments.context, &rays);
}
OMMA_HD void occluded_16(RTCScene scene, const int* valid, RTCRay16& rays,
                         IntersectArguments& arguments) {
  rtcOccluded16(valid, scene, &arguments.context, &rays);
}
#endif

}  // namespace omma
