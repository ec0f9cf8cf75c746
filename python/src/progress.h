// Calls into the engine that may take long. The GIL is released meanwhile, so that other Python
// threads run; a few times a second it is taken back, so that Ctrl-C works and a progress callback
// is told; and when Python ends, the work of other threads ends first.
#pragma once

#include <nanobind/nanobind.h>

#include <functional>
#include <optional>
#include <utility>

namespace omma::python {

using Progress = std::function<bool(double)>;

// Runs work(progress) without the GIL, where `progress` is the callback to give to the engine, and
// raises what Python raised meanwhile: KeyboardInterrupt, or what `callback` (None: nothing)
// raises.
void run_with_progress(const nanobind::object& callback,
                       const std::function<void(const Progress&)>& work);

// Runs make() without the GIL and gives what it returns. Where it asks check_cancelled() all along
// (threads/parallel.h), Ctrl-C ends it.
void run_long_work(const std::function<void()>& work);
template <typename Make>
auto run_long(const Make& make) {
  std::optional<decltype(make())> made;
  run_long_work([&] { made.emplace(make()); });
  return std::move(*made);
}

// Has the work of other threads ended when Python begins to end.
void end_work_at_exit();

}  // namespace omma::python
