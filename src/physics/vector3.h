// Vectors of three lanes.
#pragma once

#include "physics/lanes.h"

namespace omma {

template <typename F, int n>
OMMA_HD void load_3(const float (&values)[3][n], int l, F (&out)[3]) {
  for (int r = 0; r < 3; ++r) out[r] = load<F>(values[r] + l);
}

// Of vectors.
template <typename F>
OMMA_HD F dot_lanes(const F (&a)[3], const F (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <typename F>
OMMA_HD void cross_lanes(const F (&a)[3], const F (&b)[3], F (&out)[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

}  // namespace omma
