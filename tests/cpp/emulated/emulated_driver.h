// What tests ask of the stand-in for NVIDIA's driver (driver.cpp), by dlsym.
#pragma once

#include "emulated/device.h"

extern "C" {

// The most that a thread of any launch in one lane has had since this was asked for last.
omma::test::DeviceUse emulated_take_use();

// The stream that the last launch was on.
void* emulated_last_stream();

// The next calls of that name, so many, end in the error; "": none do.
void emulated_fail(const char* call, int error, int times);
}
