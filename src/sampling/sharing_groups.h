// Who may share rays with whom.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "omma/eye.h"

namespace omma {

// Ommatidia that may share: those of one eye, and of one cluster of nodal points, as some files
// hold both eyes of a head under one number. Clusters lie further apart than several facets.
// [group][member], indices in the eye; each ommatidium is in one group.
std::vector<std::vector<std::uint32_t>> sharing_groups(const Eye& eye);

// Largest ratio of widths within a class: a ray of the narrowest is worth little to the widest,
// which would weight the square of that ratio as many.
inline constexpr double most_width_ratio = 4;

// The members of a group by their width [ommatidium]: as few classes as that takes, each as wide on
// a logarithmic scale. Those of width 0 are in none.
std::vector<std::vector<std::uint32_t>> width_classes(std::span<const std::uint32_t> member,
                                                      std::span<const double> width);

}  // namespace omma
