// The hot loop with our own search. This file is compiled once per instruction set.
#include "backend/block_build.h"
#include "backend/portable/portable_builds.h"
#include "backend/portable/portable_tracer.h"
#include "physics/surface/scene_search.h"

namespace omma::OMMA_ISA {

BlockFunctions portable_block() {
  return build_block([](const void* built) {
    const auto& tracer = *static_cast<const PortableTracer*>(built);
    return SceneSearch<Packets>{tracer.scene_view, &tracer.view};
  });
}

}  // namespace omma::OMMA_ISA
