// BoundaryTable for Python: how a surface reflects by wavelength and angle.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <algorithm>

#include "model/scene_light.h"
#include "scene_parts.h"

namespace omma::python {

namespace {

BoundaryTable made_boundary(nb::handle wavelength_nm, nb::handle mueller) {
  const auto knots = double_array(wavelength_nm, "wavelength_nm", {-1});
  const auto values = float_array(mueller, "mueller", {-1, -1, 3});
  if (values.shape(0) != knots.size())
    throw Error("mueller: expected a table for each of " + std::to_string(knots.size()) +
                " wavelengths, found " + std::to_string(values.shape(0)));
  Material alone;
  alone.metallic = 1;
  BoundaryTable& made = alone.boundary;
  made.wavelength_nm.assign(knots.data(), knots.data() + knots.size());
  constexpr std::size_t most = 1'000'000;  // the check says how many there may be
  made.cosines = static_cast<int>(std::min(values.shape(1), most));
  made.mueller.assign(values.data(), values.data() + values.size());
  if (made.empty()) throw Error("wavelength_nm: expected 2 or more, found none");
  check_scattering(alone, "");
  return made;
}

}  // namespace

void bind_boundary_table(nb::module_& m) {
  using Self = nb::handle_t<BoundaryTable>;
  nb::class_<BoundaryTable> table(
      m, "BoundaryTable",
      "How a surface reflects by wavelength and angle, as stacks of thin films and metals do\n"
      "(`LayerStack` makes such tables).\n\n"
      "wavelength_nm: (W,), 2 to 10,000 from 100 to 5,000 nm, ascending.\n"
      "mueller: (W, C, 3), at C cosines of the angle of incidence, even from 0 to 1: with field\n"
      "amplitudes r_s and r_p across the plane of incidence and in it,\n"
      "a = (|r_s|² + |r_p|²) / 2, the reflectance of unpolarised light,\n"
      "b = (|r_s|² - |r_p|²) / 2 and c = Re(r_s r_p*), by which at normal incidence c = -a.\n"
      "Linear between, and beyond its wavelengths as at the last one.\n\n"
      "Raises `omma.Error`, which names the argument.");
  table
      .def(
          "__init__",
          [](BoundaryTable* self, nb::handle wavelength_nm, nb::handle mueller) {
            new (self) BoundaryTable(made_boundary(wavelength_nm, mueller));
          },
          required("wavelength_nm"), required("mueller"),
          nb::sig("def __init__(self, wavelength_nm: numpy.typing.ArrayLike, mueller: "
                  "numpy.typing.ArrayLike) -> None"))
      .def_prop_ro(
          "wavelength_nm",
          [](Self self) {
            const auto& knots = nb::cast<const BoundaryTable&>(self).wavelength_nm;
            return view(self, knots.data(), {knots.size()});
          },
          nb::for_getter(
              nb::sig("def wavelength_nm(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "(W,), nm, ascending; read-only.")
      .def_prop_ro(
          "mueller",
          [](Self self) {
            const auto& one = nb::cast<const BoundaryTable&>(self);
            return view(self, one.mueller.data(),
                        {one.wavelength_nm.size(), static_cast<std::size_t>(one.cosines), 3});
          },
          nb::for_getter(nb::sig("def mueller(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "(W, C, 3): a, b and c; read-only.")
      .def("__hash__",
           [](const BoundaryTable& one) {
             return hash_of("", one.mueller.size()) ^ std::hash<float>{}(one.mueller.back());
           })
      .def("__repr__", [](const BoundaryTable& one) {
        return "<omma.scene.BoundaryTable of " + counted(one.wavelength_nm.size(), "wavelengths") +
               " and " + counted(static_cast<std::size_t>(one.cosines), "cosines") + ">";
      });
  def_value(table, {"wavelength_nm", "mueller"});
}

BoundaryTable boundary_argument(nb::handle object, const char* name) {
  if (object.is_none()) return {};
  if (nb::isinstance<BoundaryTable>(object)) return nb::cast<const BoundaryTable&>(object);
  throw nb::type_error((std::string(name) +
                        ": expected omma.scene.BoundaryTable or None, found " +
                        type_name_of(object))
                           .c_str());
}

}  // namespace omma::python
