// A backend that stands for a graphics card: the portable one's hierarchy, searched in one lane by
// each of the threads of a grid.
#pragma once

#include "backend/backend.h"
#include "emulated/device.h"

namespace omma::test {

Backend emulated_backend();

// The most that a thread of any launch in one lane has had since this was asked for last.
DeviceUse take_device_use();

// Bytes of arrays that have been copied to stay since this was asked for last.
std::size_t take_kept_bytes();

}  // namespace omma::test
