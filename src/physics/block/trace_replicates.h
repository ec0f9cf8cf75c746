// The hot loop of a block: the rays of replicates, followed packet by packet, from directions to
// sums.
#pragma once

#include "physics/block/aimed_rays.h"
#include "physics/block/path_block.h"
#include "physics/block/sums.h"
#include "physics/block/truth_sums.h"
#include "physics/path/path.h"
#include "physics/rays/head_motion.h"

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

// The hot loop: makes the rays of replicates, packet by packet, follows them, and sums up over
// those of each replicate, in memory.sums what they brought; in memory.square_sums, where an error
// is to be reached, the squared differences between pairs of samples; in memory.truth_sums what
// they met.
template <typename L, typename Search>
OMMA_HD_CALLED void trace_replicates(const BlockRun<Search>& run, const DirectionsView& directions,
                                     const ReplicateList& list) {
  const FrameView& frame = run.frame;
  const BlockTask& task = run.task;
  const BlockMemory& memory = run.memory;
  const SceneView& scene = *frame.scene;
  Replicates<L> replicates;
  const bool has_flow = frame.truth != nullptr && frame.truth->flow;
  const bool has_choices = frame.scene->light != nullptr || task.motion != nullptr;
  make_replicates<L>(*frame.eye, task, directions, list,
                     {has_choices, scene.polarized || has_flow || task.motion != nullptr},
                     replicates);
  if (has_choices) find_acceptances(frame, replicates, list.count);
  const bool has_cones = has_aims(frame) && find_cones(frame, task, replicates, list.count, memory);
  FirstHits<L> met;
  FirstHits<L>* const first = frame.truth != nullptr ? &met : nullptr;
  const int truth_rows = frame.truth != nullptr ? rows_of(*frame.truth).count : 0;
  const int outputs = frame.outputs, samples = directions.samples, before = list.before * samples;
  RaySums<L> light{
      samples,         before,      {memory.sums, outputs, memory.stride}, memory.square_sums,
      memory.unsummed, memory.pairs};
  RaySums<L> truth{samples,
                   before,
                   {memory.truth_sums.rows, truth_rows, memory.stride},
                   nullptr,
                   memory.unsummed_truth,
                   nullptr};
  clear(light.sums, list.count);
  if (light.squares != nullptr) clear({light.squares, outputs, memory.stride}, list.count);
  if (first != nullptr) clear(*frame.truth, memory.truth_sums, list.count);
  Packet<L> packet;
  clear<L>(packet.rays);
  packet.light_sees = task.sees.by_light;

  const auto add_light_of = [&](const PacketStart& start, const float* radiance) {
    const float* output = radiance;
    if (frame.output_from_band != nullptr) {
      make_outputs<L>(frame, radiance, memory.output);
      output = memory.output;
    }
    if (task.ray_radiance != nullptr) keep_rays<L>(frame, task, list, start, output);
    light.add(start, output);
  };
  const auto add_what_was_met = [&](const PacketStart& start) {
    if (first == nullptr) return;
    eval_truth<L>(frame, task, met, memory.truth);
    add_met<L>(*frame.truth, met, samples, start, memory.truth_sums);
    truth.add(start, memory.truth);
  };
  const auto for_each = [&](const auto& eval) {
    for_each_packet<L>(directions, replicates, list.count, packet, [&](const PacketStart& start) {
      for (int l = 0; l < L::count; ++l) packet.rays.mask[l] = task.sees.from_eye;
      if (task.motion != nullptr) move_with_head<L>(*task.motion, packet);
      if (memory.paths.cell_errors != nullptr)
        name_ommatidia<L>(task, list, start, samples, packet);
      eval(start, LaneMask<L>::first(start.filled));
      add_what_was_met(start);
    });
  };

  if (scene.light == nullptr) {
    const UnlitFlight<L, Search> flight{scene, run.search, packet,
                                        scene.has_blend ? &memory.paths.passed : nullptr};
    for_each([&](const PacketStart& start, LaneMask<L> lanes) {
      eval_path(flight, lanes, memory.radiance, first);
      add_light_of(start, memory.radiance);
    });
  } else {
    // Paths of many packets at once, whose radiance is known when all have ended.
    constexpr int most_packets = packets_at_once(L::count);
    PacketStart starts[most_packets];
    LaneMask<L> in_cones[most_packets];
    int packets = 0;
    PathBlock<L, Search> block{scene, run.search, memory.paths, memory.radiance, {}};
    begin_block(packet.light_sees, block);
    const auto end = [&] {
      end_block(block);
      const int floats = packet_floats<L>(scene);
      for (int k = 0; k < packets; ++k) {
        float* const radiance = memory.radiance + k * floats;
        drop_lanes<L>(in_cones[k], floats / L::count, radiance);
        add_light_of(starts[k], radiance);
      }
      packets = 0;
    };
    for_each([&](const PacketStart& start, LaneMask<L> lanes) {
      in_cones[packets] = has_cones ? rays_in_cones(packet, start, samples, memory) : LaneMask<L>{};
      begin_paths(block, packets, lanes, packet, first);
      starts[packets++] = start;
      if (packets == most_packets) end();
    });
    end();
  }
  light.end(list.count);
  truth.end(list.count);
}

}  // namespace omma
