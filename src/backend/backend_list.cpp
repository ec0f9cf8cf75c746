// The backends that are built in.
#include <array>

#include "backend/backend.h"
#if defined(OMMA_HAS_CUDA)
#include "backend/cuda/cuda_backend.h"
#endif
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
      portable_backend(),
#if defined(OMMA_HAS_CUDA)
      cuda_backend(),
#endif
};

}  // namespace

std::span<const Backend> backends() {
  return all;
}

}  // namespace omma
