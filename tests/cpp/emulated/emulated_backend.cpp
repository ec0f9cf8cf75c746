// Has the card's libraries be the emulated ones.
#include "emulated/emulated_backend.h"

#include <dlfcn.h>

#include <cstdlib>

#include "backend/cuda/cuda_backend.h"
#include "emulated/emulated_driver.h"

namespace omma::test {
namespace {

template <typename Function>
Function* in_driver(const char* name) {
  void* const library = dlopen(OMMA_EMULATED_DRIVER, RTLD_NOW | RTLD_LOCAL);
  void* const found = library != nullptr ? dlsym(library, name) : nullptr;
  if (found == nullptr) std::abort();
  return reinterpret_cast<Function*>(found);
}

}  // namespace

bool is_real_card() {
  return std::getenv("OMMA_TEST_CARD") != nullptr;
}

Backend emulated_backend() {
  if (!is_real_card())
    set_card_libraries({.driver = OMMA_EMULATED_DRIVER,
                        .nvrtc = OMMA_STAND_IN_NVRTC,
                        .kernel_cache = "",
                        .packaged_kernels = "",
                        .checks_copies = true});
  else
    set_card_libraries({.packaged_kernels = std::getenv("OMMA_TEST_CARD")});
  const auto build = [](const Scene& scene, const SceneView& view, const Placement& placement,
                        std::span<const int> devices, WorkState* work) {
    const Acceleration built = cuda_backend().build(scene, view, placement, devices, work);
    return Acceleration{built.tracer, "emulated, " + built.name, built.cards};
  };
  return {"emulated", build, cuda_backend().move, cuda_backend().launches};
}

DeviceUse take_device_use() {
  if (is_real_card()) return {};  // which does not say
  return in_driver<decltype(emulated_take_use)>("emulated_take_use")();
}

void limit_card_memory(std::size_t bytes) {
  in_driver<decltype(emulated_limit_memory)>("emulated_limit_memory")(bytes);
}

void make_driver_fail(const char* call, int error, int times, int card) {
  in_driver<decltype(emulated_fail)>("emulated_fail")(call, error, times, card);
}

}  // namespace omma::test
