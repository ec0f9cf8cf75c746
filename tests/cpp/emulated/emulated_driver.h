// What tests ask of the stand-in for NVIDIA's driver (driver.cpp), by dlsym. The environment
// variable OMMA_EMULATED_CARDS says how many cards it has; else it is one.
#pragma once

#include "emulated/device.h"

extern "C" {

// The most that a thread of any launch in one lane has had since this was asked for last.
omma::test::DeviceUse emulated_take_use();

// How much memory each card has from now on; 0: as much as ever.
void emulated_limit_memory(std::size_t bytes);

// The stream that the last launch of the first card was on.
void* emulated_last_stream();

// The next calls of that name for a card, or with -1 for any, so many, end in the error; "": none
// do.
void emulated_fail(const char* call, int error, int times, int card);
}
