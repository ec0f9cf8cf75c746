// omma._core: the engine as Python sees it. The package's Python files put defaults, conversions
// and the command line around it.
#include <nanobind/nanobind.h>

#include "arrays.h"
#include "omma/error.h"

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

  omma::python::bind_camera(m);
  omma::python::bind_scene(m);
  omma::python::bind_acceptance(m);
  omma::python::bind_eye(m);
  omma::python::bind_eye_files(m);
  omma::python::bind_renderer(m);
  omma::python::bind_projection(m);
  omma::python::bind_receptor(m);
}
