// The entry points of a card: each a kernel of physics/block/grid.h over the threads that CUDA has.
// Compiled at first use (compile.h); here nvcc compiles it where it is, to see that it can be.
#include "physics/block/grid.h"

namespace omma {
namespace {

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
    return launch.memory +
           blockIdx.x * (launch.block_bytes + most_per_block * launch.thread_bytes);
  }
};

}  // namespace

extern "C" __global__ void omma_render(GridLaunch launch) {
  CardGrid grid{launch};
  render_tasks(launch, grid);
}
extern "C" __global__ void omma_discs(GridLaunch launch) {
  CardGrid grid{launch};
  render_discs_of_tasks(launch, grid);
}
extern "C" __global__ void omma_gather(GridLaunch launch) {
  CardGrid grid{launch};
  gather_tasks(launch, grid);
}
extern "C" __global__ void omma_weigh(GridLaunch launch) {
  CardGrid grid{launch};
  weigh_tasks(launch, grid);
}
extern "C" __global__ void omma_closest(GridLaunch launch) {
  CardGrid grid{launch};
  find_closest(launch, grid);
}

}  // namespace omma
