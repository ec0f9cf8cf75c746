// Puts the portable backend together, and chooses the build of its hot loop for the processor.
#include "backend/portable/backend.h"

#include "backend/portable/builds.h"
#include "backend/portable/tracer.h"
#include "backend/processor.h"

namespace omma {
namespace {

Acceleration build(const Scene& scene, const SceneView& view, WorkState* work) {
  std::shared_ptr<PortableTracer> tracer = make_portable_tracer(scene, view, work);
  return {tracer, tracer->name, tracer->origin_m, tracer->half_size_m};
}

BlockFunctions block_functions() {
#if defined(OMMA_PLAIN_LANES)
  return plain::portable_block();
#endif
#if defined(OMMA_HAS_AVX512)
  if (has_avx512()) return avx512::portable_block();
#endif
#if defined(OMMA_HAS_AVX2)
  if (has_avx2()) return avx2::portable_block();
#endif
  return baseline::portable_block();
}

}  // namespace

Backend portable_backend() {
  return {"portable", build, block_functions};
}

}  // namespace omma
