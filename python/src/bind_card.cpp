// Binds what is asked of graphics cards before a world is built for them.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "arrays.h"
#include "backend/backend.h"
#include "backend/cuda/card.h"
#include "backend/cuda/cuda_backend.h"
#include "progress.h"

namespace omma::python {

namespace nb = nanobind;

void bind_card(nb::module_& m) {
  m.def(
      "backends",
      [] {
        std::vector<std::string> names;
        for (const Backend& backend : backends()) names.emplace_back(backend.name);
        return names;
      },
      "Names of what can trace rays in this build.");
  m.def(
      "use_card_libraries",
      [](const std::string& nvrtc, const std::string& kernel_cache) {
        CardLibraries libraries = card_libraries();
        libraries.nvrtc = nvrtc;
        libraries.kernel_cache = kernel_cache;
        set_card_libraries(libraries);
      },
      nb::arg("nvrtc"), nb::arg("kernel_cache"),
      "Where the compiler of kernels is, \"\" for where the system has it, and where they are "
      "kept.");
  m.def(
      "card_states",
      [] {
        std::vector<std::tuple<std::string, std::string, std::string>> states;
        for (const CardState& state : card_states())
          states.emplace_back(state.name, state.driver, state.why_not);
        return states;
      },
      "Of each card its name, the CUDA that its driver is for, and why it cannot be used; \"\" for "
      "none.");
  m.def(
      "card_note",
      [](const std::vector<int>& devices) { return run_long([&] { return card_note(devices); }); },
      nb::arg("devices"), "What is to be known of cards' kernels, or \"\". Compiles them.");
}

}  // namespace omma::python
