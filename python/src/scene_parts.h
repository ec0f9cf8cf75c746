// What the bindings of a scene's parts share.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <functional>
#include <string>

#include "values.h"

namespace omma::python {

// How a part's text begins, and how many there are of something.
inline std::string named(const char* what, const std::string& name) {
  return std::string("<omma.scene.") + what + (name.empty() ? "" : " '" + name + "'");
}
inline std::string counted(std::size_t count, const char* what) {
  return std::to_string(count) + " " + what;
}

inline std::size_t hash_of(const std::string& name, std::size_t number) {
  return std::hash<std::string>{}(name) ^ number;
}

// A tuple of the components.
template <typename Vec>
nb::object numbers(const Vec& v) {
  const auto* values = reinterpret_cast<const float*>(&v);
  nb::list list;
  for (std::size_t i = 0; i < sizeof(Vec) / sizeof(float); ++i)
    list.append(static_cast<double>(values[i]));
  return nb::tuple(list);
}

// A TextureUse, an index or None, which is no texture; and back.
TextureUse texture_use_argument(nb::handle object, const char* name);
nb::object texture_use_or_none(const TextureUse& use);

// A Spectrum or None, which is an empty one; and back.
Spectrum spectrum_argument(nb::handle object, const char* name);
nb::object spectrum_or_none(const Spectrum& spectrum);

// A BoundaryTable or None, which is an empty one.
BoundaryTable boundary_argument(nb::handle object, const char* name);

void bind_boundary_table(nb::module_& m);
void bind_rig(nb::module_& m);

}  // namespace omma::python
