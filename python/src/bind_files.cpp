// The one writer and the one reader of files for Python; omma/base/files.py wraps them.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.h"
#include "io/atomic_file.h"
#include "io/whole_files.h"
#include "progress.h"

namespace omma::python {
namespace {

// The bytes of anything with Python's buffer protocol, contiguous.
struct Buffer {
  explicit Buffer(nb::handle object) {
    if (PyObject_GetBuffer(object.ptr(), &view, PyBUF_SIMPLE) != 0) nb::raise_python_error();
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { PyBuffer_Release(&view); }
  std::span<const char> bytes() const {
    return {static_cast<const char*>(view.buf), static_cast<std::size_t>(view.len)};
  }
  Py_buffer view{};
};

}  // namespace

void bind_files(nb::module_& m) {
  nb::class_<WholeFiles>(m, "WholeFiles")
      .def(nb::init<>())
      .def(
          "open", [](WholeFiles& files, nb::handle path) { return files.open(path_text(path)); },
          nb::arg("path"), nb::sig("def open(self, path: str | os.PathLike[str]) -> int"))
      .def(
          "open_kept",
          [](WholeFiles& files, nb::handle path, std::uintmax_t bytes) {
            return files.open_kept(path_text(path), bytes);
          },
          nb::arg("path"), nb::arg("bytes"),
          nb::sig("def open_kept(self, path: str | os.PathLike[str], bytes: int) -> int"))
      .def(
          "write",
          [](WholeFiles& files, std::size_t file, nb::handle data) {
            const Buffer buffer(data);
            run_long_work([&] { files.write(file, buffer.bytes()); });
          },
          nb::arg("file"), nb::arg("data"),
          nb::sig("def write(self, file: int, data: object) -> None"))
      .def(
          "temporary",
          [](const WholeFiles& files, std::size_t file) {
            return path_object(files.temporary(file));
          },
          nb::arg("file"), nb::sig("def temporary(self, file: int) -> str"),
          "Where its bytes are meanwhile, for libraries that write to a path themselves.")
      .def(
          "close",
          [](WholeFiles& files, std::size_t file) { run_long_work([&] { files.close(file); }); },
          nb::arg("file"))
      .def(
          "sync",
          [](WholeFiles& files, std::size_t file) {
            return run_long([&] { return files.sync(file); });
          },
          nb::arg("file"))
      .def("finish", [](WholeFiles& files) { run_long_work([&] { files.finish(); }); })
      .def("discard", &WholeFiles::discard);
  m.def(
      "check_target", [](nb::handle path) { check_target(path_text(path)); }, nb::arg("path"),
      nb::sig("def check_target(path: str | os.PathLike[str]) -> None"));
  m.def(
      "kept_bytes", [](nb::handle path) { return kept_bytes(path_text(path)); }, nb::arg("path"),
      nb::sig("def kept_bytes(path: str | os.PathLike[str]) -> int"));
  m.def(
      "read_file",
      [](nb::handle path) {
        const std::string name = path_text(path);
        const std::string bytes = run_long([&] { return read_file(name); });
        return nb::bytes(bytes.data(), bytes.size());
      },
      nb::arg("path"), nb::sig("def read_file(path: str | os.PathLike[str]) -> bytes"),
      "All bytes of a regular file; `omma.Error` where it is none or cannot be read.");
  m.def(
      "left_behind",
      [](const std::vector<nb::object>& paths) {
        std::vector<std::string> names;
        for (const nb::object& path : paths) names.push_back(path_text(path));
        nb::list found;
        for (const LeftBehind& file : left_behind(names))
          found.append(nb::make_tuple(path_object(file.path), file.bytes));
        return found;
      },
      nb::arg("paths"),
      nb::sig("def left_behind(paths: Sequence[str | os.PathLike[str]]) -> list[tuple[str, int]]"),
      "What runs that were killed left of files with these names: names and sizes in bytes.");
}

}  // namespace omma::python
