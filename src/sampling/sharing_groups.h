// Who may share rays with whom.
#pragma once

#include <cstdint>
#include <vector>

#include "omma/eye.h"

namespace omma {

// Ommatidia that may share: those of one eye, and of one cluster of nodal points, as some files
// hold both eyes of a head under one number. Clusters lie further apart than several facets.
// [group][member], indices in the eye; each ommatidium is in one group.
std::vector<std::vector<std::uint32_t>> sharing_groups(const Eye& eye);

}  // namespace omma
