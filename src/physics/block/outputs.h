// What is asked for of the bands that rays bring: themselves, or mixtures of them.
#pragma once

#include "physics/lanes/lanes.h"
#include "physics/views/frame_view.h"

namespace omma {

// What outputs the bands of a packet make, where there is a matrix.
template <typename L>
OMMA_HD void make_outputs(const FrameView& frame, const float* radiance, float* output) {
  using F = typename L::F;
  const int bands = frame.scene->bands * (frame.scene->polarized ? 3 : 1);
  for (int o = 0; o < frame.outputs; ++o)
    for (int l = 0; l < L::count; l += L::width) {
      F sum = broadcast<F>(0.0f);
      for (int b = 0; b < bands; ++b)
        sum += load<F>(radiance + b * L::count + l) * frame.output_from_band[o * bands + b];
      store(output + o * L::count + l, sum);
    }
}

}  // namespace omma
