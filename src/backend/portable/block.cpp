// The hot loop with our own search. This file is compiled once per instruction set.
#include "backend/block_build.h"
#include "backend/portable/portable_builds.h"
#include "backend/portable/portable_search.h"

namespace omma::OMMA_ISA {

BlockFunctions portable_block() {
  return build_block<PortableSearch<Packets>, PortableTracer>();
}

}  // namespace omma::OMMA_ISA
