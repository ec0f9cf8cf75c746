// Eye for Python: read-only NumPy views of its arrays, made from a file or from arrays.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <functional>
#include <span>
#include <vector>

#include "arrays.h"
#include "eye_arguments.h"
#include "eye_html.h"
#include "model/text.h"
#include "omma/error.h"
#include "omma/eye.h"
#include "physics/sampling/hash.h"
#include "plausible.h"
#include "progress.h"
#include "struct_values.h"

namespace omma::python {

namespace {

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
  return "<omma.Eye " +
         (eye.path.empty() ? "in memory"
                           : "'" + readable_text(without_folder(eye.path, eye.path)) + "'") +
         ": " + std::to_string(eye.size()) + " ommatidia" +
         (eyes > 1 ? ", " + std::to_string(eyes) + " eyes" : "") + ">";
}

const float* floats(const std::vector<Vec3>& vectors) {
  return reinterpret_cast<const float*>(vectors.data());
}

using Self = nb::handle_t<Eye>;
const Eye& eye_of(Self self) {
  return nb::cast<const Eye&>(self);
}

nb::object int_view(Self self, const std::vector<std::int32_t>& values) {
  return view(self, values.data(), {values.size()});
}

nb::object length_view(Self self, const std::vector<float>& values) {
  return view(self, values.data(), {values.size()});
}

nb::dict columns_of(Self self) {
  nb::dict columns;
  for (const EyeColumn& column : eye_of(self).columns)
    columns[nb::cast(column.name)] =
        column.texts.empty() ? view(self, column.numbers.data(), {column.numbers.size()})
                             : nb::cast(column.texts);
  return columns;
}

nb::object right_of(const Eye& eye) {
  std::vector<float> right;
  right.reserve(3 * eye.size());
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const Vec3 r = to_float(normalize(cross(to_double(eye.axis[i]), to_double(eye.up[i]))));
    right.insert(right.end(), {r.x, r.y, r.z});
  }
  return take(std::move(right), {eye.size(), 3});
}

Eye take_rows(const Eye& eye, nb::handle ommatidia) {
  const nb::module_ numpy = nb::module_::import_("numpy");
  nb::object indices = PySlice_Check(ommatidia.ptr())
                           ? nb::object(numpy.attr("arange")(eye.size())[ommatidia])
                           : numpy.attr("asarray")(ommatidia);
  if (nb::cast<std::size_t>(indices.attr("size")) == 0)
    throw Error("ommatidia: expected at least one, found none");
  if (nb::cast<std::string>(indices.attr("dtype").attr("kind")) == "b") {
    const nb::object shape = indices.attr("shape");
    if (!shape.equal(nb::make_tuple(eye.size())))
      throw Error("ommatidia, a mask: expected shape (" + std::to_string(eye.size()) +
                  ",), found " + str_of(shape));
    indices = numpy.attr("flatnonzero")(indices);
  }
  const auto array = int_array(indices, "ommatidia", {-1});
  return take_ommatidia(eye, std::vector<std::int64_t>(array.data(), array.data() + array.size()));
}

std::size_t hash_of(const Eye& eye) {
  std::uint64_t hash = eye.size();
  for (const Vec3& axis : eye.axis)
    for (const float x : {axis.x, axis.y, axis.z}) hash = hash_combine(hash, std::hash<float>{}(x));
  return hash;
}

}  // namespace

