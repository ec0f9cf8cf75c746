// Numbers that decide on the way of a path: in (0, 1), and even over the samples of a unit.
#include <gtest/gtest.h>

#include "physics/sampling/path_points.h"
#include "physics/sampling/sobol.h"

namespace omma::test {
namespace {

TEST(PathPoints, AreNeverZeroOrOne) {
  for (const std::uint32_t bits : {0u, 0xffu, 0x1ffu, 0xfffffe00u, 0xffffff00u, 0xffffffffu}) {
    EXPECT_GT(open_unit(bits), 0.0f) << bits;
    EXPECT_LT(open_unit(bits), 1.0f) << bits;
  }
}

TEST(PathPoints, SobolOfReversedBitsIsSobol) {
  for (std::uint32_t i = 0; i < 10000; ++i) {
    EXPECT_EQ(reverse_bits(i), sobol_0(i));
    EXPECT_EQ(sobol_1_of_reversed(reverse_bits(i)), sobol_1(i));
  }
}

// 64 samples of a unit lie one in each of 8 x 8 cells, whatever the choice: Owen-scrambled Sobol
// points in any order are such a net.
TEST(PathPoints, FillEveryCellOnce) {
  for (std::uint32_t choice = 0; choice < 20; ++choice) {
    int in_cell[64] = {};
    for (std::uint32_t sample = 0; sample < 64; ++sample) {
      const auto p = path_pair<std::uint32_t>(12345u, sample, choice);
      ++in_cell[static_cast<int>(p.x * 8) * 8 + static_cast<int>(p.y * 8)];
    }
    for (const int count : in_cell) EXPECT_EQ(count, 1) << choice;
  }
}

}  // namespace
}  // namespace omma::test
