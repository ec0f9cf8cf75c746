// Structs of the engine as Python values: pickled, copied, compared. Each struct names its members
// once, in members_of, which does not compile where one was added and forgotten.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.h"
#include "omma/error.h"
#include "omma/eye.h"
#include "omma/rig.h"
#include "omma/world.h"

namespace omma::python {

// Of all pickles. To be raised where a function members_of below or an enumeration that one of
// these structs has is changed, so that pickles of another version are refused and not misread.
inline constexpr int pickle_format = 1;

template <typename Value, typename Struct>
concept Like = std::is_same_v<std::remove_const_t<Value>, Struct>;

// References to all members, but for the file that a value came from: two values that are the same
// are equal wherever they came from.

auto members_of(Like<SensitivityTable> auto& table) {
  auto& [path, right_rad, up_rad, sensitivity] = table;
  return std::tie(right_rad, up_rad, sensitivity);
}

auto members_of(Like<Acceptance> auto& acceptance) {
  auto& [kernel, width_rad, minor_width_rad, major_angle_rad, facet_diameter_m, wavelength_nm,
         model, focal_length_m, rhabdom_diameter_m, rhabdom_index, surround_index, table] =
      acceptance;
  return std::tie(kernel, width_rad, minor_width_rad, major_angle_rad, facet_diameter_m,
                  wavelength_nm, model, focal_length_m, rhabdom_diameter_m, rhabdom_index,
                  surround_index, table);
}

auto members_of(Like<ReceptorType> auto& type) {
  auto& [name, peak_wavelength_nm, wavelength_nm, sensitivity, microvillus_angle_rad,
         polarisation_sensitivity, absorption_per_m, length_m, right_rad, up_rad, acceptance] =
      type;
  return std::tie(name, peak_wavelength_nm, wavelength_nm, sensitivity, microvillus_angle_rad,
                  polarisation_sensitivity, absorption_per_m, length_m, right_rad, up_rad,
                  acceptance);
}

auto members_of(Like<EyeColumn> auto& column) {
  auto& [name, numbers, texts] = column;
  return std::tie(name, numbers, texts);
}

auto members_of(Like<Eye> auto& eye) {
  auto& [path, position_m, axis, acceptance_angle_rad, focal_offset_m, eye_id, up, facet_diameter_m,
         aperture_diameter_m, acceptances, acceptance_of, receptor_types, first_receptor,
         receptor_type, columns] = eye;
  return std::tie(position_m, axis, acceptance_angle_rad, focal_offset_m, eye_id, up,
                  facet_diameter_m, aperture_diameter_m, acceptances, acceptance_of, receptor_types,
                  first_receptor, receptor_type, columns);
}

auto members_of(Like<WorldInstance> auto& instance) {
  auto& [name, world_from_node] = instance;
  return std::tie(name, world_from_node);
}

auto members_of(Like<RigNode> auto& node) {
  auto& [name, parent, file_node, camera, has_matrix, matrix, translation_m, rotation, scale,
         weights] = node;
  return std::tie(name, parent, file_node, camera, has_matrix, matrix, translation_m, rotation,
                  scale, weights);
}

auto members_of(Like<AnimationChannel> auto& channel) {
  auto& [node, part, interpolation, times_s, values] = channel;
  return std::tie(node, part, interpolation, times_s, values);
}

auto members_of(Like<Animation> auto& animation) {
  auto& [name, duration_s, channels] = animation;
  return std::tie(name, duration_s, channels);
}

auto members_of(Like<Skin> auto& skin) {
  auto& [name, joints, joint_from_mesh] = skin;
  return std::tie(name, joints, joint_from_mesh);
}

auto members_of(Like<MorphTarget> auto& target) {
  auto& [positions, normals] = target;
  return std::tie(positions, normals);
}

auto members_of(Like<Deformation> auto& deformation) {
  auto& [mesh, positions, normals, node, targets, skin, influences, joints, weights,
         mesh_from_world] = deformation;
  return std::tie(mesh, positions, normals, node, targets, skin, influences, joints, weights,
                  mesh_from_world);
}

auto members_of(Like<Rig> auto& rig) {
  auto& [nodes, skins, deformations, animations] = rig;
  return std::tie(nodes, skins, deformations, animations);
}

template <typename T>
concept HasMembers = requires(T& value) {
  members_of(value);
};

template <typename T>
concept HasPath = requires(T& value) {
  value.path;
};

// What pickle is given: tuples, lists, arrays, numbers and, as names need not be UTF-8, bytes.
struct ToState {
  template <typename T>
  static nb::object of(const T& value) {
    if constexpr (HasMembers<const T>) {
      return std::apply(
          [&](const auto&... fields) -> nb::object {
            if constexpr (HasPath<const T>)
              return nb::make_tuple(of(value.path), of(fields)...);
            else
              return nb::make_tuple(of(fields)...);
          },
          members_of(value));
    } else if constexpr (std::is_enum_v<T>) {
      return nb::int_(static_cast<int>(value));
    } else {
      return nb::cast(value);
    }
  }

