// Parts of scenes as values, and their arguments: see values.h.
#include "values.h"

#include <algorithm>
#include <climits>
#include <cmath>

#include "omma/io.h"
#include "progress.h"

namespace omma::python {

namespace {

[[noreturn]] void wrong_type(const char* name, const char* expected, nb::handle found) {
  const std::string message =
      std::string(name) + ": expected " + expected + ", found " + type_name_of(found);
  throw nb::type_error(message.c_str());
}

// What NumPy makes of it; rows of different lengths are not its error but ours.
nb::object as_array(nb::handle object, const char* name, const char* expected) {
  try {
    return nb::module_::import_("numpy").attr("asarray")(object);
  } catch (nb::python_error& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
    throw Error(std::string(name) + ": expected " + expected + ", found " + type_name_of(object));
  }
}

// [height][width][1, 3 or 4] to RGBA; `opaque` is the alpha of an image without one.
template <typename T, typename Array>
std::vector<T> to_rgba(const Array& pixels, std::size_t components, T opaque) {
  const std::size_t count = pixels.shape(0) * pixels.shape(1);
  std::vector<T> rgba(count * 4, opaque);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < std::max(components, std::size_t{3}); ++c)
      rgba[4 * i + c] = static_cast<T>(pixels.data()[components * i + (components == 1 ? 0 : c)]);
  return rgba;
}

// Vectors of as many numbers as the array is wide.
template <typename Vector>
std::vector<Vector> packed(nb::handle object, const char* name) {
  if (object.is_none()) return {};
  constexpr std::size_t width = sizeof(Vector) / sizeof(float);
  const auto array = float_array(object, name, {-1, static_cast<std::int64_t>(width)});
  std::vector<Vector> values(array.shape(0));
  std::copy_n(array.data(), array.size(), reinterpret_cast<float*>(values.data()));
  return values;
}

}  // namespace

void expect_given(nb::handle object, const char* name, const char* expected) {
  if (object.is_none())
    throw nb::type_error((std::string(name) + ": expected " + expected + ", found None").c_str());
}

int whole_argument(nb::handle object, const char* name, int low) {
  if (is_truth(object) || !PyIndex_Check(object.ptr())) wrong_type(name, "a whole number", object);
  const nb::object number = nb::steal(PyNumber_Index(object.ptr()));
  if (!number.is_valid()) nb::raise_python_error();
  int overflow = 0;
  const long long value = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
  if (overflow != 0 || value < low || value > INT_MAX)
    throw Error(std::string(name) + ": expected " + std::to_string(low) + " to " +
                std::to_string(INT_MAX) + ", found " + str_of(number).substr(0, 40));
  return static_cast<int>(value);
}

int handle_argument(nb::handle object, const char* name) {
  return object.is_none() ? -1 : whole_argument(object, name);
}

double number_argument(nb::handle object, const char* name) {
  if (is_truth(object) || PyUnicode_Check(object.ptr()) || !nb::hasattr(object, "__float__"))
    wrong_type(name, "a number", object);
  const double value = PyFloat_AsDouble(object.ptr());
  if (PyErr_Occurred()) {
    PyErr_Clear();
    wrong_type(name, "a number", object);
  }
  if (!std::isfinite(value)) throw Error(std::string(name) + ": expected a finite number");
  return value;
}

bool flag_argument(nb::handle object, const char* name) {
  if (!is_truth(object)) wrong_type(name, "True or False", object);
  return PyObject_IsTrue(object.ptr()) == 1;
}

std::string text_argument(nb::handle object, const char* name) {
  if (!nb::isinstance<nb::str>(object)) wrong_type(name, "a text", object);
  Py_ssize_t size = 0;
  const char* text = PyUnicode_AsUTF8AndSize(object.ptr(), &size);
  if (text == nullptr) {
    PyErr_Clear();
    throw Error(std::string(name) + ": expected a text that can be written as UTF-8");
  }
  return std::string(text, static_cast<std::size_t>(size));
}

Vec2 vec2_argument(nb::handle object, const char* name) {
  const auto values = float_array(object, name, {2});
  return {values.data()[0], values.data()[1]};
}

nb::object index_or_none(int handle) {
  return handle < 0 ? nb::none() : nb::object(nb::int_(handle));
}

