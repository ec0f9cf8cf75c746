// The hot loop with our own search, built for each instruction set, and with lanes that are plain
// loops (CMakeLists.txt says for what).
#pragma once

#include "backend/block_functions.h"

namespace omma {

namespace baseline {
BlockFunctions portable_block();
}
namespace plain {
BlockFunctions portable_block();
}
namespace avx2 {
BlockFunctions portable_block();
}
namespace avx512 {
BlockFunctions portable_block();
}

}  // namespace omma
