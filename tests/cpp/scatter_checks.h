// What tests of scattering share: numbers that fill squares evenly, and a chi-square.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "omma/vec.h"

namespace omma::test {

// Two numbers in [0, 1) that fill the square, for index 0, 1, ...: steps of the plastic number.
inline Vec2 square_point(std::uint32_t index) {
  return {static_cast<float>((index * 3242174889u) >> 8) * 0x1p-24f,
          static_cast<float>((index * 2447445414u) >> 8) * 0x1p-24f};
}

// Chi-square over the value that is exceeded with probability 1e-5 (Wilson and Hilferty 1931).
// Cells that expect fewer than 10 are one.
inline double chi_square_ratio(const std::vector<double>& count,
                               const std::vector<double>& expected) {
  double sum = 0, rest_count = 0, rest = 0, freedom = -1;
  const auto add = [&](double seen, double wanted) {
    sum += (seen - wanted) * (seen - wanted) / wanted;
    ++freedom;
  };
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (expected[i] < 10)
      rest_count += count[i], rest += expected[i];
    else
      add(count[i], expected[i]);
  }
  if (rest > 5) add(rest_count, rest);
  constexpr double z = 4.265;
  return sum / (freedom * std::pow(1 - 2 / (9 * freedom) + z * std::sqrt(2 / (9 * freedom)), 3));
}

}  // namespace omma::test
