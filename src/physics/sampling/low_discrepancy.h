// Low-discrepancy directions around an axis: Owen-scrambled Sobol points through the warp of an
// acceptance. Tables of them are made on the host (sampling/directions); where tables would be too
// large they are made on the way, by the same steps.
#pragma once

#include "physics/sampling/acceptance_sampling.h"
#include "physics/sampling/normal_quantile.h"
#include "physics/sampling/sobol.h"

namespace omma {

// Two independent standard normals for sample `index` of the scrambled Sobol set; z is 0.
OMMA_HD Vec3d scrambled_normals(std::uint32_t index, std::uint64_t scramble) {
  const std::uint32_t bits_0 = owen_scramble(sobol_0(index), hash_combine(scramble, 0));
  const std::uint32_t bits_1 = owen_scramble(sobol_1(index), hash_combine(scramble, 1));
  return {normal_quantile(unit_interval(static_cast<std::uint64_t>(bits_0) << 32)),
          normal_quantile(unit_interval(static_cast<std::uint64_t>(bits_1) << 32)), 0};
}

// Direction `index` of the scramble with this hash; x up, y right, z along the axis.
OMMA_HD Vec3 low_discrepancy_direction(const AcceptanceWarpView& warp, std::uint32_t scramble_hash,
                                       int index) {
  const Vec3d p = scrambled_normals(static_cast<std::uint32_t>(index), mix_bits(scramble_hash));
  return to_float(sample_acceptance(warp, p.x, p.y));
}

}  // namespace omma
