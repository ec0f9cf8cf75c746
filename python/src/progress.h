// Long work for Python: the GIL is released meanwhile, and a progress callback takes it back a few
// times a second so that Ctrl-C works.
#pragma once

#include <nanobind/nanobind.h>

#include <exception>
#include <functional>

#include "omma/error.h"

namespace omma::python {

// Runs `work(progress)`, where `progress` is the callback to give to the engine, and raises what
// Python raised meanwhile: KeyboardInterrupt, or whatever `callback` (None: nothing) raises.
template <typename Work>
void run_with_progress(const nanobind::object& callback, const Work& work) {
  // It must not travel through the engine's own threads, so it waits here until the work has
  // stopped.
  std::exception_ptr raised;
  const std::function<bool(double)> progress = [&](double done) {
    nanobind::gil_scoped_acquire gil;
    try {
      if (PyErr_CheckSignals() != 0) nanobind::raise_python_error();
      if (!callback.is_none()) callback(done);
      return true;
    } catch (...) {
      raised = std::current_exception();
      return false;
    }
  };
  try {
    nanobind::gil_scoped_release release;
    work(progress);
  } catch (const Cancelled&) {
    if (!raised) throw;
  }
  if (raised) std::rethrow_exception(raised);
}

}  // namespace omma::python
