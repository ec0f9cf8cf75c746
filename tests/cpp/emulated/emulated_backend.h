// The backend of a graphics card (backend/cuda), with a driver that stands for one.
#pragma once

#include "backend/backend.h"
#include "emulated/device.h"

namespace omma::test {

Backend emulated_backend();

// Whether, as scripts/device asks for, it is the machine's own card after all.
bool is_real_card();

// As emulated_driver.h has them.
DeviceUse take_device_use();
void limit_card_memory(std::size_t bytes);
void make_driver_fail(const char* call, int error, int times = 1000, int card = -1);

}  // namespace omma::test
