// The hot loop with Embree's search, built for each instruction set, and with lanes that are plain
// loops (CMakeLists.txt says for what).
#pragma once

#include "backend/block_functions.h"

namespace omma {

namespace baseline {
BlockFunctions embree_block();
}
namespace plain {
BlockFunctions embree_block();
}
namespace avx2 {
BlockFunctions embree_block();
}
namespace avx512 {
BlockFunctions embree_block();
}

}  // namespace omma
