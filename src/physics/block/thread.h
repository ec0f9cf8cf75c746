// What a thread of a graphics card does: one ommatidium of a task, in one lane, with the bits that
// its block has in packets. A launch is a grid of tasks times most_per_block threads.
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

// Rendering to an error is a launch for each round, between which one thread for each block does
// begin_error and choose_rounds. `memory`: of this thread; `known`: of its block, lay_out_error.
OMMA_HD void share_error(const FrameView& frame, const ErrorMemory& known, int i,
                         BlockMemory& memory) {
  memory.error = known;
  memory.paths.cell_errors = cell_errors_of(frame, known.cell_errors, i);
}

// The thread's memory shares its block's error.
template <typename Search>
OMMA_HD void trace_round_of_ommatidium(const BlockRun<Search>& run, const Round& round, int i) {
  if (run.memory.error.next[i] == round.directions) trace_members<OneLane>(run, round, &i, 1);
}

template <typename Search>
OMMA_HD void end_error_of_ommatidium(const BlockRun<Search>& run, int i) {
  const std::int32_t ordinal = run.task.first + i;
  end_ommatidia<OneLane>(run, list_of(ordinal, i, 1), i);
}

}  // namespace omma
