// The tables that random directions (physics/sampling/random_direction.h) are read from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "optics/acceptance_warp.h"
#include "physics/sampling/random_direction.h"

namespace omma {

// Fields as in PolarTablesView; the last three are empty where all warps are round.
struct PolarTables {
  int intervals = 0;
  std::vector<float> polar, azimuth;
  std::vector<std::int32_t> azimuth_begin, first_row;
};

PolarTables make_polar_tables(std::span<const AcceptanceWarp> warps);

PolarTablesView view(const PolarTables& tables);

}  // namespace omma
