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

// Whose rays those of a packet are, as Packet has it.
template <typename L>
OMMA_HD void name_ommatidia(const BlockTask& task, const ReplicateList& list,
                            const PacketStart& start, int samples, Packet<L>& packet) {
  int replicate = start.replicate, sample = start.sample;
  for (int l = 0; l < L::count; ++l) {
    const int listed = (replicate < list.count ? replicate : list.count - 1) / list.scrambles;
    packet.ommatidium[l] = list.ordinal == nullptr ? listed : list.ordinal[listed] - task.first;
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

// Where the sums over the rays of each replicate go, which begin as zeros: what its rays brought;
// where not null the squared differences between pairs of samples; what they met, where the frame
// asks for it.
struct ReplicateSums {
  double* light;
  double* squares;
  TruthSums truth;
};

// The hot loop: makes the rays of replicates, packet by packet, follows them, and adds what they
// bring to their replicates' sums.
template <typename L, typename Search>
OMMA_HD_CALLED void trace_replicates(const BlockRun<Search>& run, const DirectionsView& directions,
                                     const ReplicateList& list, const ReplicateSums& to) {
  const FrameView& frame = run.frame;
  const BlockTask& task = run.task;
  const BlockMemory& memory = run.memory;
  const SceneView& scene = *frame.scene;
  Replicates replicates;
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
  const bool is_short = directions.samples < L::count;
  const int outputs = frame.outputs;
  Packet<L> packet;
  clear<L>(packet.rays);
  packet.light_sees = task.sees.by_light;

  // Adds the numbers of a packet's rays, [row][lane], to their replicates.
  const auto add = [&](const PacketStart& start, const float* rays, int count, double* sums) {
    const int left = directions.samples - start.sample,
              in_first = left < L::count ? left : L::count;
    const int end = in_first < start.filled ? in_first : start.filled;
    add_lanes<L>(rays, 0, end, count, sums, start.replicate);
    if (end < start.filled) add_lanes<L>(rays, end, start.filled, count, sums, start.replicate + 1);
  };
  const auto keep_short = [](const float* rays, int count, int traced, float* all) {
    for (int o = 0; o < count; ++o)
      memcpy(all + o * short_capacity + traced, rays + o * L::count, L::count * sizeof(float));
  };
  int of_light = 0, of_truth = 0;  // rays so far, where replicates are short
  const auto add_light_of = [&](const PacketStart& start, const float* radiance) {
    const float* output = radiance;
    if (frame.output_from_band != nullptr) {
      make_outputs<L>(frame, radiance, memory.output);
      output = memory.output;
    }
    if (task.ray_radiance != nullptr) keep_rays<L>(frame, task, start, output);
    if (is_short) {
      keep_short(output, outputs, of_light, memory.short_rays);
      of_light += L::count;
      return;
    }
    add(start, output, outputs, to.light);
    if (to.squares == nullptr) return;
    if constexpr (L::count == 1) {
      add_pair(output, start.sample, outputs, memory.squares, to.squares, start.replicate);
    } else {
      pair_squares<L>(output, outputs, memory.squares);
      add(start, memory.squares, outputs, to.squares);
    }
  };
  const auto add_what_was_met = [&](const PacketStart& start) {
    if (first == nullptr) return;
    eval_truth<L>(frame, task, met, memory.truth);
    add_met<L>(*frame.truth, met, directions.samples, start, to.truth);
    if (is_short) {
      keep_short(memory.truth, truth_rows, of_truth, memory.short_truth);
      of_truth += L::count;
    } else {
      add(start, memory.truth, truth_rows, to.truth.rows);
    }
  };
  const auto for_each = [&](const auto& eval) {
    for_each_packet<L>(directions, replicates, list.count, packet, [&](const PacketStart& start) {
      for (int l = 0; l < L::count; ++l) packet.rays.mask[l] = task.sees.from_eye;
      if (task.motion != nullptr) move_with_head<L>(*task.motion, packet);
      if (memory.paths.cell_errors != nullptr)
        name_ommatidia<L>(task, list, start, directions.samples, packet);
      eval(start, LaneMask<L>::first(start.filled));
      add_what_was_met(start);
    });
  };

  if (scene.light == nullptr) {
    PassedSurfaces<L::count> passed;
    const UnlitFlight<L, Search> flight{scene, run.search, packet,
                                        scene.has_blend ? &passed : nullptr};
    for_each([&](const PacketStart& start, LaneMask<L> lanes) {
      eval_path(flight, lanes, memory.radiance, first);
      add_light_of(start, memory.radiance);
    });
  } else {
    // Paths of many packets at once, whose radiance is known when all have ended.
    constexpr int most_packets = block_rays / L::count;
    PacketStart starts[most_packets];
    LaneMask<L> in_cones[most_packets];
    int packets = 0;
    PathBlock<L, Search> block{scene, run.search, memory.paths, memory.radiance, {}, {}, {}, {}};
    block.waiting.throughput = memory.paths.waiting;
    block.waiting_for_last.throughput = memory.paths.waiting_for_last;
    clear<L>(block.onward.rays);
    block.onward.light_sees = packet.light_sees;
    const auto end = [&] {
      trace_waiting(block, 1);
      const int floats = packet_floats<L>(scene);
      for (int k = 0; k < packets; ++k) {
        float* const radiance = memory.radiance + k * floats;
        drop_lanes<L>(in_cones[k], floats / L::count, radiance);
        add_light_of(starts[k], radiance);
      }
      packets = 0;
    };
    for_each([&](const PacketStart& start, LaneMask<L> lanes) {
      in_cones[packets] =
          has_cones ? rays_in_cones(packet, start, directions.samples, memory) : LaneMask<L>{};
      begin_paths(block, packets, lanes, packet, first);
      starts[packets++] = start;
      if (packets == most_packets) end();
    });
    end();
  }
  if (!is_short) return;
  add_short_replicates<L>(directions.samples, list.count, outputs, memory.short_rays, to.light,
                          to.squares);
  add_short_replicates<L>(directions.samples, list.count, truth_rows, memory.short_truth,
                          to.truth.rows, static_cast<double*>(nullptr));
}

}  // namespace omma
