// Light from afar as the physics reads it, and how directions are sampled in it.
#pragma once

#include <vector>

#include "backend/light_data.h"

namespace omma {

// [weight + 1], cumulative probabilities in steps of 2^-24: those of random numbers of 24 bits, so
// that differences are exactly how often an interval is hit. Where a weight is above 0 a little is
// added, so that it is chosen at times; zeros where all are 0.
std::vector<float> running_sum(const std::vector<double>& weights);

// Fills in the sky and the discs; gives the flux from all directions, [band].
std::vector<double> make_far(LightData& data, const Light& light);

}  // namespace omma
