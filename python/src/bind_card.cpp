// Binds what is asked of a graphics card before a world is built for it.
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
      "card_state",
      [] {
        const CardState state = card_state();
        return std::tuple(state.name, state.driver, state.why_not);
      },
      "Name of the card, the CUDA that its driver is for, and why it cannot be used; \"\" for "
      "none.");
  m.def(
      "card_note", [] { return run_long([] { return card_note(); }); },
      "What is to be known of the card's kernels, or \"\". Compiles them.");
}

}  // namespace omma::python
