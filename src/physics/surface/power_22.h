// CompoundRay's rule for colours: textures and vertex colours to the power 2.2, read from a table.
#pragma once

#include "physics/surface/texture.h"

namespace omma {

// t^2.2 for t in [0, 1], from the table: within 2e-8.
template <typename F>
OMMA_HD F eval_power_22(const float* table, F t) {
  const F x = clamp_unit_lanes(t) * static_cast<float>(power_22_size - 1);
  auto i = to_int(x);
  i = i < power_22_size - 2 ? i : i * 0 + (power_22_size - 2);
  const F below = gather(table, i);
  return below + (gather(table, i + 1) - below) * (x - to_float(i));
}

template <typename F>
OMMA_HD Color<F> eval_power_22(const float* table, const Color<F>& c) {
  return {eval_power_22(table, c.r), eval_power_22(table, c.g), eval_power_22(table, c.b), c.a};
}

}  // namespace omma
