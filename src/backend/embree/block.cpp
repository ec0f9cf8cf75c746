// The hot loop with Embree's search. This file is compiled once per instruction set.
#include "backend/block_build.h"
#include "backend/embree/embree_builds.h"
#include "backend/embree/embree_search.h"

namespace omma::OMMA_ISA {

BlockFunctions embree_block() {
  return build_block([](const void* tracer) {
    return EmbreeSearch<Packets>{static_cast<const EmbreeTracer*>(tracer)};
  });
}

}  // namespace omma::OMMA_ISA
