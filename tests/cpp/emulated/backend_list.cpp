// The backends of the program that tests rendering: those that are built in, and the emulated one,
// in place of src/backend/backend_list.cpp.
#include <array>

#include "emulated/emulated_backend.h"
#if defined(OMMA_HAS_EMBREE)
#include "backend/embree/embree_backend.h"
#endif
#include "backend/portable/portable_backend.h"

namespace omma {
namespace {

const std::array all {
#if defined(OMMA_HAS_EMBREE)
  embree_backend(),
#endif
      portable_backend(), test::emulated_backend()
};

}  // namespace

std::span<const Backend> backends() {
  return all;
}

}  // namespace omma
