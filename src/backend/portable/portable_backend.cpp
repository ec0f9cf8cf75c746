// Puts the portable backend together, and chooses the build of its hot loop for the processor.
#include "backend/portable/portable_backend.h"

#include "backend/portable/portable_builds.h"
#include "backend/portable/portable_tracer.h"
#include "backend/processor.h"

namespace omma {
namespace {

Acceleration build(const Scene& scene, const SceneView& view, const Placement& placement,
                   std::span<const int>, WorkState* work) {
  std::shared_ptr<PortableTracer> tracer = make_portable_tracer(scene, view, placement, work);
  return {tracer, tracer->name};
}

void move(Acceleration& acceleration, std::span<const int> instances, std::span<const int> meshes,
          const Placement& placement) {
  move_instances(*static_cast<PortableTracer*>(acceleration.tracer.get()), instances, meshes,
                 placement);
}

Launches launches(std::span<const int> devices) {
  expect_no_devices("portable", devices);
  return launch_on_threads(portable_block_functions());
}

}  // namespace

BlockFunctions portable_block_functions() {
#if defined(OMMA_PLAIN_LANES)
  return plain::portable_block();
#else
#if defined(OMMA_HAS_AVX512)
  if (has_avx512()) return avx512::portable_block();
#endif
#if defined(OMMA_HAS_AVX2)
  if (has_avx2()) return avx2::portable_block();
#endif
  return baseline::portable_block();
#endif
}

Backend portable_backend() {
  return {"portable", build, move, launches};
}

}  // namespace omma
