// Vectors of three lanes: of one ray where F is a float, else of as many rays as go at once.
// Operations are written out by axis, in one order, so that all instruction sets give the same
// bits. In memory a packet has [axis][lane].
#pragma once

#include <type_traits>

#include "physics/lanes/lanes.h"

namespace omma {

template <typename F>
struct Vector3 {
  F x, y, z;

  // For loops by axis alone.
  OMMA_HD F& operator[](int axis) { return axis == 0 ? x : (axis == 1 ? y : z); }
  OMMA_HD const F& operator[](int axis) const { return axis == 0 ? x : (axis == 1 ? y : z); }
};

// One vector may be of all lanes and the other a float's, the same for all.
template <typename F, typename G>
OMMA_HD auto operator+(const Vector3<F>& a, const Vector3<G>& b) -> Vector3<decltype(a.x + b.x)> {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <typename F, typename G>
OMMA_HD auto operator-(const Vector3<F>& a, const Vector3<G>& b) -> Vector3<decltype(a.x - b.x)> {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <typename F, typename S>
OMMA_HD auto operator*(const Vector3<F>& a, const S& scale) -> Vector3<decltype(a.x * scale)> {
  return {a.x * scale, a.y * scale, a.z * scale};
}
template <typename F, typename G>
OMMA_HD auto dot(const Vector3<F>& a, const Vector3<G>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename F>
OMMA_HD Vector3<F> cross(const Vector3<F>& a, const Vector3<F>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// a where a comparison holds, else b.
template <typename Mask, typename F>
OMMA_HD Vector3<F> select(const Mask& mask, const Vector3<F>& a, const Vector3<F>& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
template <typename Mask, typename F>
requires(!std::is_same_v<Mask, bool>) OMMA_HD Vector3<F> keep(const Mask& mask,
                                                              const Vector3<F>& a) {
  return {keep(mask, a.x), keep(mask, a.y), keep(mask, a.z)};
}

template <typename F>
OMMA_HD Vector3<F> operator-(const Vector3<F>& a) {
  return {-a.x, -a.y, -a.z};
}
// The same, but zeros stay zeros without a sign.
template <typename F>
OMMA_HD Vector3<F> opposite(const Vector3<F>& a) {
  return {0.0f - a.x, 0.0f - a.y, 0.0f - a.z};
}

// To unit length; what has none stays zero.
template <typename F>
OMMA_HD Vector3<F> normalize(const Vector3<F>& a) {
  const F square = dot(a, a);
  return a * (square > 0.0f ? 1.0f / sqrt_lanes(square) : square);
}

// Two axes across a unit vector.
template <typename F>
struct Axes {
  Vector3<F> tangent, bitangent;
};

// Duff et al. 2017, Building an orthonormal basis, revisited (Journal of Computer Graphics
// Techniques 6(1)), listing 3.
template <typename F>
OMMA_HD Axes<F> make_axes(const Vector3<F>& n) {
  const F sign = n.z < 0.0f ? broadcast<F>(-1.0f) : broadcast<F>(1.0f);
  const F a = -1.0f / (sign + n.z), b = n.x * n.y * a;
  return {{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

template <typename F, int n>
OMMA_HD Vector3<F> load_vector(const float (&values)[3][n], int l) {
  return {load<F>(values[0] + l), load<F>(values[1] + l), load<F>(values[2] + l)};
}
template <typename F, int n>
OMMA_HD void store_vector(float (&values)[3][n], int l, const Vector3<F>& v) {
  store(values[0] + l, v.x);
  store(values[1] + l, v.y);
  store(values[2] + l, v.z);
}

// base[3 * index] and the two behind it, for each lane.
template <typename F, typename I>
OMMA_HD Vector3<F> gather_vector(const float* base, I index) {
  F v[3];
  gather_3(base, index, v);
  return {v[0], v[1], v[2]};
}

// Of one lane, as the public API has vectors, and back.
template <int n>
OMMA_HD Vec3 vec_at(const float (&values)[3][n], int l) {
  return {values[0][l], values[1][l], values[2][l]};
}
OMMA_HD Vector3<float> vector_of(Vec3 v) {
  return {v.x, v.y, v.z};
}
OMMA_HD Vector3<float> vector_of(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}
OMMA_HD Vec3 vec_of(const Vector3<float>& v) {
  return {v.x, v.y, v.z};
}

// By an affine transform, [row][column].
template <typename M, typename F>
OMMA_HD Vector3<F> transform_direction(const M (&m)[3][4], const Vector3<F>& v) {
  return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
          m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
          m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}
template <typename M, typename F>
OMMA_HD Vector3<F> transform_point(const M (&m)[3][4], const Vector3<F>& p) {
  return {m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
          m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
          m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]};
}

}  // namespace omma
