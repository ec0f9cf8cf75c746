// The search of physics/surface/scene_search.h as tests and benchmarks call it: built from
// packet_search.cpp once per instruction set.
#pragma once

#include "backend/portable/portable_tracer.h"
#include "physics/views/ray_packet.h"

namespace omma {

struct SearchFunctions {
  // Closest hits that accept_hit accepts, of `packets` packets.
  void (*closest_16)(const PortableTracer&, const int* valid, RayPacket<16>*, std::size_t packets);
  void (*closest_1)(const PortableTracer&, const int* valid, RayPacket<1>*, std::size_t packets);
  unsigned (*occluded_16)(const PortableTracer&, const int* valid, const RayPacket<16>&);
  unsigned (*occluded_1)(const PortableTracer&, const int* valid, const RayPacket<1>&);
};

// Those that this processor runs, the fastest last.
std::vector<SearchFunctions> portable_searches();

namespace baseline {
SearchFunctions portable_search();
}
namespace plain {
SearchFunctions portable_search();
}
namespace avx2 {
SearchFunctions portable_search();
}
namespace avx512 {
SearchFunctions portable_search();
}

}  // namespace omma
