// What stands in for the standard library's conversions where it has none gives what that gives.
#include "io/decimal_chars.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>

namespace omma::test {
namespace {

template <typename T>
void expect_same_reading(const std::string& text) {
  const char *first = text.data(), *last = first + text.size();
  T expected = 7, found = 7;
  const auto e = std::from_chars(first, last, expected);
  const auto f = by_c_library::from_chars(first, last, found);
  EXPECT_EQ(f.ec, e.ec) << text;
  EXPECT_EQ(f.ptr, e.ptr) << text;
  if (std::isnan(expected)) {
    EXPECT_TRUE(std::isnan(found)) << text;
    return;
  }
  EXPECT_EQ(found, expected) << text;
  EXPECT_EQ(std::signbit(found), std::signbit(expected)) << text;
}

template <typename T>
std::string text_by(auto convert, T value) {
  std::array<char, 40> buffer{};
  const auto end = convert(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), end.ptr};
}

TEST(IoDecimalChars, ReadsAsTheStandardLibraryDoes) {
  for (const char* text : {"0",
                           "-0",
                           "1",
                           "1.5e3",
                           "-2.5E-3",
                           ".5",
                           "5.",
                           "+1",
                           " 1",
                           "1 ",
                           "",
                           "-",
                           ".",
                           "e5",
                           "1e",
                           "1e+",
                           "0x10",
                           "-0x1p3",
                           "inf",
                           "-inf",
                           "infinity",
                           "nan",
                           "-nan",
                           "abc",
                           "1,5",
                           "--1",
                           "1e400",
                           "-1e400",
                           "1e-400",
                           "4.9e-324",
                           "1e-310",
                           "3.4e39",
                           "1e-46",
                           "1e-40",
                           "1.7976931348623157e308",
                           "123456789012345678901234567890",
                           "0.1000000000000000055511151231257827"}) {
    expect_same_reading<double>(text);
    expect_same_reading<float>(text);
  }
}

TEST(IoDecimalChars, WritesAsTheStandardLibraryDoes) {
  std::mt19937_64 random(1);
  const auto scientific = [](char* first, char* last, auto value) {
    return by_c_library::to_chars(first, last, value, std::chars_format::scientific);
  };
  const auto expected = [](char* first, char* last, auto value) {
    return std::to_chars(first, last, value, std::chars_format::scientific);
  };
  const auto general = [](char* first, char* last, double value) {
    return by_c_library::to_chars(first, last, value, std::chars_format::general, 9);
  };
  const auto expected_general = [](char* first, char* last, double value) {
    return std::to_chars(first, last, value, std::chars_format::general, 9);
  };
  for (int i = 0; i < 2000; ++i) {
    const double value = std::ldexp(static_cast<double>(random()) - 9.2e18, i % 900 - 500);
    const auto narrow = static_cast<float>(std::ldexp(value, -63 - (i % 900 - 500) + i % 60));
    EXPECT_EQ(text_by(scientific, value), text_by(expected, value));
    EXPECT_EQ(text_by(scientific, narrow), text_by(expected, narrow));
    EXPECT_EQ(text_by(general, value), text_by(expected_general, value));
  }
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double value : {0.0, -0.0, 1.0, infinite, -infinite, 5e-324})
    EXPECT_EQ(text_by(scientific, value), text_by(expected, value));
}

}  // namespace
}  // namespace omma::test