  static nb::object of(const std::string& text) { return nb::bytes(text.data(), text.size()); }

  static nb::object of(const Mat4& matrix) { return matrix_array(matrix); }

  template <typename T>
  static nb::object of(const std::vector<T>& values) {
    if constexpr (std::is_arithmetic_v<T>) {
      return take(std::vector<T>(values), {values.size()});
    } else if constexpr (std::is_same_v<T, Vec3>) {
      const auto* floats = reinterpret_cast<const float*>(values.data());
      return take(std::vector<float>(floats, floats + 3 * values.size()), {values.size(), 3});
    } else {
      nb::list list;
      for (const T& value : values) list.append(of(value));
      return list;
    }
  }

  template <typename T>
  static nb::object of(const std::optional<T>& value) {
    return value ? of(*value) : nb::none();
  }

  template <typename T>
  static nb::object of(const std::shared_ptr<const T>& value) {
    return value ? of(*value) : nb::none();
  }
};

// And back; nb::cast_error where a state is something else.
struct FromState {
  template <typename T>
  static void to(nb::handle state, T& value) {
    if constexpr (HasMembers<T>) {
      const auto items = nb::cast<nb::tuple>(state);
      constexpr std::size_t count = std::tuple_size_v<decltype(members_of(value))> + HasPath<T>;
      if (items.size() != count) throw nb::cast_error();
      std::size_t next = 0;
      if constexpr (HasPath<T>) to(items[next++], value.path);
      std::apply([&](auto&... fields) { (to(items[next++], fields), ...); }, members_of(value));
    } else if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(nb::cast<int>(state));
    } else {
      value = nb::cast<T>(state);
    }
  }

  static void to(nb::handle state, std::string& text) {
    const auto bytes = nb::cast<nb::bytes>(state);
    text.assign(bytes.c_str(), bytes.size());
  }

  static void to(nb::handle state, Mat4& matrix) { matrix = mat4(state, "matrix"); }

  template <typename T>
  static void to(nb::handle state, std::vector<T>& values) {
    if constexpr (std::is_arithmetic_v<T>) {
      const auto array =
          nb::cast<nb::ndarray<nb::numpy, const T, nb::ndim<1>, nb::c_contig>>(state);
      values.assign(array.data(), array.data() + array.size());
    } else if constexpr (std::is_same_v<T, Vec3>) {
      const auto array =
          nb::cast<nb::ndarray<nb::numpy, const float, nb::shape<-1, 3>, nb::c_contig>>(state);
      values.resize(array.shape(0));
      std::copy_n(array.data(), array.size(), reinterpret_cast<float*>(values.data()));
    } else {
      values.clear();
      for (nb::handle item : nb::cast<nb::list>(state)) to(item, values.emplace_back());
    }
  }

