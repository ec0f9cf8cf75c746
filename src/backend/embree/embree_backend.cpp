// Puts the Embree backend together, and chooses the build of its hot loop for the processor.
#include "backend/embree/embree_backend.h"

#include "backend/embree/embree_builds.h"
#include "backend/embree/embree_tracer.h"
#include "backend/processor.h"

namespace omma {
namespace {

Acceleration build(const Scene& scene, const SceneView& view, const Placement& placement,
                   std::span<const int>, WorkState* work) {
  std::shared_ptr<EmbreeTracer> tracer = make_embree_tracer(scene, view, placement, work);
  return {tracer, tracer->name};
}

void move(Acceleration& acceleration, std::span<const int> instances, std::span<const int> meshes,
          const Placement& placement) {
  move_instances(*static_cast<EmbreeTracer*>(acceleration.tracer.get()), instances, meshes,
                 placement);
}

Launches launches(std::span<const int> devices) {
  expect_no_devices("embree", devices);
  return launch_on_threads(embree_block_functions());
}

}  // namespace

BlockFunctions embree_block_functions() {
#if defined(OMMA_PLAIN_LANES)
  return plain::embree_block();
#endif
#if defined(OMMA_HAS_AVX512)
  if (has_avx512()) return avx512::embree_block();
#endif
#if defined(OMMA_HAS_AVX2)
  if (has_avx2()) return avx2::embree_block();
#endif
  return baseline::embree_block();
}

Backend embree_backend() {
  return {"embree", build, move, launches};
}

}  // namespace omma
