// Cells of baked light, and the numbers that are kept in them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "physics/path/baked.h"

namespace omma {
namespace {

TEST(Baked, NumbersKeepElevenBits) {
  EXPECT_EQ(decode_baked(encode_baked(0.0f)), 0.0f);
  EXPECT_EQ(encode_baked(0x1p-32f), 0);
  EXPECT_EQ(decode_baked(encode_baked(1.0f)), 1.0f);
  EXPECT_EQ(decode_baked(encode_baked(largest_baked)), largest_baked);
  EXPECT_EQ(decode_baked(encode_baked(5.0f)), decode_baked(0xffff));
  std::mt19937 random(1);
  std::uniform_real_distribution<float> exponent(-30.9f, 0.9f);
  for (int i = 0; i < 100000; ++i) {
    const float x = std::exp2(exponent(random));
    EXPECT_LE(std::fabs(decode_baked(encode_baked(x)) - x), 0x1p-12f * x);
  }
}

TEST(Baked, NumbersGrowAsTheirCodesDo) {
  for (std::uint32_t code = 2; code < 0x10000u; ++code)
    ASSERT_GT(decode_baked(static_cast<std::uint16_t>(code)),
              decode_baked(static_cast<std::uint16_t>(code - 1)));
}

// Whether a place lies in the triangle of the corners [corner][u, v], all of whose cells turn alike.
bool is_within(const float (&uv)[3][2], float u, float v) {
  const auto turn = [&](int a, int b) {
    const float du = uv[b][0] - uv[a][0], dv = uv[b][1] - uv[a][1];
    return du * (v - uv[a][1]) - dv * (u - uv[a][0]);
  };
  constexpr float rounding = 1e-6f;
  const float t[3] = {turn(0, 1), turn(1, 2), turn(2, 0)};
  return (t[0] >= -rounding && t[1] >= -rounding && t[2] >= -rounding) ||
         (t[0] <= rounding && t[1] <= rounding && t[2] <= rounding);
}

TEST(Baked, PlacesLieInTheirCells) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> part(0.0f, 1.0f);
  for (const std::int32_t k : {1, 2, 3, 7, 64, 1000}) {
    EXPECT_EQ(divisions_of(k * k), k);
    for (int i = 0; i < 20000; ++i) {
      float u = part(random), v = part(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const std::int32_t cell = cell_at(k, u, v);
      ASSERT_GE(cell, 0);
      ASSERT_LT(cell, k * k);
      float uv[3][2];
      corners_of_cell(k, cell, uv);
      ASSERT_TRUE(is_within(uv, u, v)) << k << ' ' << cell << ' ' << u << ' ' << v;
    }
  }
}

TEST(Baked, CellsCoverTheTriangleOnce) {
  constexpr std::int32_t k = 9;
  std::set<std::int32_t> found;
  for (std::int32_t cell = 0; cell < k * k; ++cell) {
    float uv[3][2], u = 0, v = 0;
    corners_of_cell(k, cell, uv);
    for (const auto& corner : uv) {
      u += corner[0] / 3;
      v += corner[1] / 3;
    }
    EXPECT_EQ(cell_at(k, u, v), cell);
    found.insert(cell_at(k, u, v));
  }
  EXPECT_EQ(found.size(), std::size_t{k * k});
  for (const auto& [u, v] : {std::pair{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}, {0.5f, 0.5f}}) {
    EXPECT_GE(cell_at(k, u, v), 0);
    EXPECT_LT(cell_at(k, u, v), k * k);
  }
}

}  // namespace
}  // namespace omma
