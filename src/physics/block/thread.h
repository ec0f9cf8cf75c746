// What a thread of a graphics card does: one ommatidium of a task, in one lane, with the bits that
// its block has in packets.
#pragma once

#include "physics/block/block.h"

namespace omma {

using OneLane = Lanes<1, 1>;

// Bytes of memory that a thread needs.
OMMA_HD std::size_t thread_bytes(const FrameView& frame) {
  Scratch counting;
  counting.take<BlockMemory>(1);
  lay_out(counting, frame, 1);
  return counting.used;
}

// A thread's memory, at a multiple of 64 bytes: where all is lies there too, as its stack is small.
OMMA_HD_CALLED inline BlockMemory& lay_out_thread(std::byte* memory, const FrameView& frame) {
  Scratch scratch{memory};
  auto* const own = scratch.take<BlockMemory>(1);
  *own = lay_out(scratch, frame, 1);
  return *own;
}

// Ommatidium i of the task alone; rays of those before it come first in the block.
OMMA_HD ReplicateList list_of(const std::int32_t& ordinal, int i, int scrambles) {
  return {&ordinal, 0, scrambles, scrambles, i * scrambles};
}

template <typename Search>
OMMA_HD void render_ommatidium(const BlockRun<Search>& run, int i) {
  const std::int32_t ordinal = run.task.first + i;
  render_list<OneLane>(run, list_of(ordinal, i, run.frame.scrambles));
}

template <typename Search>
OMMA_HD void render_discs_of_ommatidium(const BlockRun<Search>& run, int i) {
  const std::int32_t ordinal = run.task.first + i;
  render_discs<OneLane>(run, list_of(ordinal, i, 1));
}

// The error of a block in the memory of one of its threads. `known`: lay_out_error.
OMMA_HD void share_error(const FrameView& frame, const ErrorMemory& known, int i,
                         BlockMemory& memory) {
  memory.error = known;
  memory.paths.cell_errors = cell_errors_of(frame, known.cell_errors, i);
}

template <typename Search>
OMMA_HD void end_error_of_ommatidium(const BlockRun<Search>& run, int i) {
  const std::int32_t ordinal = run.task.first + i;
  end_ommatidia<OneLane>(run, list_of(ordinal, i, 1), i);
}

}  // namespace omma
