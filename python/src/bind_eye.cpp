// Eye for Python: read-only NumPy views of its arrays, made from a file or from arrays.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <span>
#include <vector>

#include "arrays.h"
#include "omma/error.h"
#include "omma/eye.h"
#include "omma/io.h"

namespace omma::python {

namespace {

// A number for all ommatidia, or an array [ommatidium].
std::vector<float> per_ommatidium(nb::handle values, const char* name, std::int64_t count) {
  if (nb::isinstance<nb::float_>(values) || nb::isinstance<nb::int_>(values))
    return std::vector<float>(static_cast<std::size_t>(count), nb::cast<float>(values));
  const auto array = float_array(values, name, {count});
  return {array.data(), array.data() + count};
}

std::vector<Vec3> vectors(const InputArray<float>& array) {
  std::vector<Vec3> result(array.shape(0));
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = {array.data()[3 * i], array.data()[3 * i + 1], array.data()[3 * i + 2]};
  return result;
}

Eye make_eye(nb::handle position_m, nb::handle axis, nb::handle acceptance_angle_rad,
             nb::handle focal_offset_m, nb::handle eye_id) {
  Eye eye;
  eye.axis = vectors(float_array(axis, "axis", {-1, 3}));
  const auto count = static_cast<std::int64_t>(eye.axis.size());
  eye.position_m = vectors(float_array(position_m, "position_m", {count, 3}));
  eye.acceptance_angle_rad = per_ommatidium(acceptance_angle_rad, "acceptance_angle_rad", count);
  eye.focal_offset_m = per_ommatidium(focal_offset_m, "focal_offset_m", count);
  if (nb::isinstance<nb::int_>(eye_id)) {
    eye.eye_id.assign(eye.axis.size(), nb::cast<std::int32_t>(eye_id));
  } else {
    const auto ids = int_array(eye_id, "eye_id", {count});
    eye.eye_id.assign(ids.data(), ids.data() + count);
  }
  validate_eye(eye);
  return eye;
}

// Items are eyes, or (eye, head_from_eye) pairs.
Eye merge(nb::handle eyes) {
  std::vector<PlacedEye> placed;
  const std::string expected = "eyes: expected eyes or (eye, head_from_eye) pairs";
  if (nb::isinstance<Eye>(eyes) || !nb::hasattr(eyes, "__iter__"))
    throw Error(expected + " in a list, found " + type_name_of(eyes));
  for (nb::handle item : nb::iter(eyes)) {
    const bool pair = nb::isinstance<nb::sequence>(item) && nb::len(item) == 2;
    const nb::object eye = pair ? nb::object(item[0]) : nb::borrow(item);
    if (!nb::isinstance<Eye>(eye))
      throw Error(expected + ", item " + std::to_string(placed.size()) + " is " +
                  type_name_of(item));
    placed.push_back(
        {nb::cast<const Eye&>(eye), pair ? mat4(nb::object(item[1]), "head_from_eye") : Mat4{}});
  }
  if (placed.empty()) throw Error("eyes: expected at least one eye, found none");
  return merge_eyes(placed);
}

std::string repr(const Eye& eye) {
  const auto [low, high] = std::minmax_element(eye.eye_id.begin(), eye.eye_id.end());
  const int eyes = eye.size() == 0 ? 0 : *high - *low + 1;
  return "<omma.Eye " + (eye.path.empty() ? "in memory" : "'" + eye.path + "'") + ": " +
         std::to_string(eye.size()) + " ommatidia" +
         (eyes > 1 ? ", " + std::to_string(eyes) + " eyes" : "") + ">";
}

const float* floats(const std::vector<Vec3>& vectors) {
  return reinterpret_cast<const float*>(vectors.data());
}

using Self = nb::handle_t<Eye>;
const Eye& eye_of(Self self) {
  return nb::cast<const Eye&>(self);
}

}  // namespace

void bind_eye(nb::module_& m) {
  nb::class_<Eye>(
      m, "Eye",
      "An eye, or all eyes of a head: N ommatidia, each with its own position, axis, "
      "acceptance.\n\n"
      "The frame is that of the head: right-handed, +X right, +Y up, looking along -Z. Read-only;\n"
      "the arrays are views, not copies.\n\n"
      "Parameters\n----------\n"
      "position_m : (N, 3), m. Nodal points.\n"
      "axis : (N, 3). Viewing directions; normalised.\n"
      "acceptance_angle_rad : (N,) or a number. Full width at half maximum, 0 to 2 pi.\n"
      "focal_offset_m : (N,) or a number. How far behind the position rays start.\n"
      "eye_id : (N,) or a number. Which eye of the head an ommatidium belongs to.\n\n"
      "Raises `omma.Error` on a wrong shape, a zero axis, an acceptance out of range, a NaN.")
      .def(
          "__init__",
          [](Eye* self, nb::object position_m, nb::object axis, nb::object acceptance_angle_rad,
             nb::object focal_offset_m, nb::object eye_id) {
            new (self)
                Eye(make_eye(position_m, axis, acceptance_angle_rad, focal_offset_m, eye_id));
          },
          nb::arg("position_m"), nb::arg("axis"), nb::arg("acceptance_angle_rad"),
          nb::arg("focal_offset_m") = 0.0, nb::arg("eye_id") = 0,
          nb::sig("def __init__(self, position_m: numpy.typing.ArrayLike, axis: "
                  "numpy.typing.ArrayLike, acceptance_angle_rad: numpy.typing.ArrayLike, "
                  "focal_offset_m: numpy.typing.ArrayLike = 0.0, eye_id: numpy.typing.ArrayLike = "
                  "0) -> None"))
      .def_ro("path", &Eye::path, "The file it came from, '' for one made in memory.")
      .def_prop_ro(
          "position_m",
          [](Self self) {
            return view(self, floats(eye_of(self).position_m), {eye_of(self).size(), 3});
          },
          nb::for_getter(nb::sig("def position_m(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "Nodal points: (N, 3), m, head frame.")
      .def_prop_ro(
          "axis",
          [](Self self) {
            return view(self, floats(eye_of(self).axis), {eye_of(self).size(), 3});
          },
          nb::for_getter(nb::sig("def axis(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "Viewing directions: (N, 3), unit vectors, head frame.")
      .def_prop_ro(
          "acceptance_angle_rad",
          [](Self self) {
            return view(self, eye_of(self).acceptance_angle_rad.data(), {eye_of(self).size()});
          },
          nb::for_getter(
              nb::sig("def acceptance_angle_rad(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "Full width at half maximum of the angular sensitivity: (N,), rad.")
      .def_prop_ro(
          "focal_offset_m",
          [](Self self) {
            return view(self, eye_of(self).focal_offset_m.data(), {eye_of(self).size()});
          },
          nb::for_getter(
              nb::sig("def focal_offset_m(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "How far behind the position rays start: (N,), m.")
      .def_prop_ro(
          "eye_id",
          [](Self self) { return view(self, eye_of(self).eye_id.data(), {eye_of(self).size()}); },
          nb::for_getter(nb::sig("def eye_id(self, /) -> numpy.typing.NDArray[numpy.int32]")),
          "Which eye of the head an ommatidium belongs to: (N,).")
      .def(
          "interommatidial_angle_rad",
          [](const Eye& eye) { return take(interommatidial_angle_rad(eye), {eye.size()}); },
          nb::sig("def interommatidial_angle_rad(self) -> numpy.typing.NDArray[numpy.float32]"),
          "Local interommatidial angle: the mean angle to the (up to) six nearest neighbours of\n"
          "the same eye. (N,), rad; 0 where there is no neighbour.")
      .def("select", &select_eye, nb::arg("eye_id"),
           "The ommatidia of one eye of a head.\n\nRaises `omma.Error` where there is no such eye.")
      .def("__len__", &Eye::size)
      .def("__repr__", [](const Eye& eye) { return repr(eye); });

  m.def(
      "merge_eyes", &merge, nb::arg("eyes"),
      nb::sig("def merge_eyes(eyes: collections.abc.Iterable[Eye | tuple[Eye, "
              "numpy.typing.ArrayLike]]) -> Eye"),
      "All eyes of a head as one; ``eye_id`` numbers them from 0 in the order given.\n\n"
      "Each item is an `Eye`, or a pair (eye, head_from_eye) with where it sits in the head as a\n"
      "(4, 4) transform, m.\n\n"
      "Raises `omma.Error` where an item is something else or a transform is not usable.");
  m.def(
      "load_eye",
      [](nb::handle path, double metres_per_unit) {
        const std::string name = path_text(path);
        nb::gil_scoped_release release;
        return load_eye(name, metres_per_unit);
      },
      nb::arg("path"), nb::arg("metres_per_unit"),
      nb::sig("def load_eye(path: str | os.PathLike[str], metres_per_unit: float) -> Eye"));
  m.def(
      "save_eye",
      [](nb::handle path, const Eye& eye, double metres_per_unit) {
        save_eye(path_text(path), eye, metres_per_unit);
      },
      nb::arg("path"), nb::arg("eye"), nb::arg("metres_per_unit"),
      nb::sig("def save_eye(path: str | os.PathLike[str], eye: Eye, metres_per_unit: float) -> "
              "None"));
}

}  // namespace omma::python
