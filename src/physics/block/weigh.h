// Responses from rays that neighbouring ommatidia share: a sparse matrix (sampling/shared_rays.h)
// times the radiance of the rays.
#pragma once

#include "physics/lanes/lanes.h"
#include "physics/lanes/rows.h"
#include "physics/views/version.h"

namespace omma {

// response = sum of weight[k] * radiance[ray[k]], k from first[i] to first[i + 1].
struct SharedWeights {
  const std::int64_t* first = nullptr;  // [ommatidium + 1], entries of each
  const std::int32_t* ray = nullptr;    // [entry]
  const float* weight = nullptr;        // [entry]
  std::int64_t ommatidium_count = 0, entry_count = 0, ray_count = 0;
  Version version = 0;
};

// The rays of one frame, to be weighed into responses.
struct WeighTask {
  const float* radiance = nullptr;  // [ray][output]
  float* responses = nullptr;       // [ommatidium][output]
};

// Entries of an ommatidium are whole groups of so many, the last ones of weight 0.
inline constexpr int weight_group = 16;

// n outputs of one ommatidium; in sixteen running sums whatever the width of the lanes, so that the
// bits are the same.
template <typename L, int n>
OMMA_HD void weigh_outputs(const SharedWeights& shared, const float* radiance, int outputs,
                           std::int64_t ommatidium, float* responses) {
  using F = typename L::F;
  using I = typename L::I;
  alignas(64) float packet[n][L::count];
  for (int l = 0; l < L::count; l += L::width) {
    F sums[n] = {};
    for (std::int64_t k = shared.first[ommatidium] + l; k < shared.first[ommatidium + 1];
         k += L::count) {
      const I ray = load<I>(shared.ray + k) * outputs;
      const F weight = load<F>(shared.weight + k);
      for (int o = 0; o < n; ++o) sums[o] += weight * gather(radiance + o, ray);
    }
    for (int o = 0; o < n; ++o) store(packet[o] + l, sums[o]);
  }
  for (int o = 0; o < n; ++o) responses[o] = sum_lanes<L>(packet[o]);
}

// Responses [ommatidium][output] of ommatidia first to end, from the radiance [ray][output].
template <typename L>
OMMA_HD void weigh_rays(const SharedWeights& shared, const float* radiance, int outputs,
                        std::int64_t first, std::int64_t end, float* responses) {
  static_assert(L::count == weight_group);
  for (std::int64_t i = first; i < end; ++i) {
    float* out = responses + i * outputs;
    int o = 0;
    for (; outputs - o > 3; o += 4) weigh_outputs<L, 4>(shared, radiance + o, outputs, i, out + o);
    if (outputs - o == 3) weigh_outputs<L, 3>(shared, radiance + o, outputs, i, out + o);
    if (outputs - o == 2) weigh_outputs<L, 2>(shared, radiance + o, outputs, i, out + o);
    if (outputs - o == 1) weigh_outputs<L, 1>(shared, radiance + o, outputs, i, out + o);
  }
}

}  // namespace omma
