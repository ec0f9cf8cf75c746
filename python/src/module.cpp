// omma._core: the engine as Python sees it. The package's Python files put defaults, conversions
// and the command line around it.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "arrays.h"
#include "model/text.h"
#include "omma/error.h"
#include "progress.h"
#include "scene_parts.h"

namespace {

// What str() makes of an omma.Error that Python code raised: readable as those of the engine, and
// with the bytes of names that are not UTF-8.
std::string error_text(nanobind::handle error) {
  namespace nb = nanobind;
  const nb::object text = nb::handle(PyExc_RuntimeError).attr("__str__")(error);
  const nb::object bytes =
      nb::steal(PyUnicode_AsEncodedString(text.ptr(), "utf-8", "surrogateescape"));
  if (!bytes.is_valid()) {  // other lone surrogates than those that stand for bytes
    PyErr_Clear();
    return nb::cast<std::string>(nb::repr(text));
  }
  const auto encoded = nb::borrow<nb::bytes>(bytes);
  return omma::readable_text({encoded.c_str(), encoded.size()});
}

}  // namespace

NB_MODULE(_core, m) {
  namespace nb = nanobind;
  m.doc() = "The compiled engine behind the package `omma`; use it through `omma`.";
  m.attr("__version__") = OMMA_VERSION;
  // An exception that is still being reported when the interpreter ends keeps objects alive: no
  // reason to print about it.
  nb::set_leak_warnings(false);

  nb::exception<omma::Error> error(m, "Error", PyExc_RuntimeError);
  error.attr("__module__") = "omma";
  error.attr("__doc__") =
      "Anything wrong with an input: a file, an argument, a device.\n\n"
      "The message names the file or argument, the place in it, what was expected and what was "
      "found.";

  error.attr("__str__") = nb::cpp_function(&error_text, nb::is_method());

  omma::python::bind_files(m);
  omma::python::bind_background(m);
  omma::python::bind_camera(m);
  omma::python::bind_spectrum(m);
  omma::python::bind_image(m);
  omma::python::bind_texture(m);
  omma::python::bind_texture_use(m);
  omma::python::bind_material(m);
  omma::python::bind_mesh(m);
  omma::python::bind_instance(m);
  omma::python::bind_hit_box(m);
  omma::python::bind_splats(m);
  omma::python::bind_rig(m);
  omma::python::bind_punctual_light(m);
  omma::python::bind_scene(m);
  omma::python::bind_acceptance(m);
  omma::python::bind_light(m);
  omma::python::bind_baked_light(m);
  omma::python::bind_eye(m);
  omma::python::bind_eye_files(m);
  omma::python::bind_card(m);
  omma::python::bind_world(m);
  omma::python::bind_renderer(m);
  omma::python::bind_truth(m);
  omma::python::bind_projection(m);
  omma::python::bind_receptor(m);
  omma::python::end_work_at_exit();
}
