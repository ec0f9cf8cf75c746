// std::from_chars and std::to_chars of floating-point numbers, and the same by the C library where
// the standard one does not say that it has them (libc++). To be called as omma::, as arguments of
// the standard library's types would find its own as well.
#pragma once

#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <type_traits>

namespace omma {

// By the C library; its locale is to be "C", so that a point is a point.
namespace by_c_library {

template <typename T>
std::from_chars_result from_chars(const char* first, const char* last, T& value) {
  const std::string text(first, last);
  const char* digits = text.c_str() + (text.starts_with('-') ? 1 : 0);
  // What strtod reads besides: blanks, a plus sign, hexadecimal digits.
  const bool begins = std::isalnum(static_cast<unsigned char>(*digits)) != 0 || *digits == '.';
  if (!begins) return {first, std::errc::invalid_argument};
  if (digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X')) {
    value = *text.c_str() == '-' ? T(-0.0) : T(0);
    return {first + (digits + 1 - text.c_str()), std::errc{}};
  }
  char* end = nullptr;
  errno = 0;
  T found{};
  if constexpr (std::is_same_v<T, float>)
    found = std::strtof(text.c_str(), &end);
  else
    found = std::strtod(text.c_str(), &end);
  if (end == text.c_str()) return {first, std::errc::invalid_argument};
  const char* const stopped = first + (end - text.c_str());
  if (errno == ERANGE && (found == 0 || std::isinf(found)))
    return {stopped, std::errc::result_out_of_range};
  value = found;
  return {stopped, std::errc{}};
}

// `digits`: behind the point (scientific), or significant ones (general).
inline std::to_chars_result to_chars(char* first, char* last, double value,
                                     std::chars_format format, int digits) {
  char text[64];
  const char* const how = format == std::chars_format::scientific ? "%.*e" : "%.*g";
  const int size = std::snprintf(text, sizeof text, how, digits, value);
  if (size > last - first) return {last, std::errc::value_too_large};
  std::memcpy(first, text, static_cast<std::size_t>(size));
  return {first + size, std::errc{}};
}

// The fewest digits that read as the same number.
template <typename T>
std::to_chars_result to_chars(char* first, char* last, T value, std::chars_format format) {
  for (int digits = 0;; ++digits) {
    const std::to_chars_result written =
        by_c_library::to_chars(first, last, static_cast<double>(value), format, digits);
    T back{};
    if (written.ec != std::errc{} || digits == 17 ||
        (from_chars(first, written.ptr, back).ec == std::errc{} && back == value))
      return written;
  }
}

}  // namespace by_c_library

#if defined(__cpp_lib_to_chars)
using std::from_chars;
using std::to_chars;
#else
using by_c_library::from_chars;
using by_c_library::to_chars;
#endif

}  // namespace omma
