// The entry points of a card that render: each a kernel of physics/block/grid.h over the threads
// that CUDA has. Compiled at first use (compile.h).
#include "backend/cuda/card_grid.h"

namespace omma {

extern "C" __global__ void omma_render(GridLaunch launch) {
  CardGrid grid{launch};
  render_tasks(launch, grid);
}
extern "C" __global__ void omma_discs(GridLaunch launch) {
  CardGrid grid{launch};
  render_discs_of_tasks(launch, grid);
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
