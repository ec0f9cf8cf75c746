// Angular sensitivities and receptor types for Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <vector>

#include "arrays.h"
#include "omma/error.h"
#include "omma/receptor.h"
#include "optics/acceptance_hash.h"
#include "optics/lens_rhabdom.h"
#include "plausible.h"
#include "progress.h"
#include "struct_values.h"
#include "values.h"

namespace omma::python {
namespace {

constexpr const char* kernel_names[] = {"gaussian", "pillbox",      "compoundray",
                                        "airy",     "lens_rhabdom", "table"};
constexpr const char* model_names[] = {"waveguide", "geometric", "snyder"};

RhabdomModel model_of(const std::string& name) {
  for (std::size_t k = 0; k < std::size(model_names); ++k)
    if (name == model_names[k]) return static_cast<RhabdomModel>(k);
  throw Error("model: expected one of waveguide, geometric, snyder, found '" + name + "'");
}

// An ideal lens meets the sine condition, n sin(u) = D/(2f): no cone of light in matter of the index
// n is wider than sin(u) = 1, f = D/(2n). The largest index given is the one taken.
void expect_sine_condition(double facet_diameter_m, double focal_length_m, double index,
                           bool allow_unusual) {
  const double least = facet_diameter_m / (2 * index);
  if (allow_unusual || !(focal_length_m > 0) || !(focal_length_m < least)) return;
  char text[256];
  std::snprintf(text, sizeof text,
                "focal_length_m: expected at least %.4g m, the facet's diameter over twice the "
                "refractive index (%.4g), found %.4g m, an F-number of %.3g; if it is meant, say "
                "allow_unusual=True",
                least, index, focal_length_m, focal_length_m / facet_diameter_m);
  throw Error(text);
}

Acceptance checked(Acceptance acceptance) {
  run_long_work([&] { validate_acceptance(acceptance, "Acceptance"); });
  return acceptance;
}

std::vector<double> numbers(nb::handle values, const char* name) {
  const auto array = double_array(values, name, {-1});
  return {array.data(), array.data() + array.shape(0)};
}

Acceptance table(std::vector<double> right_rad, std::vector<double> up_rad,
                 std::vector<double> sensitivity, std::string path) {
  SensitivityTable table{std::move(path), std::move(right_rad), std::move(up_rad),
                         std::move(sensitivity)};
  // Relative to the largest; what is not a number is found by the check.
  double largest = 0;
  for (const double s : table.sensitivity) largest = std::max(largest, s);
  if (largest > 0)
    for (double& s : table.sensitivity) s /= largest;
  Acceptance acceptance;
  acceptance.kernel = Kernel::table;
  acceptance.table = std::make_shared<const SensitivityTable>(std::move(table));
  return checked(std::move(acceptance));
}

// What a receptor is, as far as it is known: what is 0 or as usual is left out.
std::string receptor_repr(const ReceptorType& a) {
  std::string text = "<omma.receptors.ReceptorType '" + a.name + "'";
  const auto add = [&](const char* pattern, auto... values) {
    char part[96];
    std::snprintf(part, sizeof part, pattern, values...);
    text += part;
  };
  if (a.peak_wavelength_nm > 0) add(", peak %g nm", a.peak_wavelength_nm);
  if (!a.wavelength_nm.empty())
    add(", table of %g to %g nm", a.wavelength_nm.front(), a.wavelength_nm.back());
  if (a.length_m > 0) add(", rhabdom %g um long", 1e6 * a.length_m);
  if (a.absorption_per_m > 0) add(", absorbing %g per um", 1e-6 * a.absorption_per_m);
  if (a.polarisation_sensitivity != 1)
    add(", polarisation sensitivity %g, microvilli at %g deg", a.polarisation_sensitivity,
        a.microvillus_angle_rad / degree);
  if (a.right_rad != 0 || a.up_rad != 0)
    add(", looks %.4g deg right and %.4g deg up", a.right_rad / degree, a.up_rad / degree);
  if (a.acceptance) text += ", an acceptance of its own";
  return text + ">";
}

void expect_width(const char* name, double width_rad, bool allow_unusual) {
  expect_plausible(Quantity::acceptance_angle, name, width_rad, allow_unusual);
}

void expect_facet(double facet_diameter_m, double wavelength_nm, bool allow_unusual) {
  expect_plausible(Quantity::facet_diameter, "facet_diameter_m", facet_diameter_m, allow_unusual);
  expect_plausible(Quantity::wavelength, "wavelength_nm", wavelength_nm, allow_unusual);
}

// A function of polar angles and azimuths, broadcast by NumPy.
template <typename Function>
nb::object at_angles(nb::handle first, const char* name, nb::handle azimuth_rad,
                     const Function& function) {
  const nb::module_ numpy = nb::module_::import_("numpy");
  const nb::object pair = numpy.attr("broadcast_arrays")(
      numpy.attr("asarray")(first, "float64"), numpy.attr("asarray")(azimuth_rad, "float64"));
  const nb::object shape = pair[0].attr("shape");
  const auto a = double_array(pair[0].attr("ravel")(), name, {-1});
  const auto b = double_array(pair[1].attr("ravel")(), "azimuth_rad", {-1});
  std::vector<double> values(a.shape(0));
  run_long_work([&] { function(a.data(), b.data(), values.data(), values.size()); });
  const std::size_t size = values.size();
  const nb::object flat = take(std::move(values), {size});
  return flat.attr("reshape")(shape)[nb::tuple()];
}

constexpr const char* of_angles =
    "(self, theta_rad: numpy.typing.ArrayLike, azimuth_rad: numpy.typing.ArrayLike = 0.0) -> "
    "typing.Any";

}  // namespace

void bind_acceptance(nb::module_& m) {
  nb::class_<Acceptance> acceptance_class(
      m, "Acceptance",
      "The angular sensitivity of an ommatidium: a kernel and its parameters.\n\n"
      "Made by one of its static methods. Directions are given by their polar angle from the axis\n"
      "and their azimuth, 0 towards the ommatidium's up vector and growing towards its right.\n"
      "Raises `omma.Error` on a parameter that is impossible, or out of the range of animals' "
      "eyes\n"
      "unless ``allow_unusual`` is said. Sources: docs/eyes.md.");
  acceptance_class
      .def_static(
          "gaussian",
          [](double width_rad, std::optional<double> minor_width_rad, double major_angle_rad,
             bool allow_unusual) {
            expect_width("width_rad", width_rad, allow_unusual);
            expect_width("minor_width_rad", minor_width_rad.value_or(0), allow_unusual);
            expect_plausible(Quantity::local_angle, "major_angle_rad", major_angle_rad,
                             allow_unusual);
            Acceptance a;
            a.width_rad = width_rad;
            a.minor_width_rad = minor_width_rad.value_or(0);
            a.major_angle_rad = major_angle_rad;
            return checked(a);
          },
          nb::arg("width_rad"), nb::arg("minor_width_rad") = nb::none(),
          nb::arg("major_angle_rad") = 0.0, nb::kw_only(), nb::arg("allow_unusual") = false,
          "A Gaussian per solid angle, round or elliptical: full widths at half maximum and the\n"
          "azimuth of the major axis.")
      .def_static(
          "pillbox",
          [](double width_rad, bool allow_unusual) {
            expect_width("width_rad", width_rad, allow_unusual);
            Acceptance a;
            a.kernel = Kernel::pillbox;
            a.width_rad = width_rad;
            return checked(a);
          },
          nb::arg("width_rad"), nb::kw_only(), nb::arg("allow_unusual") = false,
          "The same all over a disc of this diameter.")
      .def_static(
          "compoundray",
          [](double width_rad, bool allow_unusual) {
            expect_width("width_rad", width_rad, allow_unusual);
            Acceptance a;
            a.kernel = Kernel::compoundray;
            a.width_rad = width_rad;
            return checked(a);
          },
          nb::arg("width_rad"), nb::kw_only(), nb::arg("allow_unusual") = false,
          "CompoundRay's: the polar angle from a one-dimensional normal, for comparison.")
      .def_static(
          "airy",
          [](double facet_diameter_m, double wavelength_nm, bool allow_unusual) {
            expect_facet(facet_diameter_m, wavelength_nm, allow_unusual);
            Acceptance a;
            a.kernel = Kernel::airy;
            a.facet_diameter_m = facet_diameter_m;
            a.wavelength_nm = wavelength_nm;
            return checked(a);
          },
          nb::arg("facet_diameter_m"), nb::arg("wavelength_nm"), nb::kw_only(),
          nb::arg("allow_unusual") = false,
          "Diffraction at a round facet alone: [2 J1(x)/x]^2 with x = pi D sin(theta)/lambda.")
      .def_static(
          "lens_rhabdom",
          [](double facet_diameter_m, double focal_length_m, double rhabdom_diameter_m,
             double wavelength_nm, double rhabdom_index, double surround_index,
             const std::string& model, bool allow_unusual) {
            expect_facet(facet_diameter_m, wavelength_nm, allow_unusual);
            const auto expect = [&](Quantity quantity, const char* name, double value) {
              expect_plausible(quantity, name, value, allow_unusual);
            };
            expect(Quantity::focal_length, "focal_length_m", focal_length_m);
            expect(Quantity::rhabdom_diameter, "rhabdom_diameter_m", rhabdom_diameter_m);
            expect(Quantity::refractive_index, "rhabdom_index", rhabdom_index);
            expect(Quantity::refractive_index, "surround_index", surround_index);
            expect_sine_condition(facet_diameter_m, focal_length_m,
                                  std::max(rhabdom_index, surround_index), allow_unusual);
            Acceptance a;
            a.kernel = Kernel::lens_rhabdom;
            a.facet_diameter_m = facet_diameter_m;
            a.focal_length_m = focal_length_m;
            a.rhabdom_diameter_m = rhabdom_diameter_m;
            a.wavelength_nm = wavelength_nm;
            a.rhabdom_index = rhabdom_index;
            a.surround_index = surround_index;
            a.model = model_of(model);
            return checked(a);
          },
          nb::arg("facet_diameter_m"), nb::arg("focal_length_m"), nb::arg("rhabdom_diameter_m"),
          nb::arg("wavelength_nm"), nb::arg("rhabdom_index") = 1.363,
          nb::arg("surround_index") = 1.340, nb::arg("model") = "waveguide", nb::kw_only(),
          nb::arg("allow_unusual") = false,
          "Diffraction at the facet and what the rhabdom takes of it: \"waveguide\" (the modes it\n"
          "carries; Stavenga 2004), \"geometric\" (its disc) or \"snyder\" (a Gaussian).")
      .def_static(
          "table",
          [](nb::object angle_rad, nb::object sensitivity, nb::object path) {
            return table(numbers(angle_rad, "angle_rad"), {}, numbers(sensitivity, "sensitivity"),
                         path_text(path));
          },
          nb::arg("angle_rad"), nb::arg("sensitivity"), nb::arg("path") = "",
          nb::sig("def table(angle_rad: numpy.typing.ArrayLike, sensitivity: "
                  "numpy.typing.ArrayLike, path: str | os.PathLike[str] = '') -> Acceptance"),
          "A measured radial profile: polar angles (K,), ascending, rad, and sensitivities (K,);\n"
          "linear between, 0 beyond the last. Divided by the largest.")
      .def_static(
          "table_2d",
          [](nb::object right_rad, nb::object up_rad, nb::object sensitivity, nb::object path) {
            std::vector<double> right = numbers(right_rad, "right_rad");
            std::vector<double> up = numbers(up_rad, "up_rad");
            const auto values = double_array(
                sensitivity, "sensitivity",
                {static_cast<std::int64_t>(up.size()), static_cast<std::int64_t>(right.size())});
            if (up.empty()) throw Error("up_rad: expected at least two angles, found none");
            return table(std::move(right), std::move(up),
                         {values.data(), values.data() + values.size()}, path_text(path));
          },
          nb::arg("right_rad"), nb::arg("up_rad"), nb::arg("sensitivity"), nb::arg("path") = "",
          nb::sig("def table_2d(right_rad: numpy.typing.ArrayLike, up_rad: numpy.typing.ArrayLike, "
                  "sensitivity: numpy.typing.ArrayLike, path: str | os.PathLike[str] = '') -> "
                  "Acceptance"),
          "A measured map: angles to the right (C,) and up (R,), ascending, rad, and\n"
          "sensitivities (R, C); linear between, 0 outside. Divided by the largest.")
      .def_prop_ro("kernel",
                   [](const Acceptance& a) { return kernel_names[static_cast<int>(a.kernel)]; })
      .def_prop_ro("model",
                   [](const Acceptance& a) { return model_names[static_cast<int>(a.model)]; })
      .def_ro("width_parameter_rad", &Acceptance::width_rad,
              "Full width at half maximum that a gaussian (major axis), pillbox or compoundray was "
              "made with.")
      .def_ro("minor_width_rad", &Acceptance::minor_width_rad)
      .def_ro("major_angle_rad", &Acceptance::major_angle_rad)
      .def_ro("facet_diameter_m", &Acceptance::facet_diameter_m)
      .def_ro("wavelength_nm", &Acceptance::wavelength_nm)
      .def_ro("focal_length_m", &Acceptance::focal_length_m)
      .def_ro("rhabdom_diameter_m", &Acceptance::rhabdom_diameter_m)
      .def_ro("rhabdom_index", &Acceptance::rhabdom_index)
      .def_ro("surround_index", &Acceptance::surround_index)
      .def_prop_ro(
          "table_right_rad",
          [](const Acceptance& a) { return a.table ? a.table->right_rad : std::vector<double>{}; },
          "Of a table: angles to the right, or the polar angles of a radial profile, rad.")
      .def_prop_ro(
          "table_up_rad",
          [](const Acceptance& a) { return a.table ? a.table->up_rad : std::vector<double>{}; },
          "Of a two-dimensional table: angles up, rad.")
      .def_prop_ro(
          "table_sensitivity",
          [](const Acceptance& a) {
            return a.table ? a.table->sensitivity : std::vector<double>{};
          },
          "Of a table: sensitivities, row by row.")
      .def_prop_ro("is_round", &is_round, "Whether it depends on the polar angle alone.")
      .def_prop_ro(
          "mean_width_rad",
          [](const Acceptance& a) {
            return run_long([&] { return mean_acceptance_width_rad(a); });
          },
          "Full width at half maximum; the geometric mean of the widest and the narrowest "
          "where not round.")
      .def_prop_ro(
          "coupling_efficiency",
          [](const Acceptance& a) { return run_long([&] { return coupling_efficiency(a); }); },
          "Of a distant point's light that the facet lets in, the share that is inside the rhabdom\n"
          "where S is 1: of `lens_rhabdom` by its modes or, 'geometric', the Airy pattern within\n"
          "the tip. 1 of all others, whose S says nothing absolute.")
      .def(
          "width_rad",
          [](const Acceptance& a, double azimuth_rad) {
            return run_long([&] { return acceptance_width_rad(a, azimuth_rad); });
          },
          nb::arg("azimuth_rad") = 0.0,
          "Full width at half maximum through the axis along an azimuth.")
      .def(
          "eval",
          [](const Acceptance& a, nb::object theta_rad, nb::object azimuth_rad) {
            return at_angles(theta_rad, "theta_rad", azimuth_rad,
                             [&](const double* t, const double* f, double* out, std::size_t n) {
                               eval_acceptance(a, {t, n}, {f, n}, {out, n});
                             });
          },
          nb::arg("theta_rad"), nb::arg("azimuth_rad") = 0.0,
          nb::sig((std::string("def eval") + of_angles).c_str()),
          "Relative sensitivity in directions, 1 at its largest; arrays are broadcast.\n"
          "compoundray's is infinite at the axis and not normalised.")
      .def(
          "pdf",
          [](const Acceptance& a, nb::object theta_rad, nb::object azimuth_rad) {
            return at_angles(theta_rad, "theta_rad", azimuth_rad,
                             [&](const double* t, const double* f, double* out, std::size_t n) {
                               acceptance_pdf(a, {t, n}, {f, n}, {out, n});
                             });
          },
          nb::arg("theta_rad"), nb::arg("azimuth_rad") = 0.0,
          nb::sig((std::string("def pdf") + of_angles).c_str()),
          "Density of `sample` per steradian; arrays are broadcast.")
      .def(
          "mtf",
          [](const Acceptance& a, nb::object cycles_per_rad, nb::object azimuth_rad) {
            return at_angles(cycles_per_rad, "cycles_per_rad", azimuth_rad,
                             [&](const double* t, const double* f, double* out, std::size_t n) {
                               acceptance_mtf(a, {t, n}, {f, n}, {out, n});
                             });
          },
          nb::arg("cycles_per_rad"), nb::arg("azimuth_rad") = 0.0,
          nb::sig("def mtf(self, cycles_per_rad: numpy.typing.ArrayLike, azimuth_rad: "
                  "numpy.typing.ArrayLike = 0.0) -> typing.Any"),
          "Modulation transfer for sine gratings that vary along an azimuth; arrays are "
          "broadcast.")
      .def(
          "sample",
          [](const Acceptance& a, int count, std::uint64_t seed) {
            const std::vector<Vec3> directions =
                run_long([&] { return sample_acceptance(a, count, seed); });
            std::vector<float> values;
            for (const Vec3& d : directions) values.insert(values.end(), {d.x, d.y, d.z});
            return take(std::move(values), {directions.size(), 3});
          },
          nb::arg("count"), nb::arg("seed") = 0,
          nb::sig("def sample(self, count: int, seed: int = 0) -> "
                  "numpy.typing.NDArray[numpy.float32]"),
          "Directions drawn in proportion to the sensitivity: (count, 3), with x towards up, y\n"
          "towards the right and z along the axis.")
      .def("__repr__", [](const Acceptance& a) {
        return "<omma.Acceptance " + std::string(kernel_names[static_cast<int>(a.kernel)]) + ", " +
               std::to_string(mean_acceptance_width_rad(a) / degree) + " deg>";
      });
  def_struct_value(
      acceptance_class, [](const Acceptance& a) { checked(a); }, AcceptanceHash{});

  nb::class_<ReceptorType> receptor_class(
      m, "ReceptorType",
      "What a kind of photoreceptor is sensitive to.\n\n"
      "Parameters\n----------\n"
      "name : e.g. \"green\".\n"
      "peak_wavelength_nm : of its visual pigment (template of Govardovskii et al. 2000).\n"
      "wavelength_nm, sensitivity : (K,) instead: a table, linear between, 0 outside; divided by\n"
      "    the largest.\n"
      "microvillus_angle_rad : from the ommatidium's up vector towards its right.\n"
      "polarisation_sensitivity : PS, at least 1.\n"
      "absorption_per_m, length_m : of the rhabdom; 0 where not known.\n"
      "right_rad, up_rad : where it looks, from the ommatidium's axis.\n"
      "acceptance : its own `Acceptance`; None: the ommatidium's.\n"
      "allow_unusual : numbers beyond those of animals' eyes are meant.\n\n"
      "Raises `omma.Error` on a parameter out of range.");
  receptor_class
      .def(
          "__init__",
          [](ReceptorType* self, nb::handle name, double peak_wavelength_nm,
             const nb::object& wavelength_nm, const nb::object& sensitivity,
             double microvillus_angle_rad, double polarisation_sensitivity, double absorption_per_m,
             double length_m, double right_rad, double up_rad,
             const std::optional<Acceptance>& acceptance, bool allow_unusual) {
            const auto expect = [&](Quantity quantity, const char* argument, double value) {
              expect_plausible(quantity, argument, value, allow_unusual);
            };
            expect(Quantity::local_angle, "microvillus_angle_rad", microvillus_angle_rad);
            expect(Quantity::polarisation_sensitivity, "polarisation_sensitivity",
                   polarisation_sensitivity);
            expect(Quantity::absorption, "absorption_per_m", absorption_per_m);
            expect(Quantity::rhabdom_length, "length_m", length_m);
            expect(Quantity::offset_angle, "right_rad", right_rad);
            expect(Quantity::offset_angle, "up_rad", up_rad);
            ReceptorType type;
            type.name = text_argument(name, "name");
            type.peak_wavelength_nm = peak_wavelength_nm;
            if (!wavelength_nm.is_none())
              type.wavelength_nm = numbers(wavelength_nm, "wavelength_nm");
            if (!sensitivity.is_none()) type.sensitivity = numbers(sensitivity, "sensitivity");
            double largest = 0;
            for (const double s : type.sensitivity) largest = std::max(largest, s);
            if (largest > 0)
              for (double& s : type.sensitivity) s /= largest;
            type.microvillus_angle_rad = microvillus_angle_rad;
            type.polarisation_sensitivity = polarisation_sensitivity;
            type.absorption_per_m = absorption_per_m;
            type.length_m = length_m;
            type.right_rad = right_rad;
            type.up_rad = up_rad;
            type.acceptance = acceptance;
            validate_receptor_type(type, "ReceptorType");
            new (self) ReceptorType(std::move(type));
          },
          required("name"), nb::kw_only(), nb::arg("peak_wavelength_nm") = 0.0,
          nb::arg("wavelength_nm") = nb::none(), nb::arg("sensitivity") = nb::none(),
          nb::arg("microvillus_angle_rad") = 0.0, nb::arg("polarisation_sensitivity") = 1.0,
          nb::arg("absorption_per_m") = 0.0, nb::arg("length_m") = 0.0, nb::arg("right_rad") = 0.0,
          nb::arg("up_rad") = 0.0, nb::arg("acceptance") = nb::none(),
          nb::arg("allow_unusual") = false,
          nb::sig("def __init__(self, name: str, *, peak_wavelength_nm: float = 0.0, "
                  "wavelength_nm: numpy.typing.ArrayLike | None = None, sensitivity: "
                  "numpy.typing.ArrayLike | None = None, microvillus_angle_rad: float = 0.0, "
                  "polarisation_sensitivity: float = 1.0, absorption_per_m: float = 0.0, "
                  "length_m: float = 0.0, right_rad: float = 0.0, up_rad: float = 0.0, "
                  "acceptance: Acceptance | None = None, allow_unusual: bool = False) -> None"))
      .def_ro("name", &ReceptorType::name)
      .def_ro("peak_wavelength_nm", &ReceptorType::peak_wavelength_nm)
      .def_ro("wavelength_nm", &ReceptorType::wavelength_nm)
      .def_ro("sensitivity", &ReceptorType::sensitivity)
      .def_ro("microvillus_angle_rad", &ReceptorType::microvillus_angle_rad)
      .def_ro("polarisation_sensitivity", &ReceptorType::polarisation_sensitivity)
      .def_ro("absorption_per_m", &ReceptorType::absorption_per_m)
      .def_ro("length_m", &ReceptorType::length_m)
      .def_ro("right_rad", &ReceptorType::right_rad)
      .def_ro("up_rad", &ReceptorType::up_rad)
      .def_ro("acceptance", &ReceptorType::acceptance)
      .def("__repr__", [](const ReceptorType& a) { return receptor_repr(a); });
  def_struct_value(
      receptor_class,
      [](const ReceptorType& type) { validate_receptor_type(type, "ReceptorType"); },
      [](const ReceptorType& type) { return std::hash<std::string>{}(type.name); });

  m.def(
      "expect_eye_radius",
      [](const char* name, double radius_m, bool allow_unusual) {
        expect_plausible(Quantity::eye_radius, name, radius_m, allow_unusual);
      },
      nb::arg("name"), nb::arg("radius_m"), nb::arg("allow_unusual"));
}

}  // namespace omma::python
