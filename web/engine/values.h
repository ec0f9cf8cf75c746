// What goes between JavaScript and the engine: arrays, which are copied, and errors, which arrive
// as Error with the message of omma::Error.
#pragma once

#include <emscripten/val.h>

#include <new>
#include <span>
#include <string>
#include <vector>

#include "omma/error.h"
#include "omma/vec.h"

namespace omma::web {

using emscripten::val;

[[noreturn]] void throw_to_javascript(const std::string& message);

// work(), whose exceptions become JavaScript's.
template <typename Work>
auto checked(const Work& work) {
  std::string message;
  try {
    return work();
  } catch (const std::bad_alloc&) {
    message = "expected memory for this, found none: a page has at most 4 GB";
  } catch (const std::exception& error) {
    message = error.what();
  }
  throw_to_javascript(message);
}

// A typed array of JavaScript's own with these numbers.
template <typename T>
val array_of(std::span<const T> numbers) {
  return val(emscripten::typed_memory_view(numbers.size(), numbers.data())).call<val>("slice");
}
template <typename T>
val array_of(const std::vector<T>& numbers) {
  return array_of(std::span<const T>(numbers));
}
template <typename T>
val list_of(const std::vector<T>& values) {
  val list = val::array();
  for (const T& value : values) list.call<void>("push", value);
  return list;
}
val array_of(const Mat4& matrix);                // [16], row by row
val array_of(const std::vector<Vec3>& vectors);  // [3 n]

// From 16 numbers, row by row; omma::Error where there are not as many.
Mat4 matrix_of(const val& numbers, const char* name);

// Whether a value is a number, a text and so on, as JavaScript's typeof says.
bool has_type(const val& value, const char* type);
// A value as a message shows it.
std::string text_of(const val& value);

}  // namespace omma::web
