// Acceptances as keys of hash maps: an eye may have as many different ones as ommatidia.
#pragma once

#include <cstdint>
#include <functional>

#include "omma/acceptance.h"
#include "physics/sampling/hash.h"

namespace omma {

// Equal acceptances have equal hashes.
struct AcceptanceHash {
  std::size_t operator()(const Acceptance& a) const {
    std::uint64_t hash = static_cast<std::uint64_t>(a.kernel);
    for (const double value :
         {a.width_rad, a.minor_width_rad, a.major_angle_rad, a.facet_diameter_m, a.wavelength_nm,
          a.focal_length_m, a.rhabdom_diameter_m, a.rhabdom_index, a.surround_index})
      hash = hash_combine(hash, std::hash<double>{}(value));
    return hash;
  }
};

}  // namespace omma
