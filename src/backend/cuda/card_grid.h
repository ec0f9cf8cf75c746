// The Grid (physics/block/grid.h) that a card's threads are: those of CUDA.
#pragma once

#include "physics/block/grid.h"

namespace omma {

struct CardGrid {
  const GridLaunch& launch;

  __device__ std::int64_t first() const { return blockIdx.x; }
  __device__ std::int64_t step() const { return gridDim.x; }
  template <typename Each>
  __device__ void for_each(int count, const Each& each) {
    const auto i = static_cast<int>(threadIdx.x);
    if (i < count) each(i);
    __syncthreads();
  }
  template <typename Ask>
  __device__ int once(const Ask& ask) {
    __shared__ int said;
    if (threadIdx.x == 0) said = ask();
    __syncthreads();
    const int heard = said;
    __syncthreads();  // before it is said anew
    return heard;
  }
  __device__ std::byte* block_memory() const {
    return launch.memory + blockIdx.x * (launch.block_bytes + most_per_block * launch.thread_bytes);
  }
};

}  // namespace omma
