// Light from afar as the physics reads it, and how directions are sampled in it.
#pragma once

#include <vector>

#include "backend/light_data.h"

namespace omma {

// Cumulative probabilities, [weight + 1], in multiples of 2^-24, the steps of random numbers of 24
// bits: differences are exactly the probabilities of intervals. A small share goes by `even` (where
// it is empty, evenly) to all with a weight above 0 (defensive sampling). All zero where all
// weights are.
std::vector<float> running_sum(const std::vector<double>& weights,
                               const std::vector<double>& even = {});

// Fills in the sky and the discs; gives the flux from all directions, [band].
std::vector<double> make_far(LightData& data, const Light& light);

}  // namespace omma
