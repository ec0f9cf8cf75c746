// Four colour components worked on together: a vector register on the host, four floats on the
// device, the same arithmetic on both.
#pragma once

#include <cstdint>

#include "omma/vec.h"

namespace omma {

#if defined(__CUDACC__)
struct Rgba {
  float v[4];
  OMMA_HD float operator[](int i) const { return v[i]; }
};
OMMA_HD Rgba operator+(Rgba a, Rgba b) {
  return {{a.v[0] + b.v[0], a.v[1] + b.v[1], a.v[2] + b.v[2], a.v[3] + b.v[3]}};
}
OMMA_HD Rgba operator*(Rgba a, Rgba b) {
  return {{a.v[0] * b.v[0], a.v[1] * b.v[1], a.v[2] * b.v[2], a.v[3] * b.v[3]}};
}
OMMA_HD Rgba operator*(Rgba a, float s) {
  return {{a.v[0] * s, a.v[1] * s, a.v[2] * s, a.v[3] * s}};
}
OMMA_HD Rgba make_rgba(float r, float g, float b, float a) {
  return {{r, g, b, a}};
}
OMMA_HD Rgba load_rgba(const std::uint16_t* p) {
  return {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]),
           static_cast<float>(p[3])}};
}
#else
using Rgba = float __attribute__((vector_size(16)));
OMMA_HD Rgba make_rgba(float r, float g, float b, float a) {
  return Rgba{r, g, b, a};
}
// Four 16-bit integers as floats; by way of signed 32-bit ones, which have an instruction.
OMMA_HD Rgba load_rgba(const std::uint16_t* p) {
  using Short = std::uint16_t __attribute__((vector_size(8)));
  using Long = std::int32_t __attribute__((vector_size(16)));
  Short integers;
  __builtin_memcpy(&integers, p, sizeof integers);
  return __builtin_convertvector(__builtin_convertvector(integers, Long), Rgba);
}
#endif

OMMA_HD Rgba load_rgba(const Vec4& c) {
  return make_rgba(c.x, c.y, c.z, c.w);
}

}  // namespace omma