void bind_eye(nb::module_& m) {
  nb::class_<Eye> eye(
      m, "Eye",
      "An eye, or all eyes of a head: N ommatidia, each with its own position, axis, "
      "acceptance.\n\n"
      "The frame is that of the head: right-handed, +X right, +Y up, looking along -Z. Read-only;\n"
      "the arrays are views, not copies; `replace` makes a changed copy.\n\n"
      "Parameters\n----------\n"
      "position_m : (N, 3), m. Nodal points.\n"
      "axis : (N, 3). Viewing directions; normalised.\n"
      "acceptance_angle_rad : (N,) or a number. Full width at half maximum, 0 to 2 pi, of round\n"
      "    Gaussians; may be left out where `acceptance` says more.\n"
      "focal_offset_m : (N,) or a number. How far behind the position rays start.\n"
      "eye_id : (N,) or a number. Which eye of the head an ommatidium belongs to.\n"
      "up : (N, 3). The reference across the axis for what is not round; by default upwards.\n"
      "facet_diameter_m : (N,) or a number; 0 where not known.\n"
      "aperture_diameter_m : (N,) or a number. Rays start all over a disc this wide, as in\n"
      "    superposition eyes.\n"
      "acceptance : an `Acceptance`, or a list of N; None stands for the round Gaussian.\n"
      "receptor_types : list of `ReceptorType`.\n"
      "receptors : indices into receptor_types, a list for all ommatidia or a list of N lists.\n"
      "columns : dict from names to (N,) numbers or N texts, kept but not used.\n"
      "path : the file it came from; eyes that differ in nothing else are equal.\n\n"
      "Raises `omma.Error` on a wrong shape, a zero axis, an acceptance out of range, a NaN; a\n"
      "`UserWarning` tells of numbers that no animal has, mostly slips of units.");
  const auto property = [&](const char* name, auto getter, const char* type, const char* doc) {
    const std::string signature = "def " + std::string(name) + "(self, /) -> " + type;
    eye.def_prop_ro(name, getter, nb::for_getter(nb::sig(signature.c_str())), doc);
  };
  constexpr const char* floats32 = "numpy.typing.NDArray[numpy.float32]";
  constexpr const char* ints32 = "numpy.typing.NDArray[numpy.int32]";
  eye.def(
         "__init__",
         [](Eye* self, nb::object position_m, nb::object axis, nb::object acceptance_angle_rad,
            nb::object focal_offset_m, nb::object eye_id, nb::kwargs others) {
           const bool own =
               others.contains("acceptance") && !nb::object(others["acceptance"]).is_none();
           if (acceptance_angle_rad.is_none() && !own)
             throw Error("Eye: expected acceptance_angle_rad or acceptance, found neither");
           others["position_m"] = position_m;
           others["axis"] = axis;
           if (!acceptance_angle_rad.is_none())
             others["acceptance_angle_rad"] = acceptance_angle_rad;
           others["focal_offset_m"] = focal_offset_m;
           others["eye_id"] = eye_id;
           Eye made;
           change_eye(made, others);
           warn_of_unusual(made);
           new (self) Eye(std::move(made));
         },
         required("position_m"), required("axis"), nb::arg("acceptance_angle_rad") = nb::none(),
         nb::arg("focal_offset_m") = 0.0, nb::arg("eye_id") = 0, nb::arg("others"),
         nb::sig("def __init__(self, position_m: numpy.typing.ArrayLike, axis: "
                 "numpy.typing.ArrayLike, acceptance_angle_rad: numpy.typing.ArrayLike | None = "
                 "None, focal_offset_m: numpy.typing.ArrayLike = 0.0, eye_id: "
                 "numpy.typing.ArrayLike = 0, *, up: numpy.typing.ArrayLike | None = None, "
                 "facet_diameter_m: numpy.typing.ArrayLike = 0.0, aperture_diameter_m: "
                 "numpy.typing.ArrayLike = 0.0, acceptance: Acceptance | "
                 "collections.abc.Sequence[Acceptance | None] | None = None, receptor_types: "
                 "collections.abc.Sequence[ReceptorType] | None = None, receptors: "
                 "collections.abc.Sequence[typing.Any] | None = None, columns: dict[str, "
                 "typing.Any] | None = None, path: str | os.PathLike[str] = '') -> None"))
      .def(
          "replace",
          [](const Eye& self, const nb::kwargs& changes) {
            Eye changed = self;
            change_eye(changed, changes);
            if (unusual_of(self).empty()) warn_of_unusual(changed);
            return changed;
          },
          nb::sig("def replace(self, **changes: typing.Any) -> Eye"),
          "A copy with these properties changed, named as for making an eye; all else is kept.\n\n"
          "acceptance_angle_rad alone makes all ommatidia round Gaussians. New axes without up\n"
          "have the up vectors of a new eye, unless others had been set: those are kept, across\n"
          "the new axes, and up=eye.up keeps them always. Raises `omma.Error` or `TypeError` as\n"
          "making an eye does.")
      .def_prop_ro(
          "path", [](const Eye& e) { return path_object(e.path); },
          nb::sig("def path(self, /) -> str"), "The file it came from, '' for one made in memory.");
  property(
      "position_m",
      [](Self self) {
        return view(self, floats(eye_of(self).position_m), {eye_of(self).size(), 3});
      },
      floats32, "Nodal points: (N, 3), m, head frame.");
  property(
      "axis",
      [](Self self) {
        return view(self, floats(eye_of(self).axis), {eye_of(self).size(), 3});
      },
      floats32, "Viewing directions: (N, 3), unit vectors, head frame.");
  property(
      "up",
      [](Self self) {
        return view(self, floats(eye_of(self).up), {eye_of(self).size(), 3});
      },
      floats32, "The reference for what is not round: (N, 3), unit vectors across the axes.");
  property("right", &right_of, floats32, "axis x up: (N, 3), unit vectors.");
  property(
      "acceptance_angle_rad",
      [](Self self) { return length_view(self, eye_of(self).acceptance_angle_rad); }, floats32,
      "Full width at half maximum of the angular sensitivity (its mean where not round): (N,), "
      "rad.");
  property(
      "focal_offset_m", [](Self self) { return length_view(self, eye_of(self).focal_offset_m); },
      floats32, "How far behind the position rays start: (N,), m.");
  property(
      "facet_diameter_m",
      [](Self self) { return length_view(self, eye_of(self).facet_diameter_m); }, floats32,
      "Facet diameters: (N,), m; 0 where not known.");
  property(
      "aperture_diameter_m",
      [](Self self) { return length_view(self, eye_of(self).aperture_diameter_m); }, floats32,
      "Discs on which rays start: (N,), m; 0: the position.");
  property(
      "eye_id", [](Self self) { return int_view(self, eye_of(self).eye_id); }, ints32,
      "Which eye of the head an ommatidium belongs to: (N,).");
  property(
      "acceptance_of", [](Self self) { return int_view(self, eye_of(self).acceptance_of); }, ints32,
      "Index into acceptances: (N,); -1: a round Gaussian of acceptance_angle_rad.");
  property(
      "first_receptor", [](Self self) { return int_view(self, eye_of(self).first_receptor); },
      ints32,
      "Receptors of ommatidium i are first_receptor[i] to first_receptor[i + 1]: (N + 1,).");
  property(
      "receptor_type", [](Self self) { return int_view(self, eye_of(self).receptor_type); }, ints32,
      "Index into receptor_types: (R,).");
  property("columns", &columns_of, "dict[str, typing.Any]",
           "Properties that Omma itself does not use, by name: (N,) float64, or N texts.");
  eye.def_ro("acceptances", &Eye::acceptances, nb::rv_policy::copy,
             "Angular sensitivities that are not a round Gaussian; see acceptance_of.")
      .def_ro("receptor_types", &Eye::receptor_types, nb::rv_policy::copy)
      .def(
          "acceptance",
          [](const Eye& self, std::int64_t ommatidium) {
            if (ommatidium < 0 || ommatidium >= static_cast<std::int64_t>(self.size()))
              throw Error("ommatidium: expected 0 to " + std::to_string(self.size() - 1) +
                          ", found " + std::to_string(ommatidium));
            return acceptance_at(self, static_cast<std::size_t>(ommatidium));
          },
          nb::arg("ommatidium"), "The angular sensitivity of one ommatidium.")
      .def("take", &take_rows, nb::arg("ommatidia"),
           nb::sig("def take(self, ommatidia: numpy.typing.ArrayLike | slice) -> Eye"),
           "The ommatidia with these indices, of this slice, or where this mask (N,) is true.")
      .def(
          "interommatidial_angle_rad",
          [](const Eye& self) {
            return take(run_long([&] { return interommatidial_angle_rad(self); }), {self.size()});
          },
          nb::sig("def interommatidial_angle_rad(self) -> numpy.typing.NDArray[numpy.float32]"),
          "Local interommatidial angle: the mean angle to the (up to) six nearest neighbours of\n"
          "the same eye. (N,), rad; 0 where there is no neighbour.")
      .def("select", &select_eye, nb::arg("eye_id"),
           "The ommatidia of one eye of a head.\n\nRaises `omma.Error` where there is no such eye.")
      .def("__len__", &Eye::size)
      .def("__repr__", [](const Eye& self) { return repr(self); })
      .def("_repr_html_", &eye_html, "What notebooks show: a map of the axes.");
  def_struct_value(
      eye, [](Eye& made) { run_long_work([&] { validate_eye(made); }); }, &hash_of);

  m.def("unusual_of", &unusual_of, nb::arg("eye"),
        "What of an eye is in no animal's range, a sentence for each array.");
  m.def(
      "merge_eyes", &merge, nb::arg("eyes"),
      nb::sig("def merge_eyes(eyes: collections.abc.Iterable[Eye | tuple[Eye, "
              "numpy.typing.ArrayLike]]) -> Eye"),
      "All eyes of a head as one; ``eye_id`` numbers them from 0 in the order given.\n\n"
      "Each item is an `Eye`, or a pair (eye, head_from_eye) with where it sits in the head as a\n"
      "(4, 4) transform, m.\n\n"
      "Raises `omma.Error` where an item is something else or a transform is not usable.");
}

}  // namespace omma::python
