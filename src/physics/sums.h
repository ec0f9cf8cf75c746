// What the rays of a block bring, summed up over the samples of each unit.
#pragma once

#include "physics/aimed_rays.h"
#include "physics/block_memory.h"
#include "physics/head_motion.h"
#include "physics/path.h"
#include "physics/path_block.h"
#include "physics/rows.h"

namespace omma {

// Adds what lanes [first, end) brought to one unit's sums; `light`: [output][lane].
template <typename L>
OMMA_HD void add_lanes(const float* light, int first, int end, int outputs, double* sums,
                       int unit) {
  using F = typename L::F;
  for (int o = 0; o < outputs; ++o, light += L::count, sums += unit_room) {
    if (end - first == L::count) {
      sums[unit] += static_cast<double>(sum_lanes<L>(light));
      continue;
    }
    alignas(64) float x[L::count];
    for (int l = 0; l < L::count; l += L::width) {
      const auto lane = lane_numbers<L>() + l;
      store(x + l, lane >= first && lane < end ? load<F>(light + l) : broadcast<F>(0.0f));
    }
    sums[unit] += static_cast<double>(sum_lanes<L>(x));
  }
}

// What each single ray brought, where the caller asks; there is one scramble then.
template <typename L>
OMMA_HD void keep_rays(const FrameView& frame, const BlockTask& task, const PacketPlace& place,
                       const float* light) {
  const int samples = frame.directions->samples;
  int unit = place.unit, sample = place.sample;
  for (int l = 0; l < place.filled; ++l) {
    const auto ommatidium = static_cast<std::int64_t>(frame.eye->ommatidium[task.first + unit]);
    float* out = task.ray_radiance + (ommatidium * samples + sample) * frame.outputs;
    for (int o = 0; o < frame.outputs; ++o)
      out[o] = light[o * L::count + l] * static_cast<float>(frame.radiance_unit);
    if (++sample < samples) continue;
    sample = 0;
    ++unit;
  }
}

// Sums over units that are shorter than a packet, each lane one of them; where asked for (not
// null), the squared differences between pairs of samples too.
template <typename L>
OMMA_HD void add_short_units(int samples, int units, int outputs, const float* rays, double* sums,
                             double* squares) {
  using F = typename L::F;
  for (int u = 0; u < units; u += L::width)
    for (int o = 0; o < outputs; ++o) {
      const float* of_output = rays + o * short_room;
      const auto first = (lane_numbers<L>() + u) * samples;
      F sum = gather(of_output, first);
      for (int k = 1; k < samples; ++k) sum += gather(of_output, first + k);
      store_wide(sums + o * unit_room + u, sum);
      if (squares == nullptr) continue;
      F square = broadcast<F>(0.0f);
      for (int k = 0; k < samples; k += 2) {
        const F d = gather(of_output, first + k) - gather(of_output, first + k + 1);
        square += d * d;
      }
      store_wide(squares + o * unit_room + u, square);
    }
}

// What add_lanes makes of this is the sum of the squared differences of pairs of samples, which are
// neighbours in the pattern.
template <typename L>
OMMA_HD void pair_squares(const float* light, int outputs, float* squares) {
  using F = typename L::F;
  for (int i = 0; i < outputs * L::count; i += L::width) {
    F other;
    if constexpr (L::width == 1)
      other = light[i ^ 1];
    else
      other = pick(light + i, lane_numbers<L>() ^ 1);
    const F d = load<F>(light + i) - other;
    store(squares + i, d * d * 0.5f);
  }
}

// The same for a packet of one ray, the second of each pair of which adds to its unit's squares;
// `first` [output] holds the other.
OMMA_HD void add_pair(const float* light, int sample, int outputs, float* first, double* squares,
                      int unit) {
  for (int o = 0; o < outputs; ++o) {
    const float d = first[o] - light[o];
    if (sample % 2 == 0)
      first[o] = light[o];
    else
      squares[o * unit_room + unit] += static_cast<double>(d * d);
  }
}

// Whose rays those of a packet are, as Packet has it.
template <typename L>
OMMA_HD void name_ommatidia(const BlockTask& task, const UnitList& list, const PacketPlace& place,
                            int samples, Packet<L>& packet) {
  int unit = place.unit, sample = place.sample;
  for (int l = 0; l < L::count; ++l) {
    const int listed = (unit < list.count ? unit : list.count - 1) / list.scrambles;
    packet.ommatidium[l] = list.ordinal == nullptr ? listed : list.ordinal[listed] - task.first;
    if (++sample < samples) continue;
    sample = 0;
    ++unit;
  }
}

// Traces and shades units, into `sums`; `squares`, where not null, takes those of the differences
// between pairs of samples; `truth` what is met, where the frame asks for it. All begin as zeros.
template <typename L, typename Search>
OMMA_HD void trace_units(const FrameView& frame, const BlockTask& task,
                         const DirectionsView& directions, const UnitList& list, Search& search,
                         const BlockMemory& memory, double* sums, double* squares,
                         const TruthSums& truth) {
  Units units;
  const bool has_flow = frame.truth != nullptr && frame.truth->flow;
  const bool has_choices = frame.scene->light != nullptr || task.motion != nullptr;
  make_units<L>(*frame.eye, task, directions, list, has_choices,
                frame.scene->polarized || has_flow || task.motion != nullptr, units);
  if (has_choices) find_acceptances(frame, units, list.count);
  const bool has_cones = has_aims(frame) && find_cones(frame, task, units, list.count, memory);
  FirstHits<L> met;
  FirstHits<L>* const first = frame.truth != nullptr ? &met : nullptr;
  const int truth_rows = frame.truth != nullptr ? rows_of(*frame.truth).count : 0;
  const bool is_short = directions.samples < L::count;
  const int outputs = frame.outputs;
  Packet<L> packet;
  clear<L>(packet.rays);
  packet.light_sees = task.sees.by_light;

  // Adds the numbers of a packet's rays, [row][lane], to their units.
  const auto add = [&](const PacketPlace& place, const float* rays, int count, double* to) {
    const int left = directions.samples - place.sample, in_first = left < L::count ? left : L::count;
    const int end = in_first < place.filled ? in_first : place.filled;
    add_lanes<L>(rays, 0, end, count, to, place.unit);
    if (end < place.filled) add_lanes<L>(rays, end, place.filled, count, to, place.unit + 1);
  };
  const auto keep_short = [](const float* rays, int count, int traced, float* to) {
    for (int o = 0; o < count; ++o)
      memcpy(to + o * short_room + traced, rays + o * L::count, L::count * sizeof(float));
  };
  int of_light = 0, of_truth = 0;  // rays so far, where units are short
  const auto add_light_of = [&](const PacketPlace& place, const float* radiance) {
    const float* output = radiance;
    if (frame.output_from_band != nullptr) {
      make_outputs<L>(frame, radiance, memory.output);
      output = memory.output;
    }
    if (task.ray_radiance != nullptr) keep_rays<L>(frame, task, place, output);
    if (is_short) {
      keep_short(output, outputs, of_light, memory.short_rays);
      of_light += L::count;
      return;
    }
    add(place, output, outputs, sums);
    if (squares == nullptr) return;
    if constexpr (L::count == 1) {
      add_pair(output, place.sample, outputs, memory.squares, squares, place.unit);
    } else {
      pair_squares<L>(output, outputs, memory.squares);
      add(place, memory.squares, outputs, squares);
    }
  };
  const auto add_what_was_met = [&](const PacketPlace& place) {
    if (first == nullptr) return;
    eval_truth<L>(frame, task, met, memory.truth);
    add_met<L>(*frame.truth, met, directions.samples, place.unit, place.sample, place.filled,
               truth);
    if (is_short) {
      keep_short(memory.truth, truth_rows, of_truth, memory.short_truth);
      of_truth += L::count;
    } else {
      add(place, memory.truth, truth_rows, truth.rows);
    }
  };
  const auto for_each = [&](const auto& eval) {
    for_each_packet<L>(directions, units, list.count, packet, [&](const PacketPlace& place) {
      alignas(L::count * 4) std::int32_t valid[L::count];
      for (int l = 0; l < L::count; ++l) valid[l] = l < place.filled ? -1 : 0;
      for (int l = 0; l < L::count; ++l) packet.rays.mask[l] = task.sees.from_eye;
      if (task.motion != nullptr) move_with_head<L>(*task.motion, packet);
      if (memory.paths.cell_errors != nullptr)
        name_ommatidia<L>(task, list, place, directions.samples, packet);
      eval(place, valid);
      add_what_was_met(place);
    });
  };

  if (frame.scene->light == nullptr) {
    for_each([&](const PacketPlace& place, const std::int32_t* valid) {
      eval_path<L>(*frame.scene, search, valid, packet, memory.radiance, first);
      add_light_of(place, memory.radiance);
    });
  } else {
    // Paths of many packets at once, whose radiance is known when all have ended.
    constexpr int most_packets = block_rays / L::count;
    PacketPlace places[most_packets];
    unsigned in_cones[most_packets];
    int packets = 0;
    PathBlock<L, Search> block{*frame.scene, search, memory.paths, memory.radiance, {}, {}, {}, {}};
    block.waiting.throughput = memory.paths.waiting;
    block.waiting_for_last.throughput = memory.paths.waiting_for_last;
    clear<L>(block.onward.rays);
    block.onward.light_sees = packet.light_sees;
    const auto end = [&] {
      follow<L>(block, 1);
      const int floats = packet_floats<L>(*frame.scene);
      for (int k = 0; k < packets; ++k) {
        float* const radiance = memory.radiance + k * floats;
        drop_lanes<L>(in_cones[k], floats / L::count, radiance);
        add_light_of(places[k], radiance);
      }
      packets = 0;
    };
    for_each([&](const PacketPlace& place, const std::int32_t* valid) {
      in_cones[packets] =
          has_cones ? rays_in_cones(packet, place, directions.samples, memory) : 0;
      begin_paths<L>(block, packets, valid, packet, first);
      places[packets++] = place;
      if (packets == most_packets) end();
    });
    end();
  }
  if (!is_short) return;
  add_short_units<L>(directions.samples, list.count, outputs, memory.short_rays, sums, squares);
  add_short_units<L>(directions.samples, list.count, truth_rows, memory.short_truth, truth.rows,
                     static_cast<double*>(nullptr));
}

}  // namespace omma
