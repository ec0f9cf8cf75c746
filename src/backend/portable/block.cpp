// The hot loop with our own search. This file is compiled once per instruction set (OMMA_ISA names
// the namespace, OMMA_LANE_WIDTH how many lanes go at once).
#include "backend/portable/builds.h"
#include "backend/portable/search.h"

namespace omma::OMMA_ISA {
namespace {

using Packets = Lanes<packet_rays, OMMA_LANE_WIDTH>;

void render(const FrameView& frame, const BlockTask& task, const void* tracer, std::byte* memory) {
  const DenormalsAreZero denormals_are_zero;
  PortableSearch<Packets> search{static_cast<const PortableTracer*>(tracer)};
  Room room{memory};
  render_block<Packets>(frame, task, search,
                        lay_out(room, frame.scene->bands, frame, packet_rays));
}

void weigh(const SharedWeights& shared, const float* radiance, int outputs, std::int64_t first,
           std::int64_t end, float* responses) {
  const DenormalsAreZero denormals_are_zero;
  weigh_rays<Packets>(shared, radiance, outputs, first, end, responses);
}

void prepare(const FrameView& frame, const BlockTask& task, RayPacket<packet_rays>* packets) {
  prepare_block<Packets>(frame, task, packets);
}

}  // namespace

BlockFunctions portable_block() {
  return {render, weigh, prepare};
}

}  // namespace omma::OMMA_ISA
