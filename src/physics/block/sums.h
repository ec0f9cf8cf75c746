// What the rays of a block bring, summed up over the samples of each replicate.
#pragma once

#include "physics/block/block_memory.h"
#include "physics/lanes/rows.h"
#include "physics/rays/rays.h"

namespace omma {

// Sums over the rays of replicates, [row][stride].
struct SumRows {
  double* values = nullptr;
  int rows = 0, stride = 0;
};

OMMA_HD void clear(const SumRows& sums, int replicates) {
  for (int o = 0; o < sums.rows; ++o)
    for (int u = 0; u < replicates; ++u) sums.values[o * sums.stride + u] = 0;
}

// Lanes of a packet that belong to one replicate.
struct LaneRange {
  int first, end;
};

// Adds what some lanes brought, [row][lane], to one replicate's sums.
template <typename L>
OMMA_HD void add_lanes(const float* numbers, LaneRange lanes, const SumRows& sums, int replicate) {
  using F = typename L::F;
  double* to = sums.values + replicate;
  for (int o = 0; o < sums.rows; ++o, numbers += L::count, to += sums.stride) {
    if (lanes.end - lanes.first == L::count) {
      *to += static_cast<double>(sum_lanes<L>(numbers));
      continue;
    }
    alignas(64) float x[L::count];
    for (int l = 0; l < L::count; l += L::width) {
      const auto lane = lane_numbers<L>() + l;
      store(x + l,
            lane >= lanes.first && lane < lanes.end ? load<F>(numbers + l) : broadcast<F>(0.0f));
    }
    *to += static_cast<double>(sum_lanes<L>(x));
  }
}

// What each single ray brought, where the caller asks; there is one scramble then.
template <typename L>
OMMA_HD_CALLED void keep_rays(const FrameView& frame, const BlockTask& task,
                              const ReplicateList& list, const PacketStart& start,
                              const float* light) {
  const int samples = frame.directions->samples;
  int replicate = start.replicate, sample = start.sample;
  for (int l = 0; l < start.filled; ++l) {
    const auto ommatidium =
        static_cast<std::int64_t>(frame.eye->ommatidium[ordinal_of(task, list, replicate)]);
    float* out = task.ray_radiance + (ommatidium * samples + sample) * frame.outputs;
    for (int o = 0; o < frame.outputs; ++o)
      out[o] = light[o * L::count + l] * static_cast<float>(frame.radiance_unit);
    if (++sample < samples) continue;
    sample = 0;
    ++replicate;
  }
}

// Sums over replicates of less than summed_rays samples each, each lane one of them; `rays`
// [row][row_rays]. Where asked for (not null), the squared differences between pairs of samples
// too.
template <typename L>
OMMA_HD void add_short_replicates(int samples, int replicates, const float* rays, int row_rays,
                                  const SumRows& sums, double* squares) {
  using F = typename L::F;
  for (int u = 0; u < replicates; u += L::width)
    for (int o = 0; o < sums.rows; ++o) {
      const float* of_row = rays + o * row_rays;
      const auto first = (lane_numbers<L>() + u) * samples;
      F sum = gather(of_row, first);
      for (int k = 1; k < samples; ++k) sum += gather(of_row, first + k);
      store_wide(sums.values + o * sums.stride + u, sum);
      if (squares == nullptr) continue;
      F square = broadcast<F>(0.0f);
      for (int k = 0; k < samples; k += 2) {
        const F d = gather(of_row, first + k) - gather(of_row, first + k + 1);
        square += d * d;
      }
      store_wide(squares + o * sums.stride + u, square);
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

// Sums up numbers of the rays of replicates, one packet's after another's. The sixteen rays that
// follow each other in a block are summed up at once, of those of a replicate with less samples
// each by itself: so the bits are the same in packets and in one lane, where rays wait for it.
template <typename L>
struct RaySums {
  static constexpr bool waits = L::count == 1;
  using Summed = Lanes<summed_rays, L::width>;
  static_assert(waits || L::count == summed_rays);
  static constexpr int row_rays = unsummed_rays(L::count);

  int samples;  // of a replicate
  int before;   // rays of the block before the first
  SumRows sums;
  double* squares;          // as the sums, of differences between pairs of samples; or null
  float *unsummed, *pairs;  // scratch
  int rays = 0;             // so far
  PacketStart group = {};   // what waits to be summed up at once: its first ray
  int first_lane = 0;

  // Of one packet, [row][lane].
  OMMA_HD_CALLED void add(const PacketStart& start, const float* numbers) {
    const bool is_short = samples < summed_rays;
    if constexpr (waits) {
      const int lane = is_short ? start.sample : (before + rays) % summed_rays;
      if (rays == 0 || lane == 0) group = start, first_lane = lane;
      for (int o = 0; o < sums.rows; ++o) unsummed[o * summed_rays + lane] = numbers[o];
      ++rays;
      if (is_short && start.sample + 1 == samples)
        add_short_replicates<L>(samples, 1, unsummed, summed_rays,
                                {sums.values + start.replicate, sums.rows, sums.stride},
                                squares == nullptr ? nullptr : squares + start.replicate);
      if (!is_short && lane + 1 == summed_rays)
        add_lanes_of(group, {first_lane, lane + 1}, unsummed);
    } else if (is_short) {
      for (int o = 0; o < sums.rows; ++o)
        memcpy(unsummed + o * row_rays + rays, numbers + o * L::count, L::count * sizeof(float));
      rays += L::count;
    } else {
      add_lanes_of(start, {0, start.filled}, numbers);
    }
  }

  // Behind the last.
  OMMA_HD_CALLED void end(int replicates) {
    if constexpr (waits) {
      const int lane = (before + rays) % summed_rays;
      if (samples >= summed_rays && rays > 0 && lane != 0)
        add_lanes_of(group, {first_lane, lane}, unsummed);
    } else if (samples < summed_rays) {
      add_short_replicates<L>(samples, replicates, unsummed, row_rays, sums, squares);
    }
  }

 private:
  // Sixteen rays belong to two replicates at most.
  OMMA_HD void add_lanes_of(const PacketStart& start, LaneRange lanes, const float* numbers) {
    const int left = lanes.first + samples - start.sample;
    const int in_first = left < lanes.end ? left : lanes.end;
    const auto add_to = [&](const float* of_lanes, const SumRows& to) {
      add_lanes<Summed>(of_lanes, {lanes.first, in_first}, to, start.replicate);
      if (in_first < lanes.end)
        add_lanes<Summed>(of_lanes, {in_first, lanes.end}, to, start.replicate + 1);
    };
    add_to(numbers, sums);
    if (squares == nullptr) return;
    pair_squares<Summed>(numbers, sums.rows, pairs);
    add_to(pairs, {squares, sums.rows, sums.stride});
  }
};

}  // namespace omma