  template <typename T>
  static void to(nb::handle state, std::optional<T>& value) {
    value.reset();
    if (!state.is_none()) to(state, value.emplace());
  }

  template <typename T>
  static void to(nb::handle state, std::shared_ptr<const T>& value) {
    value.reset();
    if (state.is_none()) return;
    auto made = std::make_shared<T>();
    to(state, *made);
    value = std::move(made);
  }
};

// Equality, for which NaN is NaN: a number that is not known is the same wherever it is not known.
struct Same {
  template <typename T>
  static bool are(const T& a, const T& b) {
    if constexpr (HasMembers<const T>) {
      return std::apply(
          [&](const auto&... one) {
            return std::apply([&](const auto&... other) { return (are(one, other) && ...); },
                              members_of(b));
          },
          members_of(a));
    } else {
      return a == b;
    }
  }

  static bool are(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

  static bool are(const Vec3& a, const Vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

  static bool are(const Mat4& a, const Mat4& b) {
    return std::equal(&a.m[0][0], &a.m[0][0] + 16, &b.m[0][0]);
  }

  template <typename T>
  static bool are(const std::vector<T>& a, const std::vector<T>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const T& x, const T& y) { return are(x, y); });
  }

  template <typename T>
  static bool are(const std::optional<T>& a, const std::optional<T>& b) {
    return a && b ? are(*a, *b) : !a && !b;
  }

  template <typename T>
  static bool are(const std::shared_ptr<const T>& a, const std::shared_ptr<const T>& b) {
    return a == b || (a && b && are(*a, *b));
  }
};

// Makes a bound struct that is read-only a value: pickle, copy, == and a hash. `check` throws
// omma::Error where what was unpickled cannot be; `hash` gives the same for what is equal.
template <typename T, typename Check, typename Hash>
void def_struct_value(nb::class_<T>& type, const Check& check, const Hash& hash) {
  const std::string name = str_of(type.attr("__name__"));
  const std::string copy_signature = "def __copy__(self) -> " + name;
  const std::string deepcopy_signature = "def __deepcopy__(self, memo: object) -> " + name;
  type.def(
          "__getstate__",
          [](const T& value) { return nb::make_tuple(pickle_format, ToState::of(value)); },
          nb::sig("def __getstate__(self) -> tuple[typing.Any, ...]"))
      .def(
          "__setstate__",
          [check, name](T& value, const nb::tuple& state) {
            const std::string expected = "pickle of " + name + ": expected format " +
                                         std::to_string(pickle_format) + ", found ";
            if (state.size() != 2 || !nb::isinstance<nb::int_>(state[0]) ||
                nb::cast<int>(state[0]) != pickle_format)
              throw Error(expected + (state.size() > 0 ? str_of(state[0]) : "nothing") +
                          ": it is of another version of Omma");
            T made;
            try {
              FromState::to(state[1], made);
            } catch (const nb::cast_error&) {
              throw Error(expected + "what is none");
            }
            check(made);
            new (&value) T(std::move(made));
          },
          nb::sig("def __setstate__(self, state: tuple[typing.Any, ...]) -> None"))
      // Nothing can be changed, so a copy is the thing itself.
      .def(
          "__copy__", [](nb::handle_t<T> self) { return nb::borrow(self); },
          nb::sig(copy_signature.c_str()))
      .def(
          "__deepcopy__", [](nb::handle_t<T> self, nb::handle) { return nb::borrow(self); },
          nb::arg("memo"), nb::sig(deepcopy_signature.c_str()))
      .def(
          "__eq__",
          [](const T& value, nb::handle other) {
            return nb::isinstance<T>(other) && Same::are(value, nb::cast<const T&>(other));
          },
          nb::arg("other").none(), nb::sig("def __eq__(self, other: object) -> bool"))
      .def("__hash__", [hash](const T& value) -> std::size_t { return hash(value); });
}

}  // namespace omma::python
