// A packet of 16 rays on its way through the hot loop, and what vector loops need to read and write
// it. Included by block.cpp alone, once per instruction set: OMMA_ISA names the namespace.
#pragma once

#include <limits>

#include "backend/embree/block.h"
#include "physics/lanes.h"

namespace omma::OMMA_ISA {
namespace {

constexpr int lanes = 16;

struct PacketLight {
  alignas(64) float channel[channel_count][lanes];
  alignas(64) float alpha[lanes];
};

struct Packet {
  RTCRayHit16 rays;
  alignas(64) float footprint_rad[lanes];  // width of each ray (physics/footprint.h)
  PacketLight light;
};

template <typename Vector, typename T>
__attribute__((always_inline)) inline Vector load(const T* p) {
  Vector v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

template <typename Vector, typename T>
__attribute__((always_inline)) inline void store(T* p, Vector v) {
  __builtin_memcpy(p, &v, sizeof v);
}

// Lane l of the result is p[index[l]], 0 <= index[l] < lane_width.
__attribute__((always_inline)) inline Floats pick(const float* p, Ints index) {
#if defined(__AVX512F__)
  return (Floats)_mm512_maskz_permutexvar_ps(0xffff, (__m512i)index, (__m512)load<Floats>(p));
#elif defined(__AVX2__)
  return (Floats)_mm256_permutevar8x32_ps((__m256)load<Floats>(p), (__m256i)index);
#else
  return gather(p, index);
#endif
}

__attribute__((always_inline)) inline Ints lane_numbers() {
  Ints number;
  for (int l = 0; l < lane_width; ++l) number[l] = l;
  return number;
}

// What is the same for all rays.
void clear(Packet& packet) {
  for (int l = 0; l < lanes; ++l) {
    packet.rays.ray.time[l] = 0;
    packet.rays.ray.mask[l] = 0xffffffffu;
    packet.rays.ray.flags[l] = 0;
    packet.rays.ray.id[l] = static_cast<unsigned>(l);  // filters are asked in any order
  }
}

void prepare(RTCRayHit16& rays) {
  for (int l = 0; l < lanes; ++l) {
    rays.ray.tfar[l] = std::numeric_limits<float>::infinity();
    rays.hit.geomID[l] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][l] = RTC_INVALID_GEOMETRY_ID;
  }
}

}  // namespace
}  // namespace omma::OMMA_ISA
