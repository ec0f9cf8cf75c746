// Standard normals from uniform numbers.
#pragma once

#include "omma/vec.h"

namespace omma {

// Quantile of the standard normal, relative error below 1.15e-9 before and 1e-15 after one step of
// Halley's method: Acklam's rational approximation (P. J. Acklam 2003), refined.
OMMA_HD double normal_quantile(double u) {
  const double low = 0.02425;
  double x;
  if (u < low || u > 1 - low) {
    const double q = sqrt(-2 * log(u < low ? u : 1 - u));
    x = (((((-7.784894002430293e-03 * q - 3.223964580411365e-01) * q - 2.400758277161838e+00) * q -
           2.549732539343734e+00) *
              q +
          4.374664141464968e+00) *
             q +
         2.938163982698783e+00) /
        ((((7.784695709041462e-03 * q + 3.224671290700398e-01) * q + 2.445134137142996e+00) * q +
          3.754408661907416e+00) *
             q +
         1.0);
    if (u > 1 - low) x = -x;
  } else {
    const double q = u - 0.5, r = q * q;
    x = (((((-3.969683028665376e+01 * r + 2.209460984245205e+02) * r - 2.759285104469687e+02) * r +
           1.383577518672690e+02) *
              r -
          3.066479806614716e+01) *
             r +
         2.506628277459239e+00) *
        q /
        (((((-5.447609879822406e+01 * r + 1.615858368580409e+02) * r - 1.556989798598866e+02) * r +
           6.680131188771972e+01) *
              r -
          1.328068155288572e+01) *
             r +
         1.0);
  }
  const double e = 0.5 * erfc(-x * 0.70710678118654752) - u;
  const double step = e * 2.5066282746310005 * exp(0.5 * x * x);
  return x - step / (1 + 0.5 * x * step);
}

}  // namespace omma
