// The mean of independent estimates, and how they spread about it: the variance of the mean of n is
// squares / (n (n - 1)).
#pragma once

#include "omma/vec.h"

namespace omma {

struct MeanOfEstimates {
  double mean = 0, squares = 0;  // the sum of the squared differences from the mean
};

// `estimate(k)`, k from 0 to count - 1.
template <typename Estimate>
OMMA_HD MeanOfEstimates mean_of_estimates(int count, const Estimate& estimate) {
  MeanOfEstimates of;
  for (int k = 0; k < count; ++k) of.mean += estimate(k);
  of.mean /= count;
  for (int k = 0; k < count; ++k) {
    const double d = estimate(k) - of.mean;
    of.squares += d * d;
  }
  return of;
}

}  // namespace omma
