// How a smooth boundary reflects polarised light, and what becomes of Stokes vectors (I, Q, U) on
// the way: Fresnel's amplitudes, Mueller matrices, and turns of the frames that they are told in.
//
// A ray with direction d, away from the eye, has axes e1 across it and e2 = d x e1; Q > 0 is light
// that swings along e1 (omma/light.h). A boundary has the axis s across the plane of incidence, the
// same for the ray that comes to it and the one that leaves: in the frames (s, d x s) of both rays
// the Mueller matrix of a reflection has the shape below.
#pragma once

#include "physics/lanes/lanes.h"
#include "physics/lanes/vector3.h"

namespace omma {

template <typename F>
struct Stokes {
  F i, q, u;
};

// Of reflected over incident fields, across the plane of incidence (s) and in it (p).
template <typename F>
struct Amplitudes {
  F s, p;
};

// Of a dielectric, `ior` that of the far side over that of the near one, `cos_i` in [0, 1]. Born and
// Wolf, Principles of Optics (7th ed., 1999), 1.5.2 equations 21, with n cos_t = sqrt(n^2 - 1 +
// cos_i^2). Their p = k x s follows the ray, so that s.p is below 0 at normal incidence. Where all
// is reflected, from inside, the phase between s and p is left out: it makes light circular.
template <typename F>
OMMA_HD Amplitudes<F> fresnel_dielectric(F cos_i, F ior) {
  constexpr float tiny = 1e-30f;  // ior 1 at grazing incidence: 0, not 0 / 0
  const F n2 = ior * ior;
  const F g2 = (ior - 1.0f) * (ior + 1.0f) + cos_i * cos_i;
  const F g = sqrt_lanes(g2 > 0.0f ? g2 : broadcast<F>(0.0f));
  return {(cos_i - g) / (cos_i + g + tiny), (n2 * cos_i - g) / (n2 * cos_i + g + tiny)};
}

// (1 - cos)^5, by which the reflectance of a metal grows from its value at normal incidence to 1:
// Schlick 1994, equation 15.
template <typename F>
OMMA_HD F schlick_weight(F cos_i) {
  const F x = 1.0f - cos_i, x2 = x * x;
  return x2 * x2 * x;
}

// Mueller matrix of a reflection: [[a, b, 0], [b, a, 0], [0, 0, c]].
template <typename F>
struct Mueller {
  F a, b, c;
};

// Bohren and Huffman 1983, section 2.11.2.
template <typename F>
OMMA_HD Mueller<F> mueller_of(const Amplitudes<F>& r) {
  const F s2 = r.s * r.s, p2 = r.p * r.p;
  return {0.5f * (s2 + p2), 0.5f * (s2 - p2), r.s * r.p};
}

// Of a mirror that reflects both polarisations alike, as metals nearly do: handedness of U changes.
template <typename F>
OMMA_HD Mueller<F> mueller_of_metal(F reflectance) {
  return {reflectance, reflectance * 0.0f, -reflectance};
}

template <typename F>
OMMA_HD Mueller<F> operator*(const Mueller<F>& m, F scale) {
  return {m.a * scale, m.b * scale, m.c * scale};
}

template <typename F>
OMMA_HD Stokes<F> operator*(const Mueller<F>& m, const Stokes<F>& s) {
  return {m.a * s.i + m.b * s.q, m.b * s.i + m.a * s.q, m.c * s.u};
}

// From one frame of a ray to another: cosine and sine of 2 phi, where the other's first axis is
// cos(phi) e1 + sin(phi) e2.
template <typename F>
struct FrameTurn {
  F cosine, sine;
};

// `other`: the other frame's first axis.
template <typename F>
OMMA_HD FrameTurn<F> frame_turn(const Vector3<F>& e1, const Vector3<F>& e2,
                                const Vector3<F>& other) {
  const F c = dot(e1, other), s = dot(e2, other);
  return {c * c - s * s, 2.0f * (c * s)};
}

// What the other frame calls `other` is this in the frame turned from.
template <typename F>
OMMA_HD Stokes<F> operator*(const FrameTurn<F>& turn, const Stokes<F>& other) {
  return {other.i, other.q * turn.cosine - other.u * turn.sine,
          other.q * turn.sine + other.u * turn.cosine};
}

// What becomes of light along a whole path, from its far end to the eye.
template <typename F>
struct Mueller3 {
  F m[3][3];
};

template <typename F>
OMMA_HD Mueller3<F> identity_mueller() {
  const F zero = broadcast<F>(0.0f), one = broadcast<F>(1.0f);
  return {{{one, zero, zero}, {zero, one, zero}, {zero, zero, one}}};
}

// The path lengthened at its far end: by a frame's turn, by a reflection, by a surface whose light
// is polarised the same whatever falls on it.
template <typename F>
OMMA_HD Mueller3<F> operator*(const Mueller3<F>& path, const FrameTurn<F>& turn) {
  Mueller3<F> out;
  for (int r = 0; r < 3; ++r) {
    const F(&m)[3] = path.m[r];
    out.m[r][0] = m[0];
    out.m[r][1] = m[1] * turn.cosine + m[2] * turn.sine;
    out.m[r][2] = m[2] * turn.cosine - m[1] * turn.sine;
  }
  return out;
}

template <typename F>
OMMA_HD Mueller3<F> operator*(const Mueller3<F>& path, const Mueller<F>& reflection) {
  Mueller3<F> out;
  for (int r = 0; r < 3; ++r) {
    const F(&m)[3] = path.m[r];
    out.m[r][0] = m[0] * reflection.a + m[1] * reflection.b;
    out.m[r][1] = m[0] * reflection.b + m[1] * reflection.a;
    out.m[r][2] = m[2] * reflection.c;
  }
  return out;
}

template <typename F>
OMMA_HD Stokes<F> operator*(const Mueller3<F>& path, const Stokes<F>& s) {
  const auto row = [&](const F(&m)[3]) { return m[0] * s.i + m[1] * s.q + m[2] * s.u; };
  return {row(path.m[0]), row(path.m[1]), row(path.m[2])};
}

// `leaving`: what leaves the surface for each I that falls on it, of I 1.
template <typename F>
OMMA_HD Mueller3<F> depolarized(const Mueller3<F>& path, const Stokes<F>& leaving) {
  const Stokes<F> seen = path * leaving;
  const F zero = broadcast<F>(0.0f);
  return {{{seen.i, zero, zero}, {seen.q, zero, zero}, {seen.u, zero, zero}}};
}

// The axis s of a reflection that takes the ray `before` to the ray `after`, unit; where light goes
// back the way it came any axis across the ray is right, and `fallback` is taken.
template <typename F>
OMMA_HD Vector3<F> reflection_axis(const Vector3<F>& before, const Vector3<F>& after,
                                   const Vector3<F>& fallback) {
  const Vector3<F> s = cross(before, after);
  const F length2 = dot(s, s);
  // Below this, at 1e-4 rad, rounding turns the cross product by more than 1e-3 rad.
  const auto is_known = length2 > 1e-8f;
  const F scale = 1.0f / sqrt_lanes(is_known ? length2 : broadcast<F>(1.0f));
  return select(is_known, s * scale, fallback);
}

}  // namespace omma
