// Versions of arrays: who keeps copies of arrays in other memory, as a graphics card does, sees by
// them which have changed.
#pragma once

#include <cstdint>

namespace omma {

// Of the arrays of a view: as long as it is the same number, an array at the same address holds the
// same. No two contents have one number (model/new_version.h). 0: no copy is to be kept.
using Version = std::uint64_t;

}  // namespace omma
