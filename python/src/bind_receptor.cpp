// Receptors for Python: what they are sensitive to, where they look, what they answer.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>

#include "arrays.h"
#include "omma/receptor_views.h"
#include "progress.h"

namespace omma::python {

namespace {

nb::object sensitivity(const ReceptorType& type, nb::handle wavelength_nm) {
  const auto nm = double_array(wavelength_nm, "wavelength_nm", {-1});
  std::vector<double> values(nm.size());
  eval_spectral_sensitivity(type, {nm.data(), nm.size()}, values);
  return take(std::move(values), {nm.size()});
}

nb::object bands(double peak_wavelength_nm, nb::handle wavelength_nm) {
  const auto nm = double_array(wavelength_nm, "wavelength_nm", {-1});
  std::vector<double> values(2 * nm.size());
  for (std::size_t i = 0; i < nm.size(); ++i) {
    values[i] = pigment_alpha_band(peak_wavelength_nm, nm.data()[i]);
    values[nm.size() + i] = pigment_beta_band(peak_wavelength_nm, nm.data()[i]);
  }
  return take(std::move(values), {2, nm.size()});
}

nb::object primaries(nb::handle wavelength_nm) {
  const auto nm = double_array(wavelength_nm, "wavelength_nm", {-1});
  std::vector<double> values;
  values.reserve(3 * nm.size());
  for (std::size_t i = 0; i < nm.size(); ++i)
    for (const double share : primary_spectra(nm.data()[i])) values.push_back(share);
  return take(std::move(values), {nm.size(), 3});
}

nb::object views(const Eye& eye) {
  ReceptorViews made = run_long([&] { return receptor_views(eye); });
  const std::size_t receptors = made.view_of_receptor.size();
  return nb::make_tuple(nb::cast(std::move(made.eye)),
                        take(std::move(made.view_of_receptor), {receptors}));
}

}  // namespace

void bind_receptor(nb::module_& m) {
  m.def("spectral_sensitivity", &sensitivity, nb::arg("type"), nb::arg("wavelength_nm"),
        nb::sig("def spectral_sensitivity(type: ReceptorType, wavelength_nm: "
                "numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]"));
  m.def("pigment_bands", &bands, nb::arg("peak_wavelength_nm"), nb::arg("wavelength_nm"),
        nb::sig("def pigment_bands(peak_wavelength_nm: float, wavelength_nm: "
                "numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]"));
  m.def("primary_spectra", &primaries, nb::arg("wavelength_nm"),
        nb::sig("def primary_spectra(wavelength_nm: numpy.typing.NDArray[numpy.float64]) -> "
                "numpy.typing.NDArray[numpy.float64]"));
  m.def("receptor_weights", &receptor_weights, nb::arg("type"), nb::arg("ultraviolet"),
        nb::sig("def receptor_weights(type: ReceptorType, ultraviolet: "
                "collections.abc.Sequence[float]) -> list[float]"));
  m.def("receptor_views", &views, nb::arg("eye"),
        nb::sig("def receptor_views(eye: Eye) -> tuple[Eye, numpy.typing.NDArray[numpy.int32]]"));
}

}  // namespace omma::python
