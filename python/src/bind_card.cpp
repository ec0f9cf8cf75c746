// Binds what is asked of graphics cards before a world is built for them, and of their kernels.
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
#include "model/long_work.h"
#include "omma/error.h"
#include "progress.h"

namespace omma::python {

namespace nb = nanobind;

namespace {

using Bytes = nb::ndarray<nb::numpy, std::uint8_t, nb::ndim<1>, nb::c_contig>;

// Of the card, as long as this lives.
struct CardMemory {
  int card;  // its ordinal
  std::uintptr_t at;

  CardMemory(std::size_t floats, int on)
      : card(on), at(allocate_on_card(on, floats * sizeof(float))) {}
  CardMemory(const CardMemory&) = delete;
  CardMemory& operator=(const CardMemory&) = delete;
  ~CardMemory() {
    try {
      free_on_card(card, at);
    } catch (const Error&) {
      // The card is lost, and its memory with it.
    }
  }
};

nb::object array_of(nb::handle owner, const std::vector<std::size_t>& shape) {
  const auto& memory = nb::cast<const CardMemory&>(owner);
  return nb::cast(nb::ndarray<nb::array_api, float, nb::device::cuda>(
      reinterpret_cast<float*>(memory.at), shape.size(), shape.data(), owner, nullptr,
      nb::dtype<float>(), nb::device::cuda::value, memory.card));
}

void bind_memory(nb::module_& m) {
  nb::class_<CardSpan>(m, "CardSpan", "float32 in a card's memory, for the engine to write into.")
      .def(
          "__init__",
          [](CardSpan* self, int card, std::uintptr_t at, std::size_t size,
             std::optional<std::uintptr_t> stream) {
            new (self) CardSpan{card, at, size, stream};
          },
          nb::arg("card"), nb::arg("at"), nb::arg("size"), nb::arg("stream").none());
  nb::class_<CardMemory>(m, "CardMemory", "Memory of a card for so many float32.")
      .def(nb::init<std::size_t, int>(), nb::arg("size"), nb::arg("card"))
      .def_ro("card", &CardMemory::card)
      .def_ro("at", &CardMemory::at)
      .def("array", &array_of, nb::arg("shape"),
           nb::sig("def array(self, shape: collections.abc.Sequence[int]) -> typing.Any"),
           "It as an array that DLPack hands over.");
  m.def(
      "card_read",
      [](int card, std::uintptr_t at, const Bytes& to) {
        read_from_card(card, to.data(), at, to.size());
      },
      nb::call_guard<nb::gil_scoped_release>(), nb::arg("card"), nb::arg("at"),
      nb::arg("to").noconvert(),
      nb::sig("def card_read(card: int, at: int, to: numpy.typing.NDArray[numpy.uint8]) -> None"),
      "Bytes of a card's memory, when all that was asked of the card is done.");
  m.def(
      "card_write",
      [](int card, std::uintptr_t at, const Bytes& from) {
        write_to_card(card, at, from.data(), from.size());
      },
      nb::call_guard<nb::gil_scoped_release>(), nb::arg("card"), nb::arg("at"),
      nb::arg("from_bytes").noconvert(),
      nb::sig("def card_write(card: int, at: int, from_bytes: numpy.typing.NDArray[numpy.uint8]) "
              "-> None"),
      "Bytes into a card's memory.");
  m.def("card_of", &card_of, nb::arg("at"),
        "The ordinal of the card that an address is on. Raises `omma.Error` where it is on none.");
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
      [](const std::string& nvrtc, const std::string& kernel_cache, const std::string& packaged) {
        CardLibraries libraries = card_libraries();
        libraries.nvrtc = nvrtc;
        libraries.kernel_cache = kernel_cache;
        libraries.packaged_kernels = packaged;
        set_card_libraries(libraries);
      },
      nb::arg("nvrtc"), nb::arg("kernel_cache"), nb::arg("packaged"),
      "Where the compiler of kernels is, \"\" for where the system has it, where they are kept, "
      "and where those are that came with Omma.");
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
      [](const std::vector<int>& devices, const nb::object& progress) {
        std::string note;
        run_with_progress(progress, [&](const Progress& told) {
          run_watched(told, [&](WorkState&) { note = card_note(devices); });
        });
        return note;
      },
      nb::arg("devices"), nb::arg("progress").none(),
      nb::sig("def card_note(devices: collections.abc.Sequence[int], progress: "
              "collections.abc.Callable[[float], object] | None) -> str"),
      "What is to be known of cards' kernels, or \"\". Compiles them; how far that is nobody "
      "knows.");
  m.def("compiling_kernels", compiling_kernels,
        "Whether a thread of this process is compiling kernels of a card now.");
  m.def(
      "compile_kernels",
      [](int capability, const std::string& nvrtc, const std::string& folder) {
        run_long_work([&] {
          for (const char* const program : {render_program, gather_program}) {
            const CompiledKernels made = compile_kernels({capability, nvrtc, folder}, program);
            if (!made.note.empty()) throw Error(made.note);
          }
        });
      },
      nb::arg("capability"), nb::arg("nvrtc"), nb::arg("folder"),
      "Compiles all kernels for cards of a compute capability, 90 for 9.0, into a folder, which is "
      "made where it is not there; no card is needed.");
  bind_memory(m);
}

}  // namespace omma::python
