// The backend with a search of its own, for any processor.
#pragma once

#include "backend/backend.h"

namespace omma {

Backend portable_backend();

// The hot loop for this processor.
BlockFunctions portable_block_functions();

}  // namespace omma
