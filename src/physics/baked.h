// Light that was found before (omma/bake.h), looked up where rays meet surfaces: what a white, fully
// diffuse surface would send back of it, on the viewer's side and on the other.
#pragma once

#include "physics/block_memory.h"
#include "physics/hits.h"
#include "physics/lit_surface.h"

namespace omma {

// The least exponent of float that a value has: values are 2^-31 to 2, and 0.
inline constexpr std::uint32_t baked_exponent = 127 - 31;
inline constexpr float largest_baked = 2.0f - 0x1p-11f;

// Rounded to the nearest; x in [0, largest_baked], what is less than 2^-31 becomes 0.
OMMA_HD std::uint16_t encode_baked(float x) {
  if (!(x >= 0x1p-31f)) return 0;
  const auto bits = static_cast<std::uint32_t>(bits_of(x));
  const std::uint32_t rounded = (bits + 0x7ffu + (bits >> 12 & 1u)) >> 12;
  const std::uint32_t value = rounded - (baked_exponent << 11);
  // The least of all is that of zero: one more.
  return static_cast<std::uint16_t>(value < 1 ? 1 : (value > 0xffffu ? 0xffffu : value));
}

OMMA_HD float decode_baked(std::uint16_t value) {
  const std::uint32_t bits = (value + (baked_exponent << 11)) << 12;
  return float_of(static_cast<std::int32_t>(value == 0 ? 0u : bits));
}

// Cells of a triangle that is divided into k by k: strips along its first edge, in each cells that
// stand and cells that hang in turns. `u`, `v`: weights of the second and third corner.
OMMA_HD std::int32_t cell_at(std::int32_t k, float u, float v) {
  const float size = to_float(k);
  std::int32_t i = to_int(u * size), j = to_int(v * size);
  i = i > k - 1 ? k - 1 : i;
  j = j > k - 1 - i ? k - 1 - i : j;
  const bool hangs = (u * size - to_float(i)) + (v * size - to_float(j)) > 1.0f && i + j < k - 1;
  return i * (2 * k - i) + 2 * j + (hangs ? 1 : 0);
}

// Corners [corner][u, v] of such a cell.
OMMA_HD void corners_of_cell(std::int32_t k, std::int32_t cell, float (&uv)[3][2]) {
  std::int32_t i = 0, left = cell;
  while (left >= 2 * (k - i) - 1) left -= 2 * (k - i++) - 1;
  const std::int32_t j = left / 2, hangs = left % 2;
  const std::int32_t corner[3][2] = {{i + hangs, j + hangs},
                                     {i + 1 - hangs, j + hangs},
                                     {i + hangs, j + 1 - hangs}};
  for (int c = 0; c < 3; ++c)
    for (int a = 0; a < 2; ++a) uv[c][a] = to_float(corner[c][a]) / to_float(k);
}

// Into how many parts each edge of a triangle with so many cells is divided.
OMMA_HD std::int32_t divisions_of(std::int32_t cells) {
  return to_int(sqrtf(to_float(cells)) + 0.5f);
}

// The cell that lanes' rays met, asked for from memory; null where probes light them.
template <int n>
struct BakedPlaces {
  const std::uint16_t* cell[n];
};

template <typename L>
OMMA_HD void find_baked(const SceneView& scene, const Packet<L>& packet, const Hits<L>& hits,
                        BakedPlaces<L::count>& places) {
  const BakedView& baked = *scene.baked;
  const auto stride = static_cast<std::ptrdiff_t>(2 * scene.bands);
  for (int l = 0; l < L::count; ++l) {
    places.cell[l] = nullptr;
    if (hits.mesh[l] < 0) continue;
    const std::int32_t first = baked.first_cell[hits.instance[l]];
    if (first < 0 || baked.moves[hits.instance[l]] != 0) continue;
    std::int32_t cell = int_of(packet.rays.triangle[l]);
    const std::int32_t* of_triangle = baked.cell_of_triangle[hits.mesh[l]];
    if (of_triangle != nullptr) {
      const std::int32_t own = of_triangle[cell], count = of_triangle[cell + 1] - own;
      cell = own;
      if (count > 1) cell += cell_at(divisions_of(count), packet.rays.u[l], packet.rays.v[l]);
    }
    places.cell[l] = baked.values + stride * (first + static_cast<std::ptrdiff_t>(cell));
#if !defined(__CUDACC__)
    __builtin_prefetch(places.cell[l]);
#endif
  }
}

// By the eight probes about a place: of the three directions that a normal leans to, weighed by the
// squares of its components, which add up to 1 (the ambient cube of J. McTaggart, Half-Life 2 / Valve
// Source Shading, 2004).
OMMA_HD void eval_probes(const BakedView& baked, int bands, Vec3 position, Vec3 normal, float* out,
                         int band_stride) {
  for (int b = 0; b < bands; ++b) out[b * band_stride] = 0;
  const float* moved = baked.first_origin_m;
  const float at[3] = {position.x - moved[0], position.y - moved[1], position.z - moved[2]};
  const float n[3] = {normal.x, normal.y, normal.z};
  std::int32_t low[3];
  float along[3];
  for (int a = 0; a < 3; ++a) {
    const float most = to_float(baked.probes[a] - 1);
    const float place = (at[a] - baked.probe_origin_m[a]) / baked.probe_spacing_m[a];
    const float inside = fminf(fmaxf(place, 0.0f), most);
    low[a] = to_int(inside);
    low[a] = low[a] > baked.probes[a] - 2 ? baked.probes[a] - 2 : low[a];
    along[a] = inside - to_float(low[a]);
  }
  for (int corner = 0; corner < 8; ++corner) {
    float weight = 1;
    std::int32_t node[3];
    for (int a = 0; a < 3; ++a) {
      const int up = corner >> a & 1;
      node[a] = low[a] + up;
      weight *= up != 0 ? along[a] : 1.0f - along[a];
    }
    const std::ptrdiff_t probe =
        (static_cast<std::ptrdiff_t>(node[2]) * baked.probes[1] + node[1]) * baked.probes[0] +
        node[0];
    for (int a = 0; a < 3; ++a) {
      const std::uint16_t* values =
          baked.probe_values + (probe * 6 + 2 * a + (n[a] < 0.0f ? 1 : 0)) * bands;
      const float scale = weight * n[a] * n[a] * baked.unit;
      for (int b = 0; b < bands; ++b) out[b * band_stride] += scale * decode_baked(values[b]);
    }
  }
}

// Of the lanes in `lanes`, into memory.front and memory.back [band][lane]. Of surfaces that transmit
// nothing what is behind them is not read: it is left as zeros.
template <typename L>
OMMA_HD void eval_baked(const SceneView& scene, const Packet<L>& packet,
                        const BakedPlaces<L::count>& places, const HitGeometry<L>& geometry,
                        const LitSurface<L>& surface, unsigned lanes, const PathMemory& memory) {
  constexpr int n = L::count;
  const BakedView& baked = *scene.baked;
  for (int l = 0; l < n; ++l) {
    float* const front = memory.front + l;
    float* const back = memory.back + l;
    const bool is_lit = (lanes >> l & 1u) != 0;
    const bool is_sheet = is_lit && scene.scatter[surface.material[l]].transmittance != nullptr;
    const std::uint16_t* cell = places.cell[l];
    float near[most_bands], far[most_bands];
    if (!is_lit) {
      for (int b = 0; b < scene.bands; ++b) near[b] = 0;
    } else if (cell != nullptr) {
      float facing = 0;
      for (int r = 0; r < 3; ++r) facing += geometry.normal[r][l] * packet.rays.direction[r][l];
      const int side = facing > 0.0f ? scene.bands : 0;
      for (int b = 0; b < scene.bands; ++b) near[b] = decode_baked(cell[side + b]) * baked.unit;
      if (is_sheet)
        for (int b = 0; b < scene.bands; ++b)
          far[b] = decode_baked(cell[scene.bands - side + b]) * baked.unit;
    } else {
      const Vec3 position = {geometry.position[0][l], geometry.position[1][l],
                             geometry.position[2][l]};
      const Vec3 normal = {surface.normal[0][l], surface.normal[1][l], surface.normal[2][l]};
      eval_probes(baked, scene.bands, position, normal, near, 1);
      if (is_sheet) eval_probes(baked, scene.bands, position, normal * -1.0f, far, 1);
    }
    for (int b = 0; b < scene.bands; ++b) front[b * n] = near[b];
    for (int b = 0; b < scene.bands; ++b) back[b * n] = is_sheet ? far[b] : 0.0f;
  }
}

}  // namespace omma
