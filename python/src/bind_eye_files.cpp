// Files of eyes for Python: read, written, and what a format would lose. Defaults and units are in
// omma/eye/files.py.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.h"
#include "omma/io.h"
#include "progress.h"

namespace omma::python {

void bind_eye_files(nb::module_& m) {
  m.def(
      "load_eye",
      [](nb::handle path, double metres_per_unit, const std::string& head) {
        const std::string name = path_text(path);
        return run_long([&] {
          return head.empty() ? load_eye(name, metres_per_unit) : load_eye_of_head(name, head);
        });
      },
      nb::arg("path"), nb::arg("metres_per_unit"), nb::arg("head"),
      nb::sig("def load_eye(path: str | os.PathLike[str], metres_per_unit: float, head: str) -> "
              "Eye"));
  m.def(
      "save_eye",
      [](nb::handle path, const Eye& eye, double metres_per_unit, bool lossy) {
        const std::string name = path_text(path);
        run_long_work([&] { save_eye(name, eye, metres_per_unit, lossy); });
      },
      nb::arg("path"), nb::arg("eye"), nb::arg("metres_per_unit"), nb::arg("lossy"),
      nb::sig("def save_eye(path: str | os.PathLike[str], eye: Eye, metres_per_unit: float, lossy: "
              "bool) -> None"));
  m.def(
      "eye_file_losses",
      [](nb::handle path, const Eye& eye) {
        return run_long([&, name = path_text(path)] { return eye_file_losses(name, eye); });
      },
      nb::arg("path"), nb::arg("eye"),
      nb::sig("def eye_file_losses(path: str | os.PathLike[str], eye: Eye) -> list[str]"));
  m.def(
      "eye_file_heads",
      [](nb::handle path) {
        return run_long([name = path_text(path)] { return eye_file_heads(name); });
      },
      nb::arg("path"), nb::sig("def eye_file_heads(path: str | os.PathLike[str]) -> list[str]"));
}

}  // namespace omma::python
