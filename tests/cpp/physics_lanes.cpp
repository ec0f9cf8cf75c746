// What is done to lanes by shuffles and loads of neighbours, against the plain meaning.
#include "physics/lanes/rows.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <vector>

namespace omma::test {
namespace {

using L = Lanes<16, lane_width>;

TEST(Lanes, StoreSomePutsThemOneBehindTheOther) {
  std::array<float, lane_width> values;
  std::iota(values.begin(), values.end(), 1.0f);
  for (unsigned bits = 0; bits < 1u << lane_width; bits += 1 + bits / 7) {
    std::array<float, 2 * lane_width> out;
    out.fill(-1);
    store_some(out.data(), load<Floats>(values.data()), bits);
    int count = 0;
    for (int l = 0; l < lane_width; ++l) {
      if ((bits >> l & 1u) == 0) continue;
      EXPECT_EQ(out[static_cast<std::size_t>(count++)], static_cast<float>(l + 1)) << bits;
    }
    EXPECT_EQ(bits_in(bits), count);
    EXPECT_EQ(out[lane_width], -1) << "wrote further than a vector";
  }
}

TEST(Lanes, GatherOfThreeReadsThree) {
  std::vector<float> table(3 * 50);
  std::iota(table.begin(), table.end(), 0.0f);
  std::vector<std::int32_t> whole(table.begin(), table.end());
  Ints index;
  for (int l = 0; l < lane_width; ++l) index[l] = l == 0 ? 49 : (l * 37) % 50;  // the last one too
  Floats found[3];
  Ints found_whole[3];
  gather_3(table.data(), index, found);
  gather_3(whole.data(), index, found_whole);
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < lane_width; ++l) {
      EXPECT_EQ(found[k][l], static_cast<float>(3 * index[l] + k));
      EXPECT_EQ(found_whole[k][l], 3 * index[l] + k);
    }
}

TEST(Lanes, RowsBecomeLanes) {
  for (const int columns : {1, 3, lane_width, lane_width + 1, 3 * lane_width}) {
    std::vector<float> table(static_cast<std::size_t>(lane_width * columns));
    std::iota(table.begin(), table.end(), 1.0f);
    std::vector<std::uint16_t> codes(table.begin(), table.end());
    // Of the lanes that go at once some; bits of others do not count.
    const unsigned lanes = 0x35b6du;
    const auto expect = [&](const std::vector<float>& out) {
      for (int c = 0; c < columns; ++c)
        for (int l = 0; l < lane_width; ++l)
          EXPECT_EQ(out[static_cast<std::size_t>(c * L::count + l)],
                    (lanes >> l & 1u) != 0 ? static_cast<float>(l * columns + c + 1) : 0.0f)
              << columns << " columns, " << c << ", lane " << l;
    };
    std::vector<float> out(static_cast<std::size_t>(columns * L::count), -1.0f);
    store_rows<L>(
        columns, lanes, [&](int k, const auto& read) { return read(table.data() + k * columns); },
        out.data());
    expect(out);
    store_rows<L>(
        columns, lanes,
        [&](int k, const auto& read) { return to_float(read(codes.data() + k * columns)); },
        out.data());
    expect(out);
  }
}

}  // namespace
}  // namespace omma::test
