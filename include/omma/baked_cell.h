// What of baked light lies in memory by cell, for device code too; omma/bake.h includes it.
#pragma once

#include <cstdint>

namespace omma {

// So that a cell of 16 bands lies in one line of a processor's cache.
struct alignas(64) BakedLine {
  std::uint16_t values[32];
};

// How far the light at a point of one side of a cell may be off, as a fraction of the cell's: one
// standard deviation of what it has by itself, noise and what light varies by within it, and of what
// it shares with its group, the cells around it that face alike. In steps that are squares:
// (code / 128)^2.
struct CellError {
  std::uint8_t own = 0, shared = 0;
  std::uint16_t signs = 0;  // random bits, the same for a group
};

}  // namespace omma
