// The backend that traces with Embree: the fastest on a processor of the x86 family.
#pragma once

#include "backend/backend.h"

namespace omma {

Backend embree_backend();

// The hot loop for this processor.
BlockFunctions embree_block_functions();

}  // namespace omma
