// Directions about a normal (the local z), as a surface sends out light that has lost its way in
// it: as many per solid angle as the cosine says.
#pragma once

#include "physics/sampling/random_direction.h"

namespace omma {

inline constexpr float inverse_pi = 0.318309886f;

// `u0`, `u1` in [0, 1): uniform in the disc below the hemisphere (Malley's method).
template <typename F>
OMMA_HD LocalDirection<F> sample_cosine(F u0, F u1) {
  const F radius = sqrt_lanes(u0);
  const SineCosine<F> a = sine_cosine((2.0f * u1 - 1.0f) * 3.14159265f);
  return {radius * a.cosine, radius * a.sine, sqrt_lanes(1.0f - u0)};
}

// Per sr.
template <typename F>
OMMA_HD F cosine_pdf(F cosine) {
  return keep(cosine > 0.0f, cosine * inverse_pi);
}

}  // namespace omma