Image image_argument(nb::handle source, const char* name) {
  Image image;
  if (nb::isinstance<nb::str>(source) || nb::hasattr(source, "__fspath__")) {
    const std::string path = path_text(source);
    run_with_progress(nb::none(), [&](const std::function<bool(double)>& report) {
      image = load_image(path, report);
    });
    return image;
  }
  expect_given(source, name, "a path or pixels");
  nb::object array = as_array(source, name, "a path or pixels");
  const auto kind = str_of(array.attr("dtype").attr("kind"));
  const bool bytes = str_of(array.attr("dtype")) == "uint8";
  const nb::tuple extents(array.attr("shape"));
  std::vector<std::int64_t> shape;
  for (nb::handle extent : extents) shape.push_back(nb::cast<std::int64_t>(extent));
  const bool is_picture =
      shape.size() == 2 || (shape.size() == 3 && (shape[2] == 1 || shape[2] == 3 || shape[2] == 4));
  const bool sized =
      is_picture && shape[0] > 0 && shape[1] > 0 && shape[0] <= 1 << 16 && shape[1] <= 1 << 16;
  if (!sized || !(bytes || kind == "f"))
    throw Error(std::string(name) +
                ": expected a path, or uint8 (sRGB) or float (linear) values of shape (height, "
                "width, 3 or 4) or, of greys, (height, width), found " +
                str_of(array.attr("dtype")) + " of shape " + str_of(array.attr("shape")));
  if (shape.size() == 2) {
    shape.push_back(1);
    array = array.attr("reshape")(shape[0], shape[1], 1);
  }
  image.name = name;
  image.height = static_cast<int>(shape[0]);
  image.width = static_cast<int>(shape[1]);
  const auto components = static_cast<std::size_t>(shape[2]);
  if (bytes) {
    const nb::object packed_pixels = nb::module_::import_("numpy").attr("ascontiguousarray")(array);
    image.rgba_srgb8 =
        to_rgba<std::uint8_t>(nb::cast<InputArray<std::uint8_t>>(packed_pixels), components, 255);
  } else {
    const auto values = float_array(array, name, {-1, -1, shape[2]});
    const float* begin = values.data();
    if (!std::all_of(begin, begin + values.size(), [](float v) { return std::isfinite(v); }))
      throw Error(std::string(name) + ": expected finite values");
    image.rgba_linear = to_rgba<float>(values, components, 1.0f);
  }
  return image;
}

nb::object pixels_view(nb::handle owner, const Image& image) {
  const auto height = static_cast<std::size_t>(image.height);
  const auto width = static_cast<std::size_t>(image.width);
  if (!image.rgba_srgb8.empty()) return view(owner, image.rgba_srgb8.data(), {height, width, 4});
  return view(owner, image.rgba_linear.data(), {height, width, 4});
}

std::vector<Vec3> vectors_argument(nb::handle object, const char* name) {
  return packed<Vec3>(object, name);
}

std::vector<Vec2> coordinates_argument(nb::handle object, const char* name) {
  return packed<Vec2>(object, name);
}

std::vector<Vec4> colors_argument(nb::handle object, const char* name) {
  if (object.is_none()) return {};
  const auto array = float_array(object, name, {-1, -1});
  const std::size_t width = array.shape(1);
  if (width != 3 && width != 4)
    throw Error(std::string(name) + ": expected numbers of shape (N, 3) or (N, 4), found (" +
                std::to_string(array.shape(0)) + ", " + std::to_string(width) + ")");
  std::vector<Vec4> colors;
  colors.reserve(array.shape(0));
  for (std::size_t i = 0; i < array.shape(0); ++i) {
    const float* c = array.data() + i * width;
    colors.push_back({c[0], c[1], c[2], width == 4 ? c[3] : 1.0f});
  }
  return colors;
}

std::vector<std::array<std::uint32_t, 3>> triangles_argument(nb::handle object, const char* name) {
  const nb::module_ numpy = nb::module_::import_("numpy");
  expect_given(object, name, "whole numbers of shape (N, 3)");
  const nb::object array = as_array(object, name, "whole numbers of shape (N, 3)");
  const std::string kind = str_of(array.attr("dtype").attr("kind"));
  const std::string found =
      str_of(array.attr("dtype")) + " of shape " + str_of(array.attr("shape"));
  const std::string expected = ": expected whole numbers of shape (N, 3), found ";
  const nb::tuple shape(array.attr("shape"));
  if ((kind != "i" && kind != "u") || shape.size() != 2 || nb::cast<std::int64_t>(shape[1]) != 3)
    throw Error(name + expected + found);
  const nb::object lowest = array.attr("min")(nb::arg("initial") = 0);
  const nb::object highest = array.attr("max")(nb::arg("initial") = 0);
  if (str_of(lowest)[0] == '-') throw Error(name + (": vertex " + str_of(lowest)) + " is negative");
  if (str_of(highest).size() > 10 || std::stoull(str_of(highest)) > UINT32_MAX)
    throw Error(name + (": vertex " + str_of(highest)) + " is more than 32 bits count");
  const auto packed_array =
      nb::cast<InputArray<std::uint32_t>>(numpy.attr("ascontiguousarray")(array, "uint32"));
  std::vector<std::array<std::uint32_t, 3>> triangles(packed_array.shape(0));
  std::copy_n(packed_array.data(), packed_array.size(),
              reinterpret_cast<std::uint32_t*>(triangles.data()));
  return triangles;
}

nb::dict fields_of(nb::handle self, const std::vector<const char*>& fields) {
  nb::dict arguments;
  for (const char* field : fields) arguments[field] = nb::getattr(self, field);
  return arguments;
}

nb::object replaced(nb::handle self, const std::vector<const char*>& fields,
                    const nb::kwargs& changes) {
  nb::dict arguments = fields_of(self, fields);
  for (const auto& [name, value] : changes) {
    if (!arguments.contains(name)) {
      std::string known;
      for (const char* field : fields) known += (known.empty() ? "" : ", ") + std::string(field);
      const std::string message =
          type_name_of(self) + ".replace: there is no '" + str_of(name) + "'; there are " + known;
      throw nb::type_error(message.c_str());
    }
    arguments[name] = value;
  }
  return self.type()(**arguments);
}

nb::object reduced(nb::handle self, const std::vector<const char*>& fields) {
  const nb::object make =
      nb::module_::import_("functools").attr("partial")(self.type(), **fields_of(self, fields));
  return nb::make_tuple(make, nb::tuple());
}

}  // namespace omma::python
