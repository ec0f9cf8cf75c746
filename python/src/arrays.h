// NumPy arrays in and out, with messages that say which argument, what was expected and what came.
// Shared by all bindings; nothing here knows a type of Omma's but Vec3 and Mat4.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "omma/vec.h"

namespace omma::python {

namespace nb = nanobind;

template <typename T>
using InputArray = nb::ndarray<nb::numpy, const T, nb::c_contig, nb::device::cpu>;

// A C-contiguous array of the given shape (-1: any extent) from anything NumPy takes; `name` is
// that of the argument. Throws omma::Error naming it, the shape expected and the shape found.
InputArray<float> float_array(nb::handle object, const char* name,
                              std::initializer_list<std::int64_t> shape);
InputArray<double> double_array(nb::handle object, const char* name,
                                std::initializer_list<std::int64_t> shape);
InputArray<std::int32_t> int_array(nb::handle object, const char* name,
                                   std::initializer_list<std::int64_t> shape);

// An argument of a constructor that has to be given. nanobind takes it as None where it is missing,
// so that what reads it says its name; `nb::sig` says that there is no default.
inline auto required(const char* name) {
  return nb::arg(name) = nb::none();
}

Vec3d vec3d(nb::handle object, const char* name);
Mat4 mat4(nb::handle object, const char* name);
nb::object matrix_array(const Mat4& matrix);  // a (4, 4) float64 array of its own

// A read-only NumPy view of memory that `owner` keeps alive.
template <typename T>
nb::object view(nb::handle owner, const T* data, std::initializer_list<std::size_t> shape) {
  return nb::cast(nb::ndarray<nb::numpy, const T>(data, shape.size(), shape.begin(), owner),
                  nb::rv_policy::reference);
}

// A NumPy array that takes over a vector's memory.
template <typename T>
nb::object take(std::vector<T> values, std::initializer_list<std::size_t> shape) {
  auto* heap = new std::vector<T>(std::move(values));
  nb::capsule owner(heap, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(heap->data(), shape.size(), shape.begin(), owner),
                  nb::rv_policy::reference);
}

std::string str_of(nb::handle object);        // str(object)
bool is_truth(nb::handle object);             // True, False, or NumPy's
std::string type_name_of(nb::handle object);  // of the object's type

// os.fsencode(path), the bytes of a name, which need not be UTF-8; a TypeError where that is not a
// path. And back: what os.fsdecode makes of them.
std::string path_text(nb::handle path);
nb::object path_object(const std::string& path);

void bind_camera(nb::module_& m);
void bind_background(nb::module_& m);
void bind_scene(nb::module_& m);
void bind_spectrum(nb::module_& m);
void bind_image(nb::module_& m);
void bind_texture(nb::module_& m);
void bind_texture_use(nb::module_& m);
void bind_material(nb::module_& m);
void bind_mesh(nb::module_& m);
void bind_instance(nb::module_& m);
void bind_hit_box(nb::module_& m);
void bind_splats(nb::module_& m);
void bind_punctual_light(nb::module_& m);
void bind_acceptance(nb::module_& m);
void bind_light(nb::module_& m);
void bind_baked_light(nb::module_& m);
void bind_eye(nb::module_& m);
void bind_eye_files(nb::module_& m);
void bind_files(nb::module_& m);
void bind_renderer(nb::module_& m);
void bind_truth(nb::module_& m);
void bind_card(nb::module_& m);
void bind_projection(nb::module_& m);
void bind_receptor(nb::module_& m);
void bind_world(nb::module_& m);

}  // namespace omma::python
