// Light that was found before (omma/bake.h), looked up where rays meet surfaces: what a white,
// fully diffuse surface would send back of it, on the viewer's side and on the other.
#pragma once

#include "omma/baked_cell.h"
#include "physics/lanes/rows.h"
#include "physics/lanes/vector3.h"
#include "physics/path/path_light.h"

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

// Of a number, or of one for each lane.
template <typename I>
OMMA_HD auto decode_baked(I value) {
  const I bits = (value + static_cast<std::int32_t>(baked_exponent << 11)) * (1 << 12);
  return keep(value != 0, float_of(bits));
}
OMMA_HD float decode_baked(std::uint16_t value) {
  return decode_baked(std::int32_t{value});
}

// CellError's numbers.
OMMA_HD float decode_error(std::uint8_t code) {
  return static_cast<float>(code) * static_cast<float>(code) * 0x1p-14f;
}

// Cells of a triangle that is divided into k by k: strips along its first edge, in each cells that
// stand and cells that hang in turns. `u`, `v`: weights of the second and third corner.
template <typename F, typename I>
OMMA_HD I cell_at(I k, F u, F v) {
  const F size = to_float(k);
  I i = to_int(u * size), j = to_int(v * size);
  i = i > k - 1 ? k - 1 : i;
  j = j > k - 1 - i ? k - 1 - i : j;
  const auto hangs = (u * size - to_float(i)) + (v * size - to_float(j)) > 1.0f && i + j < k - 1;
  return i * (2 * k - i) + 2 * j + keep(hangs, i * 0 + 1);
}

// Corners [corner][u, v] of such a cell.
OMMA_HD void corners_of_cell(std::int32_t k, std::int32_t cell, float (&uv)[3][2]) {
  std::int32_t i = 0, left = cell;
  while (left >= 2 * (k - i) - 1) left -= 2 * (k - i++) - 1;
  const std::int32_t j = left / 2, hangs = left % 2;
  const std::int32_t corner[3][2] = {
      {i + hangs, j + hangs}, {i + 1 - hangs, j + hangs}, {i + hangs, j + 1 - hangs}};
  for (int c = 0; c < 3; ++c)
    for (int a = 0; a < 2; ++a) uv[c][a] = to_float(corner[c][a]) / to_float(k);
}

// Into how many parts each edge of a triangle with so many cells is divided.
template <typename I>
OMMA_HD I divisions_of(I cells) {
  return to_int(sqrt_lanes(to_float(cells)) + 0.5f);
}

// The cell that each lane's ray met, prefetched; null where probes light it.
template <typename L>
struct BakedLookup {
  const std::uint16_t* cell[L::count];
  LaneMask<L> from_behind;  // lanes whose rays come from behind, once light is read
};

template <typename L>
OMMA_HD void find_baked(const SceneView& scene, const Packet<L>& packet, const Hits<L>& hits,
                        BakedLookup<L>& found) {
  using F = typename L::F;
  using I = typename L::I;
  constexpr int n = L::count;
  const BakedView& baked = *scene.baked;
  const auto stride = static_cast<std::ptrdiff_t>(2 * scene.bands);
  alignas(n * 4) std::int32_t cells[n];  // in their instance
  for_each_mesh(hits, [&](std::int32_t mesh, int l, const auto& is_member) {
    I cell = keep(is_member, load<I>(packet.rays.triangle + l));
    const std::int32_t* of_triangle = baked.mesh_cells[mesh].first;
    if (of_triangle != nullptr) {
      const I own = gather(of_triangle, cell), count = gather(of_triangle + 1, cell) - own;
      const F u = load<F>(packet.rays.u + l), v = load<F>(packet.rays.v + l);
      cell = own + keep(is_member && count > 1, cell_at(divisions_of(count), u, v));
    }
    store(cells + l, is_member ? cell : load<I>(cells + l));
  });
  for (int l = 0; l < n; ++l) {
    found.cell[l] = nullptr;
    if (hits.mesh[l] < 0) continue;
    const std::int32_t first = baked.first_cell[hits.instance[l]];
    if (first < 0 || baked.moves[hits.instance[l]] != 0) continue;
    found.cell[l] = baked.values + stride * (first + static_cast<std::ptrdiff_t>(cells[l]));
    fetch_line(found.cell[l]);
  }
}

// By the eight probes about a place: of the three directions that a normal leans to, weighed by the
// squares of its components, which add up to 1 (the ambient cube of J. McTaggart, Half-Life 2 /
// Valve Source Shading, 2004).
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

// Of the lanes in `lanes`, into memory.front and memory.back [band][lane]. Of surfaces that
// transmit nothing what is behind them is not read: it is left as zeros.
template <typename L, typename Search>
OMMA_HD_CALLED void eval_baked(const Flight<L, Search>& flight, BakedLookup<L>& found,
                               const HitGeometry<L>& geometry, const LitSurface<L>& surface,
                               LaneMask<L> lanes) {
  using F = typename L::F;
  constexpr int n = L::count, width = L::width;
  const SceneView& scene = flight.scene;
  const PathMemory& memory = flight.memory;
  const BakedView& baked = *scene.baked;
  const LaneMask<L> from_behind = found.from_behind = lanes_where<L>([&](int l) {
    return dot(load_vector<F>(geometry.normal, l),
               load_vector<F>(flight.packet.rays.direction, l)) > 0.0f;
  });
  LaneMask<L> in_cells, sheets;
  lanes.for_each([&](int l) {
    if (found.cell[l] != nullptr) in_cells.add(l);
    if (scene.scatter[surface.material[l]].transmittance != nullptr) sheets.add(l);
  });
  const auto read_cells = [&](LaneMask<L> wanted, bool is_far, float* out) {
    for (int l = 0; l < n; l += width)
      store_rows<L>(
          scene.bands, wanted.word(l),
          [&](int k, const auto& read) {
            const bool is_back = from_behind.has(l + k);
            const std::uint16_t* side = found.cell[l + k] + (is_back != is_far ? scene.bands : 0);
            return decode_baked(read(side)) * baked.unit;
          },
          out + l);
  };
  read_cells(in_cells, false, memory.front);
  if (sheets.any()) {
    read_cells(in_cells & sheets, true, memory.back);
  } else {
    for (int i = 0; i < scene.bands * n; ++i) memory.back[i] = 0;
  }
  (lanes & ~in_cells).for_each([&](int l) {
    const Vec3 position = vec_at(geometry.position, l), normal = vec_at(surface.normal, l);
    eval_probes(baked, scene.bands, position, normal, memory.front + l, n);
    if (sheets.has(l))
      eval_probes(baked, scene.bands, position, normal * -1.0f, memory.back + l, n);
  });
}

}  // namespace omma
