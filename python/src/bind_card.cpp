// Binds what is asked of a graphics card before a world is built for it.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "arrays.h"
#include "backend/backend.h"
#include "backend/cuda/card.h"
#include "backend/cuda/cuda_backend.h"
#include "card_places.h"
#include "progress.h"

namespace omma::python {

namespace nb = nanobind;

namespace {

using Bytes = nb::ndarray<nb::numpy, std::uint8_t, nb::ndim<1>, nb::c_contig>;

// Of the card, as long as this lives.
struct CardMemory {
  std::size_t size;  // of float32
  std::uintptr_t at;

  explicit CardMemory(std::size_t n) : size(n), at(allocate_on_card(n * sizeof(float))) {}
  CardMemory(const CardMemory&) = delete;
  CardMemory& operator=(const CardMemory&) = delete;
  ~CardMemory() {
    try {
      free_on_card(at);
    } catch (const Error&) {
      // The card is lost, and its memory with it.
    }
  }
};

nb::object array_of(nb::handle owner, const std::vector<std::size_t>& shape) {
  const auto& memory = nb::cast<const CardMemory&>(owner);
  return nb::cast(nb::ndarray<nb::array_api, float, nb::device::cuda>(
      reinterpret_cast<float*>(memory.at), shape.size(), shape.data(), owner, nullptr,
      nb::dtype<float>(), nb::device::cuda::value, 0));
}

void bind_memory(nb::module_& m) {
  nb::class_<CardSpan>(m, "CardSpan", "float32 in a card's memory, for the engine to write into.")
      .def(
          "__init__",
          [](CardSpan* self, std::uintptr_t at, std::size_t size,
             std::optional<std::uintptr_t> stream) {
            new (self) CardSpan{at, size, stream};
          },
          nb::arg("at"), nb::arg("size"), nb::arg("stream").none());
  nb::class_<CardMemory>(m, "CardMemory", "Memory of a card for so many float32.")
      .def(nb::init<std::size_t>(), nb::arg("size"))
      .def_ro("at", &CardMemory::at)
      .def("array", &array_of, nb::arg("shape"),
           nb::sig("def array(self, shape: collections.abc.Sequence[int]) -> typing.Any"),
           "It as an array that DLPack hands over.");
  m.def(
      "card_read",
      [](std::uintptr_t at, const Bytes& to) {
        check_on_card(at);
        wait_for_card();
        read_from_card(to.data(), at, to.size());
      },
      nb::call_guard<nb::gil_scoped_release>(), nb::arg("at"), nb::arg("to").noconvert(),
      nb::sig("def card_read(at: int, to: numpy.typing.NDArray[numpy.uint8]) -> None"),
      "Bytes of a card's memory, when all that was asked of the card is done.");
  m.def(
      "card_write",
      [](std::uintptr_t at, const Bytes& from) {
        check_on_card(at);
        write_to_card(at, from.data(), from.size());
      },
      nb::call_guard<nb::gil_scoped_release>(), nb::arg("at"), nb::arg("from_bytes").noconvert(),
      nb::sig("def card_write(at: int, from_bytes: numpy.typing.NDArray[numpy.uint8]) -> None"),
      "Bytes into a card's memory.");
  m.def("check_on_card", &check_on_card, nb::arg("at"),
        "Raises `omma.Error` where an address is not of the card that Omma uses.");
}

}  // namespace

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
  bind_memory(m);
}

}  // namespace omma::python
