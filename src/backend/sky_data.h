// Light from afar as the physics reads it, and how directions are sampled in it.
#pragma once

#include <vector>

#include "backend/light_data.h"

namespace omma {

// [weight + 1], cumulative probabilities in steps of 2^-24: those of random numbers of 24 bits, so
// that differences are exactly how often an interval is hit. A small part of the probability goes
// by `even` (where it is empty, evenly) to all whose weight is above 0, so that each is chosen at
// times. Zeros where all weights are.
std::vector<float> running_sum(const std::vector<double>& weights,
                               const std::vector<double>& even = {});

// Fills in the sky and the discs; gives the flux from all directions, [band].
std::vector<double> make_far(LightData& data, const Light& light);

}  // namespace omma
