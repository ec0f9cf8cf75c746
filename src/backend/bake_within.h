// What light varies by within a cell of baked light, which keeps one value of it.
#pragma once

#include <vector>

#include "backend/bake_groups.h"

namespace omma {

// [place in groups.side], the variance of light over a side of a cell as a fraction of the square
// of its light, in the mean over bands; of sides without neighbours in their group the median of
// others. `half` as of find_noise.
std::vector<float> find_within(const BakeGroups& groups, int bands,
                               const BakedLine* const (&half)[2]);

}  // namespace omma
