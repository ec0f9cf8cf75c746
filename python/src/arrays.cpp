// Conversion of arguments: see arrays.h.
#include "arrays.h"

#include <algorithm>
#include <type_traits>

#include "omma/error.h"

namespace omma::python {

namespace {

template <typename Extents>
std::string shape_text(const Extents& shape) {
  std::string text = "(";
  std::size_t count = 0;
  for (const std::int64_t extent : shape) {
    if (count++ > 0) text += ", ";
    text += extent < 0 ? "N" : std::to_string(extent);
  }
  return text + (count == 1 ? ",)" : ")");
}

template <typename T>
InputArray<T> to_array(nb::handle object, const char* name, const char* dtype,
                       std::initializer_list<std::int64_t> shape) {
  const std::string expected = std::string(name) + ": expected " +
                               (shape.size() == 0 ? "a number" : "numbers of shape ") +
                               (shape.size() == 0 ? "" : shape_text(shape));
  if (object.is_none()) throw Error(expected + ", found None");
  nb::object array;
  try {
    const nb::module_ numpy = nb::module_::import_("numpy");
    array = numpy.attr("asarray")(object, nb::arg("order") = "C");
    if (nb::cast<std::string>(array.attr("dtype").attr("kind")) == "b")
      throw Error(expected + ", found " + str_of(array.attr("dtype")) + " values");
    if (!nb::cast<bool>(numpy.attr("can_cast")(array.attr("dtype"), dtype, "same_kind")))
      throw Error(expected + ", found " + str_of(array.attr("dtype")) +
                  " values that do not convert to " + dtype);
    const nb::object given = array;
    array = numpy.attr("asarray")(array, dtype, "C");
    if (std::is_integral_v<T> && !nb::cast<bool>(numpy.attr("array_equal")(given, array)))
      throw Error(expected + ", found some beyond the range of " + dtype);
  } catch (nb::python_error& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
    throw Error(expected + ", found " + type_name_of(object));
  }
  const auto result = nb::cast<InputArray<T>>(array);
  std::vector<std::int64_t> found;
  for (std::size_t i = 0; i < result.ndim(); ++i)
    found.push_back(static_cast<std::int64_t>(result.shape(i)));
  const bool same =
      std::equal(shape.begin(), shape.end(), found.begin(), found.end(),
                 [](std::int64_t want, std::int64_t have) { return want < 0 || want == have; });
  if (!same) throw Error(expected + ", found shape " + shape_text(found));
  return result;
}

}  // namespace

InputArray<float> float_array(nb::handle object, const char* name,
                              std::initializer_list<std::int64_t> shape) {
  return to_array<float>(object, name, "float32", shape);
}

InputArray<double> double_array(nb::handle object, const char* name,
                                std::initializer_list<std::int64_t> shape) {
  return to_array<double>(object, name, "float64", shape);
}

InputArray<std::int32_t> int_array(nb::handle object, const char* name,
                                   std::initializer_list<std::int64_t> shape) {
  return to_array<std::int32_t>(object, name, "int32", shape);
}

bool is_truth(nb::handle object) {
  return PyBool_Check(object.ptr()) || type_name_of(object) == "bool_" ||
         type_name_of(object) == "bool";
}

Vec3d vec3d(nb::handle object, const char* name) {
  const auto values = double_array(object, name, {3});
  return {values.data()[0], values.data()[1], values.data()[2]};
}

Mat4 mat4(nb::handle object, const char* name) {
  const auto values = double_array(object, name, {4, 4});
  Mat4 matrix;
  std::copy_n(values.data(), 16, &matrix.m[0][0]);
  return matrix;
}

nb::object matrix_array(const Mat4& matrix) {
  return take(std::vector<double>(&matrix.m[0][0], &matrix.m[0][0] + 16), {4, 4});
}

std::string str_of(nb::handle object) {
  const auto string = nb::steal<nb::str>(PyObject_Str(object.ptr()));
  if (!string.is_valid()) nb::raise_python_error();
  // With its size, as a text may hold null characters.
  Py_ssize_t size = 0;
  if (const char* text = PyUnicode_AsUTF8AndSize(string.ptr(), &size))
    return {text, static_cast<std::size_t>(size)};
  PyErr_Clear();
  const auto escaped = nb::steal<nb::str>(PyObject_ASCII(string.ptr()));
  throw Error(std::string("expected text without lone surrogates, found ") + escaped.c_str());
}

std::string type_name_of(nb::handle object) {
  return str_of(object.type().attr("__name__"));
}

std::string path_text(nb::handle path) {
  const nb::bytes encoded(nb::module_::import_("os").attr("fsencode")(path));
  std::string text(encoded.c_str(), encoded.size());
  if (text.find('\0') != std::string::npos) throw Error("a path must not contain a null character");
  return text;
}

nb::object path_object(const std::string& path) {
  return nb::steal(
      PyUnicode_DecodeFSDefaultAndSize(path.data(), static_cast<Py_ssize_t>(path.size())));
}

}  // namespace omma::python
