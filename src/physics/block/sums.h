// What the rays of a block bring, summed up over the samples of each replicate.
#pragma once

#include "physics/block/block_memory.h"
#include "physics/lanes/rows.h"
#include "physics/rays/rays.h"

namespace omma {

// Adds what lanes [first, end) brought to one replicate's sums; `light`: [output][lane].
template <typename L>
OMMA_HD void add_lanes(const float* light, int first, int end, int outputs, double* sums,
                       int replicate) {
  using F = typename L::F;
  for (int o = 0; o < outputs; ++o, light += L::count, sums += padded_capacity) {
    if (end - first == L::count) {
      sums[replicate] += static_cast<double>(sum_lanes<L>(light));
      continue;
    }
    alignas(64) float x[L::count];
    for (int l = 0; l < L::count; l += L::width) {
      const auto lane = lane_numbers<L>() + l;
      store(x + l, lane >= first && lane < end ? load<F>(light + l) : broadcast<F>(0.0f));
    }
    sums[replicate] += static_cast<double>(sum_lanes<L>(x));
  }
}

// What each single ray brought, where the caller asks; there is one scramble then.
template <typename L>
OMMA_HD void keep_rays(const FrameView& frame, const BlockTask& task, const PacketStart& start,
                       const float* light) {
  const int samples = frame.directions->samples;
  int replicate = start.replicate, sample = start.sample;
  for (int l = 0; l < start.filled; ++l) {
    const auto ommatidium =
        static_cast<std::int64_t>(frame.eye->ommatidium[task.first + replicate]);
    float* out = task.ray_radiance + (ommatidium * samples + sample) * frame.outputs;
    for (int o = 0; o < frame.outputs; ++o)
      out[o] = light[o * L::count + l] * static_cast<float>(frame.radiance_unit);
    if (++sample < samples) continue;
    sample = 0;
    ++replicate;
  }
}

// Sums over replicates that are shorter than a packet, each lane one of them; where asked for (not
// null), the squared differences between pairs of samples too.
template <typename L>
OMMA_HD void add_short_replicates(int samples, int replicates, int outputs, const float* rays,
                                  double* sums, double* squares) {
  using F = typename L::F;
  for (int u = 0; u < replicates; u += L::width)
    for (int o = 0; o < outputs; ++o) {
      const float* of_output = rays + o * short_capacity;
      const auto first = (lane_numbers<L>() + u) * samples;
      F sum = gather(of_output, first);
      for (int k = 1; k < samples; ++k) sum += gather(of_output, first + k);
      store_wide(sums + o * padded_capacity + u, sum);
      if (squares == nullptr) continue;
      F square = broadcast<F>(0.0f);
      for (int k = 0; k < samples; k += 2) {
        const F d = gather(of_output, first + k) - gather(of_output, first + k + 1);
        square += d * d;
      }
      store_wide(squares + o * padded_capacity + u, square);
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

// The same for a packet of one ray, the second of each pair of which adds to its replicate's
// squares; `first` [output] holds the other.
OMMA_HD void add_pair(const float* light, int sample, int outputs, float* first, double* squares,
                      int replicate) {
  for (int o = 0; o < outputs; ++o) {
    const float d = first[o] - light[o];
    if (sample % 2 == 0)
      first[o] = light[o];
    else
      squares[o * padded_capacity + replicate] += static_cast<double>(d * d);
  }
}

}  // namespace omma
