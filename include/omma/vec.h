// Small vectors and the 4x4 transform, shared by host and device. Everything here is plain data
// with free functions; nothing allocates. `OMMA_HD` marks what also compiles as CUDA device code; its
// two kin below are called where it is inlined. There are no other function-attribute macros.
#pragma once

#include <cmath>

#if defined(__CUDACC__)
#define OMMA_HD __host__ __device__ inline
#define OMMA_HD_CALLED __host__ __device__ __noinline__
#define OMMA_HD_LARGE __host__ __device__ __noinline__ inline
#else
// Always inlined, so that a file compiled for a newer instruction set never leaves an out-of-line
// copy behind that the linker could hand to older machines.
#define OMMA_HD __attribute__((always_inline)) inline
// For large templates of lanes of which each instruction set has its own number: called, so that
// their code is there once. tests/python/test_instruction_sets.py holds that none is shared.
#define OMMA_HD_CALLED __attribute__((noinline))
// Called on a card, where code that is there in many places costs minutes of compiling; else inlined.
#define OMMA_HD_LARGE OMMA_HD
#endif

namespace omma {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double degree = pi / 180.0;  // radians per degree

struct Vec2 {
  float x = 0, y = 0;
  bool operator==(const Vec2&) const = default;
};

struct Vec3 {
  float x = 0, y = 0, z = 0;
  bool operator==(const Vec3&) const = default;
};

struct Vec4 {
  float x = 0, y = 0, z = 0, w = 0;
  bool operator==(const Vec4&) const = default;
};

// Double precision, for setting things up: transforms, frames, bounds.
struct Vec3d {
  double x = 0, y = 0, z = 0;
};

OMMA_HD Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
OMMA_HD Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
OMMA_HD Vec3 operator*(Vec3 a, float s) {
  return {a.x * s, a.y * s, a.z * s};
}
OMMA_HD float dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

OMMA_HD Vec3d operator+(Vec3d a, Vec3d b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
OMMA_HD Vec3d operator-(Vec3d a, Vec3d b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
OMMA_HD Vec3d operator*(Vec3d a, double s) {
  return {a.x * s, a.y * s, a.z * s};
}
OMMA_HD double dot(Vec3d a, Vec3d b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
OMMA_HD Vec3d cross(Vec3d a, Vec3d b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
OMMA_HD double length(Vec3d a) {
  return sqrt(dot(a, a));
}
OMMA_HD Vec3d normalize(Vec3d a) {
  return a * (1.0 / length(a));
}

OMMA_HD Vec3d to_double(Vec3 a) {
  return {a.x, a.y, a.z};
}
OMMA_HD Vec3 to_float(Vec3d a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

// An affine transform, row major, acting on column vectors: p_world = world_from_eye * p_eye.
// Named by direction: `world_from_head`, `head_from_eye`. The memory is that of a C-ordered
// NumPy (4, 4) float64 array.
struct Mat4 {
  double m[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  bool operator==(const Mat4&) const = default;
};

OMMA_HD Mat4 operator*(const Mat4& a, const Mat4& b) {
  Mat4 c;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      c.m[i][j] = 0;
      for (int k = 0; k < 4; ++k) c.m[i][j] += a.m[i][k] * b.m[k][j];
    }
  return c;
}

OMMA_HD Vec3d transform_vector(const Mat4& t, Vec3d v) {
  return {t.m[0][0] * v.x + t.m[0][1] * v.y + t.m[0][2] * v.z,
          t.m[1][0] * v.x + t.m[1][1] * v.y + t.m[1][2] * v.z,
          t.m[2][0] * v.x + t.m[2][1] * v.y + t.m[2][2] * v.z};
}

OMMA_HD Vec3d transform_point(const Mat4& t, Vec3d p) {
  return transform_vector(t, p) + Vec3d{t.m[0][3], t.m[1][3], t.m[2][3]};
}

// Determinant of the linear part; negative for a transform that mirrors.
OMMA_HD double determinant(const Mat4& t) {
  const Vec3d x{t.m[0][0], t.m[1][0], t.m[2][0]};
  const Vec3d y{t.m[0][1], t.m[1][1], t.m[2][1]};
  const Vec3d z{t.m[0][2], t.m[1][2], t.m[2][2]};
  return dot(x, cross(y, z));
}

}  // namespace omma
