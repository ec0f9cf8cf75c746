// Chooses the build of the hot loop for the processor it runs on.
#include "backend/embree/block.h"

namespace omma {

BlockFunctions choose_block_functions() {
#if defined(OMMA_HAS_AVX512)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    return {avx512::render_block, avx512::weigh_rays, avx512::prepare_block};
#endif
#if defined(OMMA_HAS_AVX2)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
      __builtin_cpu_supports("bmi2"))
    return {avx2::render_block, avx2::weigh_rays, avx2::prepare_block};
#endif
  return {baseline::render_block, baseline::weigh_rays, baseline::prepare_block};
}

}  // namespace omma
