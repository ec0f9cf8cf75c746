// The angular sensitivities an ommatidium can have; omma/acceptance.h has their parameters.
#pragma once

#include <cstdint>

namespace omma {

enum class Kernel : std::uint8_t {
  gaussian,      // exp(-4 ln2 (theta/width)^2) per unit solid angle, or elliptical
  pillbox,       // 1 within width/2, else 0
  compoundray,   // CompoundRay's: polar angle from a 1-D normal, so Gaussian/sin(theta)
  airy,          // diffraction at the facet alone: [2 J1(x)/x]^2, x = pi D sin(theta)/lambda
  lens_rhabdom,  // diffraction at the facet and what the rhabdom takes of it
  table,         // measured
};

}  // namespace omma
