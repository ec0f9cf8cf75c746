// One instruction set's functions of packet_search.h; OMMA_ISA names it. Calls nothing out of line.
#include "packet_search.h"

#include "physics/surface/scene_search.h"

namespace omma::OMMA_ISA {
namespace {

template <typename L>
SceneSearch<L> search_of(const PortableTracer& tracer) {
  static Visit<L::count> tree[stack_capacity(most_tree_depth)];
  static Visit<L::count> top[stack_capacity(most_top_depth)];
  return {tracer.scene_view, &tracer.view, {tree, top}};
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
    search_of<L>(tracer).closest(valid_lanes<L>(valid), rays[p], nullptr);
}

template <typename L>
unsigned occluded_of(const PortableTracer& tracer, const int* valid,
                     const RayPacket<L::count>& rays) {
  return search_of<L>(tracer).occluded(valid_lanes<L>(valid), rays).bits;
}

}  // namespace

SearchFunctions portable_search() {
  using Packets = Lanes<16, OMMA_LANE_WIDTH>;
  using OneLane = Lanes<1, 1>;
  return {closest_of<Packets>, closest_of<OneLane>, occluded_of<Packets>, occluded_of<OneLane>};
}

}  // namespace omma::OMMA_ISA
