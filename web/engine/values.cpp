// Arrays and errors: see values.h.
#include "values.h"

#include <emscripten/val.h>

namespace omma::web {

void throw_to_javascript(const std::string& message) {
  val::global("Error").new_(message).throw_();
}

val array_of(const Mat4& matrix) {
  return array_of(std::span<const double>(&matrix.m[0][0], 16));
}

val array_of(const std::vector<Vec3>& vectors) {
  return array_of(std::span<const float>(&vectors.data()->x, 3 * vectors.size()));
}

Mat4 matrix_of(const val& numbers, const char* name) {
  const std::vector<double> found = emscripten::convertJSArrayToNumberVector<double>(numbers);
  if (found.size() != 16)
    throw Error(std::string(name) + ": expected 16 numbers, row by row, found " +
                std::to_string(found.size()));
  Mat4 matrix;
  for (std::size_t i = 0; i < 16; ++i) matrix.m[i / 4][i % 4] = found[i];
  return matrix;
}

bool has_type(const val& value, const char* type) {
  return value.typeOf().as<std::string>() == type;
}

std::string text_of(const val& value) {
  return val::global("String")(value).as<std::string>();
}

}  // namespace omma::web
