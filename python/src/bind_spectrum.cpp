// Spectrum for Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <cstdio>

#include "model/spectrum_check.h"
#include "scene_parts.h"

namespace omma::python {

void bind_spectrum(nb::module_& m) {
  using Self = nb::handle_t<Spectrum>;
  nb::class_<Spectrum> spectrum(
      m, "Spectrum",
      "Values at wavelengths, linear between: a reflectance, a transmittance, the power of a "
      "lamp.\n\n"
      "Two to 10,000 wavelengths from 100 to 5,000 nm, ascending, and as many values that are not\n"
      "negative.\n\n"
      "Raises `omma.Error`, which names the argument.");
  spectrum
      .def(
          "__init__",
          [](Spectrum* self, nb::handle wavelength_nm, nb::handle value) {
            const auto knots = double_array(wavelength_nm, "wavelength_nm", {-1});
            const auto values = double_array(value, "value", {-1});
            Spectrum made{{knots.data(), knots.data() + knots.size()},
                          {values.data(), values.data() + values.size()}};
            if (made.empty()) throw Error("wavelength_nm: expected 2 or more, found none");
            check_spectrum(made, "");
            new (self) Spectrum(std::move(made));
          },
          required("wavelength_nm"), required("value"),
          nb::sig("def __init__(self, wavelength_nm: numpy.typing.ArrayLike, value: "
                  "numpy.typing.ArrayLike) -> None"))
      .def_prop_ro(
          "wavelength_nm",
          [](Self self) {
            const auto& knots = nb::cast<const Spectrum&>(self).wavelength_nm;
            return view(self, knots.data(), {knots.size()});
          },
          nb::for_getter(
              nb::sig("def wavelength_nm(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "(K,), nm, ascending; read-only.")
      .def_prop_ro(
          "value",
          [](Self self) {
            const auto& values = nb::cast<const Spectrum&>(self).value;
            return view(self, values.data(), {values.size()});
          },
          nb::for_getter(nb::sig("def value(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "(K,); read-only.")
      .def("__hash__",
           [](const Spectrum& s) {
             return s.wavelength_nm.size() ^ std::hash<double>{}(s.value.front());
           })
      .def("__repr__", [](const Spectrum& s) {
        char text[96];
        std::snprintf(text, sizeof text, "<omma.light.Spectrum of %zu values from %g to %g nm>",
                      s.value.size(), s.wavelength_nm.front(), s.wavelength_nm.back());
        return std::string(text);
      });
  def_value(spectrum, {"wavelength_nm", "value"});
}

Spectrum spectrum_argument(nb::handle object, const char* name) {
  if (object.is_none()) return {};
  if (nb::isinstance<Spectrum>(object)) return nb::cast<const Spectrum&>(object);
  throw nb::type_error(
      (std::string(name) + ": expected omma.light.Spectrum or None, found " + type_name_of(object))
          .c_str());
}

nb::object spectrum_or_none(const Spectrum& spectrum) {
  return spectrum.empty() ? nb::none() : nb::cast(spectrum);
}

}  // namespace omma::python
