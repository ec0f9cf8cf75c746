// The hot loop of a block: the rays of replicates, followed packet by packet, from directions to
// sums.
#pragma once

#include "physics/block/aimed_rays.h"
#include "physics/block/path_block.h"
#include "physics/block/sums.h"
#include "physics/block/truth_sums.h"
#include "physics/path/path.h"
#include "physics/rays/head_motion.h"
#include "physics/views/truth_view.h"

namespace omma {

// Whose rays those of a packet are, as Packet has it: their number among those that cell errors are
// summed up for.
template <typename L>
OMMA_HD void name_ommatidia(const BlockTask& task, const ReplicateList& list,
                            const PacketStart& start, int samples, Packet<L>& packet) {
  if constexpr (L::count == 1) {
    packet.ommatidium[0] = 0;  // a thread's own
    return;
  }
  int replicate = start.replicate, sample = start.sample;
  for (int l = 0; l < L::count; ++l) {
    const int own = replicate < list.count ? replicate : list.count - 1;
    packet.ommatidium[l] = ordinal_of(task, list, own) - task.first;
    if (++sample < samples) continue;
    sample = 0;
    ++replicate;
  }
}

// What a block is traced with.
template <typename Search>
struct BlockRun {
  const FrameView& frame;
  const BlockTask& task;
  Search& search;
  const BlockMemory& memory;
};

// Replicates on their way: rays of theirs that are followed, packet by packet, and the sums over
// what they bring and meet.
template <typename L, typename Search>
struct ReplicateTrace {
  const BlockRun<Search>& run;
  const DirectionsView& directions;
  const ReplicateList& list;
  const Replicates<L>& replicates;
  Packet<L>& packet;
  FirstHits<L>* first;  // takes what the packet met, where ground truth is asked for; else null
  bool has_cones;       // some rays are in cones that replicates aim at
  RaySums<L> light, truth;
  TruthSums truth_sums;  // of the list's replicates
};

// Adds the radiance of a packet to the sums.
template <typename L, typename Search>
OMMA_HD_CALLED void add_light_of(ReplicateTrace<L, Search>& trace, const PacketStart& start,
                                 const float* radiance) {
  const FrameView& frame = trace.run.frame;
  const float* output = radiance;
  if (frame.output_from_band != nullptr) {
    make_outputs<L>(frame, radiance, trace.run.memory.output);
    output = trace.run.memory.output;
  }
  if (trace.run.task.ray_radiance != nullptr)
    keep_rays<L>(frame, trace.run.task, trace.list, start, output);
  trace.light.add(start, output);
}

// Makes the rays of each packet, calls `eval(start, lanes)`, which follows them, and adds what they
// met to the sums.
template <typename L, typename Search, typename Eval>
OMMA_HD void for_each_traced(ReplicateTrace<L, Search>& trace, const Eval& eval) {
  const BlockTask& task = trace.run.task;
  const BlockMemory& memory = trace.run.memory;
  const int samples = trace.directions.samples;
  Packet<L>& packet = trace.packet;
  for_each_packet<L>(
      trace.directions, trace.replicates, trace.list.count, packet,
      [&](const PacketStart& start) __attribute__((always_inline)) {  // as OMMA_HD
        for (int l = 0; l < L::count; ++l) packet.rays.mask[l] = task.sees.from_eye;
        if (task.motion != nullptr) move_with_head<L>(*task.motion, packet);
        if (memory.paths.cell_errors != nullptr)
          name_ommatidia<L>(task, trace.list, start, samples, packet);
        eval(start, LaneMask<L>::first(start.filled));
        if (trace.first == nullptr) return;
        const TruthView& view = *trace.run.frame.truth;
        eval_truth<L>(trace.run.frame, task, *trace.first, memory.truth);
        add_met<L>(view, *trace.first, samples, start, trace.truth_sums);
        trace.truth.add(start, memory.truth);
      });
}

template <typename L, typename Search>
OMMA_HD_CALLED void trace_unlit(ReplicateTrace<L, Search>& trace) {
  const SceneView& scene = *trace.run.frame.scene;
  const BlockMemory& memory = trace.run.memory;
  const UnlitFlight<L, Search> flight{scene, trace.run.search, trace.packet,
                                      scene.has_blend ? &memory.paths.passed : nullptr};
  for_each_traced(
      trace, [&](const PacketStart& start, LaneMask<L> lanes) __attribute__((always_inline)) {
        eval_path(flight, lanes, memory.radiance, trace.first);
        add_light_of(trace, start, memory.radiance);
      });
}

// In lit worlds paths of many packets are followed at once, whose radiance is known when all have
// ended.
template <typename L, typename Search>
OMMA_HD_CALLED void trace_lit(ReplicateTrace<L, Search>& trace) {
  const SceneView& scene = *trace.run.frame.scene;
  const BlockMemory& memory = trace.run.memory;
  Packet<L>& packet = trace.packet;
  const int floats = packet_floats<L>(scene);
  constexpr int most_packets = packets_at_once(L::count);
  PacketStart starts[most_packets];
  LaneMask<L> in_cones[most_packets];
  int packets = 0;
  PathBlock<L, Search> block{scene, trace.run.search, memory.paths, memory.radiance, {}};
  begin_block(packet.light_sees, block);
  const auto end = [&] {
    end_block(block);
    for (int k = 0; k < packets; ++k) {
      float* const radiance = memory.radiance + k * floats;
      drop_lanes<L>(in_cones[k], floats / L::count, radiance);
      add_light_of(trace, starts[k], radiance);
    }
    packets = 0;
  };
  for_each_traced(
      trace, [&](const PacketStart& start, LaneMask<L> lanes) __attribute__((always_inline)) {
        in_cones[packets] = trace.has_cones ? rays_in_cones(scene, trace.replicates, packet, start,
                                                            trace.directions.samples, memory)
                                            : LaneMask<L>{};
        begin_paths(block, packets, lanes, packet, trace.first);
        starts[packets++] = start;
        if (packets == most_packets) end();
      });
  end();
}

// The hot loop: makes the rays of replicates, packet by packet, follows them, and sums up over
// those of each replicate, in memory.sums what they brought; in memory.square_sums, where an error
// is to be reached, the squared differences between pairs of samples; in memory.truth_sums what
// they met; all from list.sums_at on.
template <typename L, typename Search>
OMMA_HD_CALLED void trace_replicates(const BlockRun<Search>& run, const DirectionsView& directions,
                                     const ReplicateList& list) {
  const FrameView& frame = run.frame;
  const BlockTask& task = run.task;
  const BlockMemory& memory = run.memory;
  const SceneView& scene = *frame.scene;
  InMemory<L, Replicates<L>> own_replicates;
  InMemory<L, Packet<L>> own_packet;
  InMemory<L, FirstHits<L>> own_met;
  Replicates<L>& replicates = own_replicates.in(memory.replicates);
  Packet<L>& packet = own_packet.in(memory.packet);
  FirstHits<L>& met = own_met.in(memory.met);
  const bool has_truth = frame.truth != nullptr;
  const bool has_flow = has_truth && frame.truth->flow;
  const bool has_choices = scene.light != nullptr || task.motion != nullptr;
  make_replicates<L>(*frame.eye, task, directions, list,
                     {has_choices, scene.polarized || has_flow || task.motion != nullptr},
                     replicates);
  if (has_choices) find_acceptances(frame, replicates, list.count);
  clear<L>(packet.rays);
  packet.light_sees = task.sees.by_light;
  const int samples = directions.samples, before = list.before * samples;
  const auto at = [&](double* sums) { return sums == nullptr ? nullptr : sums + list.sums_at; };
  ReplicateTrace<L, Search> trace{
      run,
      directions,
      list,
      replicates,
      packet,
      has_truth ? &met : nullptr,
      has_aims(frame) && find_all_in_view(frame, task, replicates, list.count, memory),
      {samples,
       before,
       {at(memory.sums), frame.outputs, memory.stride},
       at(memory.square_sums),
       memory.unsummed,
       memory.pairs},
      {samples, before, {}, nullptr, memory.unsummed_truth, nullptr},
      {}};
  clear(trace.light.sums, list.count);
  if (memory.square_sums != nullptr)
    clear({at(memory.square_sums), frame.outputs, memory.stride}, list.count);
  if (has_truth) {
    trace.truth_sums = sums_from(*frame.truth, memory.truth_sums, list.sums_at);
    trace.truth.sums = {trace.truth_sums.rows, rows_of(*frame.truth).count, memory.stride};
    clear(*frame.truth, trace.truth_sums, list.count);
  }
  if (scene.light == nullptr)
    trace_unlit(trace);
  else
    trace_lit(trace);
  trace.light.end(list.count);
  trace.truth.end(list.count);
}

}  // namespace omma
