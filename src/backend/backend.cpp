// The backends that are built in.
#include "backend/backend.h"

#include <array>

#if defined(OMMA_HAS_EMBREE)
#include "backend/embree/embree_backend.h"
#endif
#include "backend/portable/portable_backend.h"
#include "omma/error.h"
#include "physics/block/block_memory.h"

namespace omma {
namespace {

const std::array all {
#if defined(OMMA_HAS_EMBREE)
  embree_backend(),
#endif
      portable_backend()
};

}  // namespace

std::span<const Backend> backends() {
  return all;
}

const Backend& find_backend(const std::string& name) {
  std::string names;
  for (const Backend& backend : backends()) {
    if (name.empty() || name == backend.name) return backend;
    names += (names.empty() ? "" : ", ") + std::string(backend.name);
  }
  throw Error("backend: expected one that is built in (" + names + "), found \"" + name + "\"");
}

std::size_t block_memory_bytes(const FrameView& frame) {
  Scratch scratch;
  lay_out(scratch, frame, packet_rays);
  return scratch.used;
}

}  // namespace omma
