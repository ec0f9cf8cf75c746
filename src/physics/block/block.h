// One block of neighbouring ommatidia at one pose, from directions to responses:
// trace_replicates.h, the hot loop, then means and standard errors. A backend runs it with a search
// of its own, which has four members (surface/scene_search.h is the one of our own hierarchy):
//
//   closest(lanes, rays, passed, spread)
//     the closest accepted hits (surface.h) of a RayPacket, between t_near_m and t_far_m, of the
//     lanes that are on (LaneMask); where `passed` is not null, surfaces that a ray has passed
//     (passed.h) do not count; `spread`: how the rays lie to each other
//   occluded(lanes, rays)
//     those of the lanes whose ray meets any accepted surface there; shadow rays ask no more
//   placed()
//     the table of placed meshes that hits point into
//   visits_of_trees()
//     where one lane keeps what is still to be visited of a tree, as that of splats
//
// Nothing is allocated, nothing is called out of line that other instruction sets share.
#pragma once

#include "physics/block/estimate.h"
#include "physics/block/truth_sums.h"
#include "physics/sampling/mean_of_estimates.h"

namespace omma {

// Responses from the sums over replicates: the mean over all scrambles.
OMMA_HD void reduce(const FrameView& frame, const BlockTask& task, const ReplicateList& list,
                    const BlockMemory& memory) {
  const int scrambles = list.scrambles;
  const double weight =
      frame.radiance_unit / (static_cast<double>(frame.directions->samples) * scrambles);
  const double* sums = memory.sums;
  for (int o = 0; o < frame.outputs; ++o, sums += memory.stride)
    for (int u = 0; u < list.count; u += scrambles) {
      double sum = sums[u];
      for (int r = 1; r < scrambles; ++r) sum += sums[u + r];
      const std::int64_t ommatidium = frame.eye->ommatidium[ordinal_of(task, list, u)];
      task.responses[ommatidium * frame.outputs + o] = static_cast<float>(sum * weight);
    }
}

// Standard errors of the responses, from the spread of the scrambles and from what cells of baked
// light err by, which all scrambles see alike.
OMMA_HD void reduce_errors(const FrameView& frame, const BlockTask& task, const ReplicateList& list,
                           const BlockMemory& memory) {
  const double samples = frame.directions->samples;
  const int scrambles = list.scrambles;
  for (int u = 0; u < list.count; u += scrambles) {
    const std::int64_t ommatidium = frame.eye->ommatidium[ordinal_of(task, list, u)];
    const float* cell_errors = cell_errors_of(frame, memory.paths.cell_errors, u / scrambles);
    for (int o = 0; o < frame.outputs; ++o) {
      const double* estimates = memory.sums + o * memory.stride + u;
      const double squares =
          mean_of_estimates(scrambles, [&](int r) { return estimates[r] / samples; }).squares;
      const double of_cells = cell_variance(frame, cell_errors, o, samples * scrambles);
      task.standard_error[ommatidium * frame.outputs + o] = static_cast<float>(
          sqrt(squares / (scrambles * (scrambles - 1.0)) + of_cells) * frame.radiance_unit);
    }
  }
}

// All that is asked for of the ommatidia of a list, whose sums are there.
template <typename L>
OMMA_HD_CALLED void reduce_all(const FrameView& frame, const BlockTask& task,
                               const ReplicateList& list, const BlockMemory& memory) {
  reduce(frame, task, list, memory);
  for (int u = 0; frame.truth != nullptr && u < list.count; u += list.scrambles)
    reduce_truth(
        frame, task, memory.truth_sums,
        {ordinal_of(task, list, u), u, list.scrambles, frame.directions->samples * list.scrambles});
  if (task.standard_error != nullptr) reduce_errors(frame, task, list, memory);
}

// Traces replicates, and adds to the sums over the rays of each what it sees of discs of the sky,
// and where it aims, besides.
template <typename L, typename Search>
OMMA_HD void trace_list(const BlockRun<Search>& run, const ReplicateList& list) {
  const FrameView& frame = run.frame;
  const BlockTask& task = run.task;
  const BlockMemory& memory = run.memory;
  trace_replicates<L>(run, *frame.directions, list);
  if (!sees_beside_rays(frame)) return;
  const int samples = frame.directions->samples;
  const auto give = [&](int u, int o) {
    return ByRays{memory.sums[o * memory.stride + list.sums_at + u] / samples, 0};
  };
  const auto take = [&](int u) {
    const std::int64_t ommatidium = frame.eye->ommatidium[ordinal_of(task, list, u)];
    for (int o = 0; o < frame.outputs; ++o) {
      const double seen = memory.beside[o];
      memory.sums[o * memory.stride + list.sums_at + u] += samples * seen;
      if (task.beside_rays == nullptr) continue;
      float* const rows = task.beside_rays + ommatidium * (1 + axis_moments) * frame.outputs + o;
      rows[0] = static_cast<float>(seen * frame.radiance_unit);
      for (int m = 0; m < axis_moments; ++m)
        rows[(1 + m) * frame.outputs] =
            static_cast<float>(memory.beside_moments[m * frame.outputs + o] * frame.radiance_unit);
    }
  };
  eval_beside_rays<L>(frame, task, list, run.search, memory, BesideCalls{give, take});
}

// Renders the ommatidia of a list, each with as many rays. In one lane there is one, whose
// scrambles are traced one after another.
template <typename L, typename Search>
OMMA_HD void render_list(const BlockRun<Search>& run, const ReplicateList& list) {
  const FrameView& frame = run.frame;
  const BlockTask& task = run.task;
  const BlockMemory& memory = run.memory;
  clear_cell_errors(frame, memory.paths.cell_errors, list.count / list.scrambles);
  if constexpr (L::count > 1) {
    trace_list<L>(run, list);
  } else {
    for (int u = 0; u < list.count; ++u)
      trace_list<L>(run, {list.ordinal, list.first_scramble + u, 1, 1, list.before + u, u});
  }
  reduce_all<L>(frame, task, list, memory);
}

// Adds to responses what the ommatidia of a list, under one scramble, see of discs of the sky;
// their rays have left it out.
template <typename L, typename Search>
OMMA_HD void render_discs(const BlockRun<Search>& run, const ReplicateList& list) {
  const FrameView& frame = run.frame;
  const BlockTask& task = run.task;
  const BlockMemory& memory = run.memory;
  if (!sees_beside_rays(frame)) return;
  const auto response = [&](int u, int o) -> float& {
    const std::int64_t ommatidium = frame.eye->ommatidium[ordinal_of(task, list, u)];
    return task.responses[ommatidium * frame.outputs + o];
  };
  const auto give = [&](int u, int o) {
    return ByRays{static_cast<double>(response(u, o)) / frame.radiance_unit, 0};
  };
  const auto take = [&](int u) {
    for (int o = 0; o < frame.outputs; ++o)
      response(u, o) += static_cast<float>(memory.beside[o] * frame.radiance_unit);
  };
  eval_beside_rays<L>(frame, task, list, run.search, memory, BesideCalls{give, take});
}

// All ommatidia of a block, under so many scrambles.
OMMA_HD ReplicateList all_of(const BlockTask& task, int scrambles) {
  return {nullptr, 0, scrambles, task.count * scrambles};
}

// `memory`: of this thread, lay_out for this frame.
template <typename L, typename Search>
OMMA_HD void render_block(const BlockRun<Search>& run) {
  if (run.frame.most_samples > 0) return render_to_error<L>(run);
  render_list<L>(run, all_of(run.task, run.frame.scrambles));
}

// Only writes the packets that a block traces, for measuring what tracing alone takes.
template <typename L>
OMMA_HD void prepare_block(const FrameView& frame, const BlockTask& task,
                           RayPacket<L::count>* packets) {
  const ReplicateList all = all_of(task, frame.scrambles);
  Replicates<L> replicates;
  make_replicates<L>(*frame.eye, task, *frame.directions, all, {}, replicates);
  Packet<L> packet;
  clear<L>(packet.rays);
  for_each_packet<L>(*frame.directions, replicates, all.count, packet, [&](const PacketStart&) {
    clear_hits<L>(packet.rays);
    *packets++ = packet.rays;
  });
}

}  // namespace omma
