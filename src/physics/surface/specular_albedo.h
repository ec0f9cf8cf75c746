// How much of the light from all sides a rough dielectric's boundary sends towards the viewer, or,
// which is the same, how much of a narrow beam it reflects: the directional albedo E of its lobe
// (microfacet.h with Fresnel's reflectance). The rest goes in, and comes out diffusely. And Q, how
// polarised light is that is reflected so from all sides: across the plane of view and normal less
// in it, as a fraction of the light. A table for each ior (backend/albedo_tables.h), read in lanes.
//
// Near grazing angles E changes where the cosine is about alpha. So a row's nodes are even in
// log(1 + cosine / alpha), and rows in the fourth root of the roughness, from that of a mirror on:
// linear between, within 1e-3 for any ior up to 2, 1.4e-3 up to 3, and E within 4e-3 of facets that
// reflect all, a white metal's (tests/cpp/physics_specular_albedo.cpp).
#pragma once

#include "physics/surface/microfacet.h"

namespace omma {

inline constexpr int albedo_rows = 32, albedo_cosines = 64;
// [row][cosine][E, how much more it is at the next node], [row][mean of E over cosines, how much
// more it is in the next row], and Q as E.
inline constexpr int first_polarized_albedo = albedo_rows * albedo_cosines + albedo_rows;
inline constexpr int albedo_floats = (2 * albedo_rows * albedo_cosines + albedo_rows) * 2;

// Where a roughness is, in one of some tables that lie one behind the other.
template <typename F>
struct AlbedoRow {
  decltype(to_int(F{})) table, row;
  F part;              // of the way to the next row
  F per_alpha, scale;  // nodes of a cosine: scale * log(1 + per_alpha * cosine)
};

// `table`: its number.
template <typename F>
OMMA_HD AlbedoRow<F> find_albedo_row(F roughness, decltype(to_int(F{})) table) {
  constexpr float first = 0.387298335f;  // fourth root of least_roughness
  const F alpha = microfacet_alpha(roughness);
  const F fourth_root = sqrt_lanes(sqrt_lanes(sqrt_lanes(alpha)));
  F place = (fourth_root - first) * (static_cast<float>(albedo_rows - 1) / (1.0f - first));
  place = place > 0.0f ? place : broadcast<F>(0.0f);
  AlbedoRow<F> at;
  at.table = table;
  at.row = to_int(place);
  at.row = at.row < albedo_rows - 2 ? at.row : at.row * 0 + (albedo_rows - 2);
  at.part = place - to_float(at.row);
  at.per_alpha = 1.0f / alpha;
  at.scale = static_cast<float>(albedo_cosines - 1) / log_lanes(1.0f + at.per_alpha);
  return at;
}

// E at a cosine in [0, 1]; of Q from first_polarized_albedo on.
template <typename F>
OMMA_HD F eval_albedo(const float* tables, const AlbedoRow<F>& at, F cosine, int first = 0) {
  const F place = at.scale * log_lanes(1.0f + at.per_alpha * cosine);
  auto node = to_int(place);
  node = node < albedo_cosines - 2 ? node : node * 0 + (albedo_cosines - 2);
  const F part = place - to_float(node);
  const auto index = at.table * (albedo_floats / 2) + at.row * albedo_cosines + node + first;
  const Pair<F> a = gather_pair(tables, index), b = gather_pair(tables, index + albedo_cosines);
  const F here = a.first + part * a.second, next = b.first + part * b.second;
  return here + at.part * (next - here);
}

// The mean of E over cosines, 2 integral E(c) c dc.
template <typename F>
OMMA_HD F eval_mean_albedo(const float* tables, const AlbedoRow<F>& at) {
  const auto index = at.table * (albedo_floats / 2) + albedo_rows * albedo_cosines + at.row;
  const Pair<F> mean = gather_pair(tables, index);
  return mean.first + at.part * mean.second;
}

}  // namespace omma
