// One block of neighbouring ommatidia at one pose, from directions to responses:
// trace_replicates.h, the hot loop, then means and standard errors. A backend runs it with a search
// of its own, which has three members (surface/scene_search.h is the one of our own hierarchy):
//
//   closest(lanes, rays, passed, spread)
//     the closest accepted hits (surface.h) of a RayPacket, between t_near_m and t_far_m, of the
//     lanes that are on (LaneMask); where `passed` is not null, surfaces that a ray has passed
//     (passed.h) do not count; `spread`: how the rays lie to each other
//   occluded(lanes, rays)
//     those of the lanes whose ray meets any accepted surface there; shadow rays ask no more
//   placed()
//     the table of placed meshes that hits point into
//
// Nothing is allocated, nothing is called out of line that other instruction sets share.
#pragma once

#include "physics/block/estimate.h"
#include "physics/block/truth_sums.h"
#include "physics/sampling/mean_of_estimates.h"

namespace omma {

// Responses from the sums of a block: the mean over all scrambles.
OMMA_HD void reduce(const FrameView& frame, const BlockTask& task, const double* sums) {
  const int scrambles = frame.scrambles;
  const double weight =
      frame.radiance_unit / (static_cast<double>(frame.directions->samples) * scrambles);
  const std::int32_t* ommatidium = frame.eye->ommatidium + task.first;
  for (int o = 0; o < frame.outputs; ++o, sums += padded_capacity) {
    float means[block_capacity];
    for (int i = 0; i < task.count; ++i) {
      double sum = sums[i * scrambles];
      for (int r = 1; r < scrambles; ++r) sum += sums[i * scrambles + r];
      means[i] = static_cast<float>(sum * weight);
    }
    for (int i = 0; i < task.count; ++i)
      task.responses[std::int64_t{ommatidium[i]} * frame.outputs + o] = means[i];
  }
}

// Standard errors of the responses, from the spread of the scrambles and from what cells of baked
// light err by, which all scrambles see alike.
OMMA_HD void reduce_errors(const FrameView& frame, const BlockTask& task,
                           const BlockMemory& memory) {
  const double* const sums = memory.sums;
  const double samples = frame.directions->samples;
  const int scrambles = frame.scrambles;
  for (int i = 0; i < task.count; ++i) {
    const auto ommatidium = static_cast<std::int64_t>(frame.eye->ommatidium[task.first + i]);
    for (int o = 0; o < frame.outputs; ++o) {
      const double* estimates = sums + o * padded_capacity + i * scrambles;
      const double squares =
          mean_of_estimates(scrambles, [&](int r) { return estimates[r] / samples; }).squares;
      const double of_cells = cell_variance(frame, memory, i, o, samples * scrambles);
      task.standard_error[ommatidium * frame.outputs + o] = static_cast<float>(
          sqrt(squares / (scrambles * (scrambles - 1.0)) + of_cells) * frame.radiance_unit);
    }
  }
}

// Adds to the sums over the rays of each replicate what it sees of discs of the sky, and where it
// aims, besides.
template <typename L, typename Search>
OMMA_HD void add_beside_rays(const FrameView& frame, const BlockTask& task,
                             const ReplicateList& replicates, Search& search,
                             const BlockMemory& memory) {
  if (!sees_beside_rays(frame)) return;
  eval_beside_rays<L>(frame, task, replicates, search, memory);
  const int samples = frame.directions->samples;
  for (int o = 0; o < frame.outputs; ++o)
    for (int u = 0; u < replicates.count; ++u) {
      const double seen = memory.beside[o * padded_capacity + u];
      memory.sums[o * padded_capacity + u] += samples * seen;
      if (task.ray_radiance == nullptr || seen == 0) continue;
      const auto ommatidium = static_cast<std::int64_t>(frame.eye->ommatidium[task.first + u]);
      for (int k = 0; k < samples; ++k)
        task.ray_radiance[(ommatidium * samples + k) * frame.outputs + o] +=
            static_cast<float>(seen * frame.radiance_unit);
    }
}

// Adds to responses what ommatidia see of discs of the sky; their rays have left it out.
template <typename L, typename Search>
OMMA_HD void render_discs(const FrameView& frame, const BlockTask& task, Search& search,
                          const BlockMemory& memory) {
  const ReplicateList all{nullptr, 0, 1, task.count};
  eval_beside_rays<L>(frame, task, all, search, memory);
  for (int o = 0; o < frame.outputs; ++o)
    for (int i = 0; i < task.count; ++i)
      task.responses[std::int64_t{frame.eye->ommatidium[task.first + i]} * frame.outputs + o] +=
          static_cast<float>(memory.beside[o * padded_capacity + i] * frame.radiance_unit);
}

// `memory`: of this thread, lay_out for this frame.
template <typename L, typename Search>
OMMA_HD void render_block(const FrameView& frame, const BlockTask& task, Search& search,
                          const BlockMemory& memory) {
  const BlockRun<Search> run{frame, task, search, memory};
  if (frame.most_samples > 0) return render_to_error<L>(run);
  const ReplicateList all{nullptr, 0, frame.scrambles, task.count * frame.scrambles};
  clear(memory.sums, frame.outputs, all.count);
  clear_cell_errors(frame, task, memory);
  if (frame.truth != nullptr) clear(*frame.truth, memory.truth_sums, all.count);
  trace_replicates<L>(run, *frame.directions, all, {memory.sums, nullptr, memory.truth_sums});
  add_beside_rays<L>(frame, task, all, search, memory);
  reduce(frame, task, memory.sums);
  for (int i = 0; frame.truth != nullptr && i < task.count; ++i)
    reduce_truth(frame, task, memory.truth_sums, i, frame.scrambles,
                 frame.directions->samples * frame.scrambles);
  if (task.standard_error != nullptr) reduce_errors(frame, task, memory);
}

// Only writes the packets that a block traces, for measuring what tracing alone takes.
template <typename L>
OMMA_HD void prepare_block(const FrameView& frame, const BlockTask& task,
                           RayPacket<L::count>* packets) {
  const ReplicateList all{nullptr, 0, frame.scrambles, task.count * frame.scrambles};
  Replicates replicates;
  make_replicates<L>(*frame.eye, task, *frame.directions, all, {}, replicates);
  Packet<L> packet;
  clear<L>(packet.rays);
  for_each_packet<L>(*frame.directions, replicates, all.count, packet, [&](const PacketStart&) {
    clear_hits<L>(packet.rays);
    *packets++ = packet.rays;
  });
}

}  // namespace omma
