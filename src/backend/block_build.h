// The hot loop with one backend's search, for the instruction set that the including file is built
// for: OMMA_ISA names the namespace, OMMA_LANE_WIDTH how many lanes go at once.
#pragma once

#include "backend/block_functions.h"
#include "backend/denormals.h"
#include "physics/block/block.h"
#include "physics/path/gather.h"
#include "threads/cancel.h"

namespace omma::OMMA_ISA {

using Packets = Lanes<packet_rays, OMMA_LANE_WIDTH>;

// A search that ends where its work is cancelled: a block to an error, or of many rays, may take
// minutes.
template <typename Search>
struct CancellableSearch {
  static constexpr unsigned packets_between = 256;  // some milliseconds
  Search search;
  unsigned packets = 0;

  void closest(LaneMask<Packets> lanes, RayPacket<packet_rays>& rays, const PassedSurfaces* passed,
               Spread spread) {
    if (++packets % packets_between == 0) check_cancelled();
    search.closest(lanes, rays, passed, spread);
  }
  LaneMask<Packets> occluded(LaneMask<Packets> lanes, const RayPacket<packet_rays>& rays) {
    return search.occluded(lanes, rays);
  }
  const PlacedMesh* placed() const { return search.placed(); }
  Visits<packet_rays> visits_of_trees() const { return search.visits_of_trees(); }
};

// `MakeSearch`: a lambda without captures that makes a search of what the backend built.
template <typename MakeSearch>
BlockFunctions build_block(MakeSearch) {
  using Search = decltype(MakeSearch{}(nullptr));
  BlockFunctions block;
  block.render = [](const FrameView& frame, const BlockTask& task, const void* tracer,
                    std::byte* memory) {
    const DenormalsAreZero denormals_are_zero;
    CancellableSearch<Search> search{MakeSearch{}(tracer)};
    Scratch scratch{memory};
    const BlockMemory laid_out = lay_out(scratch, frame, packet_rays);
    render_block<Packets>(BlockRun<CancellableSearch<Search>>{frame, task, search, laid_out});
  };
  block.discs = [](const FrameView& frame, const BlockTask& task, const void* tracer,
                   std::byte* memory) {
    const DenormalsAreZero denormals_are_zero;
    CancellableSearch<Search> search{MakeSearch{}(tracer)};
    Scratch scratch{memory};
    const BlockMemory laid_out = lay_out(scratch, frame, packet_rays);
    render_discs<Packets>(BlockRun<CancellableSearch<Search>>{frame, task, search, laid_out},
                          all_of(task, 1));
  };
  block.weigh = [](const SharedWeights& shared, const float* radiance, int outputs,
                   std::int64_t first, std::int64_t end, float* responses) {
    const DenormalsAreZero denormals_are_zero;
    weigh_rays<Packets>(shared, radiance, outputs, first, end, responses);
  };
  block.gather = [](const FrameView& frame, const GatherTask& task, const void* tracer,
                    std::byte* memory) {
    const DenormalsAreZero denormals_are_zero;
    CancellableSearch<Search> search{MakeSearch{}(tracer)};
    Scratch scratch{memory};
    const BlockMemory laid_out = lay_out(scratch, frame, packet_rays);
    gather_light<Packets>(*frame.scene, search, task, laid_out.paths, laid_out.radiance);
  };
  block.prepare = [](const FrameView& frame, const BlockTask& task,
                     RayPacket<packet_rays>* packets) {
    prepare_block<Packets>(frame, task, packets);
  };
  block.closest = [](const void* tracer, unsigned lanes, RayPacket<packet_rays>& rays) {
    const DenormalsAreZero denormals_are_zero;
    Search search = MakeSearch{}(tracer);
    for (int l = 0; l < packet_rays; ++l) rays.geometry[l] = rays.instance[l] = none;
    search.closest(LaneMask<Packets>{lanes}, rays, nullptr, Spread::together);
  };
  return block;
}

}  // namespace omma::OMMA_ISA
