// The rays of a packet through a search (block.h says what one is), by functions of their own: what
// a search has on the stack does not add up with what its callers have there.
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/views/path_memory.h"
#include "physics/views/ray_packet.h"

namespace omma {

template <typename L, typename Search>
OMMA_HD_CALLED void search_closest(Search& search, LaneMask<L> lanes, RayPacket<L::count>& rays,
                                   const PassedSurfaces* passed, Spread spread) {
  search.closest(lanes, rays, passed, spread);
}

template <typename L, typename Search>
OMMA_HD_CALLED LaneMask<L> search_occluded(Search& search, LaneMask<L> lanes,
                                           const RayPacket<L::count>& rays) {
  return search.occluded(lanes, rays);
}

}  // namespace omma
