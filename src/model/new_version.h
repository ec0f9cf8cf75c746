// Numbers for what arrays hold: whoever makes or changes arrays that views point to takes one.
#pragma once

#include <atomic>

#include "physics/views/version.h"

namespace omma {

inline Version new_version() {
  static std::atomic<Version> last = 0;
  return ++last;
}

}  // namespace omma
