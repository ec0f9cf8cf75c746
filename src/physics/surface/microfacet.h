// A rough boundary as small mirrors whose normals follow GGX (Walter et al. 2007), each hidden by
// others as Smith's height-correlated rule says (Heitz 2014). All in the frame of the surface: z is
// its normal, `o` the direction to the viewer and `w` to the light, both unit and above it.
#pragma once

#include "physics/surface/diffuse.h"

namespace omma {

// glTF's roughness (its specification 2.0, appendix B.2.3: alpha = roughness^2) counts as no less
// than this, which is taken for a mirror: half of its rays go within 2 alpha = 0.06 deg of the
// mirror's. A float's rounding moves the half vector by 1e-7, or 5e-5 at grazing angles where
// |o + w| is 1e-3, and must stay small beside alpha; and the density of normals, 1 / (pi alpha^2),
// stays far from the largest float.
inline constexpr float least_roughness = 0.0225f;

template <typename F>
OMMA_HD F microfacet_alpha(F roughness) {
  const F r = roughness > least_roughness ? roughness : broadcast<F>(least_roughness);
  return r * r;
}

// sqrt(alpha^2 + (1 - alpha^2) cos^2): Smith's Lambda is (this / cos - 1) / 2 (Heitz 2014, equation
// 72).
template <typename F>
OMMA_HD F smith_root(F cosine, F alpha) {
  const F alpha2 = alpha * alpha;
  return sqrt_lanes(alpha2 + (1.0f - alpha2) * (cosine * cosine));
}

// The half vector of o and w.
template <typename F>
struct HalfVector {
  F density;  // D of it (Walter et al. 2007, equation 33), per sr
  F cosine;   // between it and o, or w
};

// From o + w as it is, not from its cosine to the normal, whose rounding alone would be as wide as
// a mirror's lobe.
template <typename F>
OMMA_HD HalfVector<F> half_vector(const LocalDirection<F>& o, const LocalDirection<F>& w, F alpha) {
  const F x = o.x + w.x, y = o.y + w.y, z = o.z + w.z;
  const F across2 = x * x + y * y, along2 = z * z, length2 = across2 + along2;
  const F alpha2 = alpha * alpha, spread = alpha2 * along2 + across2;
  const F ratio = length2 / spread;
  return {inverse_pi * alpha2 * (ratio * ratio), 0.5f * sqrt_lanes(length2)};
}

// D G2 / (4 cos_o cos_w) times cos_w, all without the Fresnel factor (Walter et al. 2007, equation
// 20; G2 of Heitz 2014, equation 99). `root_o`: smith_root of o.
template <typename F>
OMMA_HD F eval_microfacet(F density, F cos_o, F root_o, F cos_w, F alpha) {
  return 0.5f * density * cos_w / (cos_w * root_o + cos_o * smith_root(cos_w, alpha));
}

// Density of the directions that sample_microfacet gives, per sr: G1 D / (4 cos_o) (Heitz 2018,
// equations 3 and 17). The rest, up to 1, are directions below the horizon.
template <typename F>
OMMA_HD F microfacet_pdf(F density, F cos_o, F root_o) {
  return 0.5f * density / (cos_o + root_o);
}

// Mirrored at a normal among those that the viewer sees: Dupuy and Benyoub 2023, listing 3
// (spherical caps). May be below the horizon: light that would meet the surface again.
template <typename F>
OMMA_HD LocalDirection<F> sample_microfacet(const LocalDirection<F>& o, F alpha, F u0, F u1) {
  // The viewer of the hemisphere that the surface is when stretched by 1 / alpha.
  F x = alpha * o.x, y = alpha * o.y, z = o.z;
  const F unit = 1.0f / sqrt_lanes(x * x + y * y + z * z);
  x = x * unit;
  y = y * unit;
  z = z * unit;
  // A point of the cap, whose height is 1 - below, added to the viewer.
  const F below = u0 * (1.0f + z), square = below * (2.0f - below);
  const F radius = sqrt_lanes(square > 0.0f ? square : broadcast<F>(0.0f));
  const SineCosine<F> a = sine_cosine((2.0f * u1 - 1.0f) * 3.14159265f);
  const F hx = alpha * (x + radius * a.cosine), hy = alpha * (y + radius * a.sine);
  const F hz = (1.0f + z) * (1.0f - u0);
  const F twice = 2.0f * (o.x * hx + o.y * hy + o.z * hz) / (hx * hx + hy * hy + hz * hz + 1e-30f);
  return {twice * hx - o.x, twice * hy - o.y, twice * hz - o.z};
}

}  // namespace omma
