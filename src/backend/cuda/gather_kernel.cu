// The entry point of a card that gathers light to be baked. By itself, as it takes longer to
// compile than all others, and few ask for it.
#include "backend/cuda/card_grid.h"

namespace omma {

extern "C" __global__ void omma_gather(GridLaunch launch) {
  CardGrid grid{launch};
  gather_tasks(launch, grid);
}

}  // namespace omma
