// Whether a Light can be what it says.
#pragma once

#include <cstddef>

#include "omma/light.h"

namespace omma {

// Radiance at most, so that no sum leaves single precision: the sun's is 10^23 photons m^-2 s^-1
// sr^-1 nm^-1.
inline constexpr double most_radiance = 1e30;

// Nodes of a half of a sky map: what its tables for sampling count with 16 bits.
inline constexpr int most_sky_columns = 1 << 16, most_sky_rows = 1 << 15;

// Of air: no more is seen at a millimetre.
inline constexpr double most_extinction_per_m = 1000;

// Throws omma::Error naming the member. `materials`: of the scene that is lit.
void validate_light(const Light& light, std::size_t materials);

}  // namespace omma
