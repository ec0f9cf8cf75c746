// The backend with a search of its own, for any processor.
#pragma once

#include "backend/backend.h"

namespace omma {

Backend portable_backend();

}  // namespace omma
