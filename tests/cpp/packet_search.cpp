// One instruction set's functions of packet_search.h; OMMA_ISA names it. Calls nothing out of line.
#include "packet_search.h"

#include "physics/search/traverse.h"
#include "physics/surface/surface.h"

namespace omma::OMMA_ISA {
namespace {

auto accept_of(const PortableTracer& tracer) {
  return [scene = tracer.scene_view, placed = tracer.layout.placed.data()](
             int, float, float u, float v, std::uint32_t triangle, std::uint32_t index,
             bool from_behind) {
    return accept_hit(*scene, {placed[index].mesh, triangle, u, v, 0}, from_behind);
  };
}

template <typename L>
LaneMask<L> valid_lanes(const int* valid) {
  LaneMask<L> lanes;
  for (int l = 0; l < L::count; ++l)
    if (valid[l] != 0) lanes.add(l);
  return lanes;
}

template <typename L>
void closest_of(const PortableTracer& tracer, const int* valid, RayPacket<L::count>* rays,
                std::size_t packets) {
  for (std::size_t p = 0; p < packets; ++p)
    closest<L>(tracer.view, valid_lanes<L>(valid), rays[p], accept_of(tracer));
}

template <typename L>
unsigned occluded_of(const PortableTracer& tracer, const int* valid,
                     const RayPacket<L::count>& rays) {
  return occluded<L>(tracer.view, valid_lanes<L>(valid), rays, accept_of(tracer)).bits;
}

}  // namespace

SearchFunctions portable_search() {
  using Packets = Lanes<16, OMMA_LANE_WIDTH>;
  using OneLane = Lanes<1, 1>;
  return {closest_of<Packets>, closest_of<OneLane>, occluded_of<Packets>, occluded_of<OneLane>};
}

}  // namespace omma::OMMA_ISA
