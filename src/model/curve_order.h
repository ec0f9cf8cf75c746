// An order of ommatidia along a space-filling curve of their axes, so that neighbours in memory
// look in neighbouring directions and their rays make coherent packets.
#pragma once

#include <cstdint>
#include <vector>

#include "omma/eye.h"

namespace omma {

// [ommatidium], a permutation of the indices; eye by eye.
std::vector<std::uint32_t> order_along_curve(const Eye& eye);

}  // namespace omma
