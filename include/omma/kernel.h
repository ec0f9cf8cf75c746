// The angular sensitivities an ommatidium can have. Formulas: src/kernel/acceptance.h.
#pragma once

#include <cstdint>

namespace omma {

// Angular sensitivity S(theta), with the acceptance angle as its parameter.
enum class Kernel : std::uint8_t {
  gaussian,     // exp(-4 ln2 (theta/acceptance)^2) per unit solid angle
  pillbox,      // 1 within acceptance/2, else 0
  compoundray,  // CompoundRay's: polar angle from a 1-D normal, so Gaussian/sin(theta)
};

}  // namespace omma
