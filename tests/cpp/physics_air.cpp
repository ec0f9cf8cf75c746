// exp(-x) as air has it, beside the C library's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "physics/path/air.h"

namespace omma::test {
namespace {

TEST(ExpMinus, IsWithinTwoUnitsInTheLastPlace) {
  double worst = 0;
  for (int i = 0; i <= 600'000; ++i) {
    const float x = greatest_depth * static_cast<float>(i) / 600'000.0f;
    const double exact = std::exp(-static_cast<double>(x));
    worst = std::max(worst, std::fabs(static_cast<double>(exp_minus(x)) / exact - 1));
  }
  EXPECT_LT(worst, 2 * 0x1p-23);
  EXPECT_EQ(exp_minus(0.0f), 1.0f);
}

}  // namespace
}  // namespace omma::test
