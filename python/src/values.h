// What all parts of a scene have in Python: they are values. Two that hold the same are equal, a
// copy is the thing itself (nothing can change it), they pickle, and `replace` makes another one.
// And their arguments, checked, with messages that say which one, what was expected and what came.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "omma/error.h"
#include "omma/scene.h"

namespace omma::python {

// A TypeError where an argument that has to be given is None.
void expect_given(nb::handle object, const char* name, const char* expected);

// One argument each; TypeError where it is of another type, omma.Error where it is out of range.
int whole_argument(nb::handle object, const char* name, int low = 0);
int handle_argument(nb::handle object, const char* name);  // an index, or None, which is -1
double number_argument(nb::handle object, const char* name);
bool flag_argument(nb::handle object, const char* name);
std::string text_argument(nb::handle object, const char* name);
Vec2 vec2_argument(nb::handle object, const char* name);
nb::object index_or_none(int handle);

// [height][width][3 or 4] or [height][width], uint8 (sRGB) or float (linear), or the path of an
// image file.
Image image_argument(nb::handle source, const char* name);
// (H, W, 4) of an image that `owner` keeps alive.
nb::object pixels_view(nb::handle owner, const Image& image);

// [vertex] or [triangle], empty for None.
std::vector<Vec3> vectors_argument(nb::handle object, const char* name);
std::vector<Vec2> coordinates_argument(nb::handle object, const char* name);
std::vector<Vec4> colors_argument(nb::handle object, const char* name);  // (N, 3 or 4)
std::vector<std::array<std::uint32_t, 3>> triangles_argument(nb::handle object, const char* name);

// A view of [N] vectors of `components` numbers; None where there are none and that may be.
template <typename T, typename Vector>
nb::object vectors_view(nb::handle owner, const std::vector<Vector>& values, bool or_none = false) {
  if (values.empty() && or_none) return nb::none();
  return view(owner, reinterpret_cast<const T*>(values.data()),
              {values.size(), sizeof(Vector) / sizeof(T)});
}

// Words that stand for the values of an enumeration.
template <typename Enum, std::size_t count>
using Words = std::array<std::pair<const char*, Enum>, count>;

template <typename Enum, std::size_t count>
const char* word_of(const Words<Enum, count>& words, Enum value) {
  for (const auto& [word, meaning] : words)
    if (meaning == value) return word;
  return "";
}

template <typename Enum, std::size_t count>
Enum word_argument(const Words<Enum, count>& words, nb::handle object, const char* name) {
  const std::string given = text_argument(object, name);
  std::string known;
  for (const auto& [word, meaning] : words) {
    if (given == word) return meaning;
    known += std::string(known.empty() ? "" : ", ") + word;
  }
  throw Error(std::string(name) + ": expected one of " + known + ", found '" + given + "'");
}

// What is wrong with one part alone is said where it is made.
template <typename T>
T valid_alone(T part, std::vector<T> Scene::*list) {
  Scene alone;
  (alone.*list).push_back(std::move(part));
  validate_scene(alone);
  return std::move((alone.*list)[0]);
}

// The arguments that make an equal one, by keyword: what the properties of these names give.
nb::dict fields_of(nb::handle self, const std::vector<const char*>& fields);
// The same with others; a TypeError where there is no such argument.
nb::object replaced(nb::handle self, const std::vector<const char*>& fields,
                    const nb::kwargs& changes);
// What pickle is to call.
nb::object reduced(nb::handle self, const std::vector<const char*>& fields);

// A signature of the type itself, kept as long as the module.
template <typename T>
nb::sig own_signature(nb::class_<T>& type, const char* before_name) {
  static std::vector<std::unique_ptr<std::string>> kept;
  kept.push_back(std::make_unique<std::string>(before_name + str_of(type.attr("__name__"))));
  return nb::sig(kept.back()->c_str());
}

template <typename T>
void def_equality(nb::class_<T>& type) {
  type.def(
      "__eq__",
      [](const T& a, nb::handle other) {
        return nb::isinstance<T>(other) && a == nb::cast<const T&>(other);
      },
      nb::arg("other").none(), nb::sig("def __eq__(self, other: object) -> bool"));
  type.def(
      "__copy__", [](nb::handle self) { return nb::borrow(self); },
      own_signature(type, "def __copy__(self) -> "));
  type.def(
      "__deepcopy__", [](nb::handle self, nb::handle) { return nb::borrow(self); }, nb::arg("memo"),
      own_signature(type, "def __deepcopy__(self, memo: object) -> "));
}

// `fields` are keywords of the constructor and properties, both.
template <typename T>
void def_value(nb::class_<T>& type, std::vector<const char*> fields) {
  def_equality(type);
  type.def(
      "__reduce__", [fields](nb::handle self) { return reduced(self, fields); },
      nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"));
  type.def(
      "replace",
      [fields](nb::handle self, const nb::kwargs& changes) {
        return replaced(self, fields, changes);
      },
      own_signature(type, "def replace(self, **changes: typing.Any) -> "),
      "Another one that differs in what is given by keyword, as for making one.");
}

}  // namespace omma::python
