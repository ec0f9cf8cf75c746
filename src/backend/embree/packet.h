// A packet of 16 rays on its way through the hot loop, and what vector loops need to read and write
// it. Included by block.cpp alone, once per instruction set: OMMA_ISA names the namespace.
#pragma once

#include <limits>

#include "backend/embree/block.h"
#include "kernel/lanes.h"

namespace omma::OMMA_ISA {
namespace {

constexpr int lanes = 16;

// What the lanes of one packet add to: consecutive lanes of one estimate.
struct Run {
  int unit;  // ommatidium in the block * scrambles + scramble
  int first, count;
  int sample;  // of the first lane
};

struct PacketLight {
  alignas(64) float channel[channel_count][lanes];
  alignas(64) float alpha[lanes];
};

struct Packet {
  RTCRayHit16 rays;
  PacketLight light;
  Run runs[lanes];
  int run_count = 0;
  int filled = 0;
};

template <typename Vector, typename T>
__attribute__((always_inline)) inline Vector load(const T* p) {
  Vector v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

template <typename Vector>
__attribute__((always_inline)) inline void store(float* p, Vector v) {
  __builtin_memcpy(p, &v, sizeof v);
}

void clear(Packet& packet) {
  for (int l = 0; l < lanes; ++l) {
    // A last packet may stay part empty: its idle lanes still go through the vector loops.
    packet.rays.ray.dir_x[l] = packet.rays.ray.dir_y[l] = packet.rays.ray.dir_z[l] = 0;
    packet.rays.ray.time[l] = 0;
    packet.rays.ray.mask[l] = 0xffffffffu;
    packet.rays.ray.id[l] = static_cast<unsigned>(l);
    packet.rays.ray.flags[l] = 0;
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
