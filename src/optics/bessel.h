// Modified Bessel functions: those of the C++ library or, where it has none (libc++), their
// integrals (DLMF 10.32.1 and 10.32.9) by the trapezoidal rule, which converges exponentially on
// them.
#pragma once

#include <cmath>

#include "omma/vec.h"

namespace omma {

// I0(x), 0 <= x <= 700: mean of exp(x cos t) over a turn. As many nodes as its width in t asks for.
inline double bessel_i0_integral(double x) {
  constexpr int nodes = 512;
  double sum = 0;
  for (int i = 0; i < nodes; ++i) sum += std::exp(x * std::cos(2 * pi * i / nodes));
  return sum / nodes;
}

// exp(w) K_order(w), w > 0: integral of exp(-w (cosh t - 1)) cosh(order t) from 0 on.
inline double scaled_bessel_k_integral(int order, double w) {
  constexpr int nodes = 256;
  const double last = std::acosh(1 + 800 / w), step = last / nodes;  // exp(-800) is 0
  double sum = 0.5;
  for (int i = 1; i <= nodes; ++i)
    sum += std::exp(-w * (std::cosh(i * step) - 1)) * std::cosh(order * i * step);
  return sum * step;
}

inline double bessel_i0(double x) {
#if defined(__cpp_lib_math_special_functions)
  return std::cyl_bessel_i(0.0, x);
#else
  return bessel_i0_integral(x);
#endif
}

// K1(w)/K0(w), w > 0.
inline double bessel_k1_over_k0(double w) {
#if defined(__cpp_lib_math_special_functions)
  return std::cyl_bessel_k(1.0, w) / std::cyl_bessel_k(0.0, w);
#else
  return scaled_bessel_k_integral(1, w) / scaled_bessel_k_integral(0, w);
#endif
}

}  // namespace omma
