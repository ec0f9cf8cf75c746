// A shadow map of the sun (Williams 1978, Casting curved shadows on curved surfaces): how high,
// along the direction towards the middle of its disc, the first surface lies that each ray of a
// grid from there meets. Made by backend/make_sun_map; a place is lit where nothing lies above it.
//
// The four rays about a place are asked, and what they say is bilinear, so that edges of shadows
// are ramps as wide as a texel. Each ray is compared with where it meets the plane of the triangle
// that the place lies on, not with the place itself: then no slope shades itself, and sheets that
// are close to each other still do. The sun counts as a point: shadows have no penumbra but that
// ramp.
//
// The map is a grid of pages, each of texels as fine as what lies there needs. Heights are codes of
// 16 bits, 0 for nothing, two to a word. They lie in tiles of 8 x 4 texels, a line of the cache,
// which share their last column and row with the next: the four about any place are in one tile.
#pragma once

#include <cstdint>

#include "physics/lanes/lanes.h"
#include "physics/rays/hits.h"

namespace omma {

inline constexpr std::int32_t sun_tile_columns = 7, sun_tile_rows = 3;  // without what is shared
inline constexpr std::int32_t sun_tile_words = 16;  // [8 x 4 texels], the even texel low
inline constexpr std::int32_t sun_row_words = 4;    // from a row of a tile to the next
inline constexpr std::int32_t sun_level_bits = 4;

struct alignas(16) SunPage {
  // The page's level, 2^level x 2^level tiles, and above sun_level_bits its first tile.
  std::int32_t tile_and_level = 0;
  float lowest_m = 0;  // the height of code 1
  float codes_per_m = 0;
  float texel_m = 0;
};

// Of positions in the traced frame: column, row and height are a dot product plus an offset.
struct SunMapView {
  const SunPage* pages = nullptr;  // [row][column]
  // [page][row of tiles][column of tiles][sun_tile_words], pages of different sizes.
  const std::int32_t* words = nullptr;
  std::int32_t page_columns = 0, page_rows = 0, tile_count = 0;
  float last_column = 0, last_row = 0;          // the greatest that may be looked up, pages
  float column_axis[3] = {}, row_axis[3] = {};  // unit, across the light
  float column_per_m = 0, row_per_m = 0, column_offset = 0, row_offset = 0;  // pages
  float towards[3] = {0, 1, 0};  // unit, to the middle of the sun's disc; heights are along it
  // How far in front of a surface, across it, others do not shade it: m, and texels.
  float bias_m = 0, bias_texels = 0;
};

// Slopes are cut off where less than this cosine of the sun's light arrives.
inline constexpr float least_sun_cosine = 0.01f;

// Where a place is looked up.
template <typename F>
struct SunMapLookup {
  decltype(to_int(F{})) page;
  decltype(to_int(F{})) word;    // of the nearest texel before it
  decltype(to_int(F{})) is_odd;  // 1: that is the high half of its word
  F along_column, along_row;     // beyond that texel, in texels
};

template <typename F>
OMMA_HD F along_axis(const Vector3<F>& v, const float (&axis)[3]) {
  return dot(v, vector_of(axis));
}

template <typename F>
OMMA_HD SunMapLookup<F> find_on_sun_map(const SunMapView& map, const Vector3<F>& position) {
  using I = decltype(to_int(F{}));
  // Places outside the map, and what is no number, go to its rim, where nothing is met.
  const auto page_at = [](F x, float last) {
    x = x > 0.0f ? x : broadcast<F>(0.0f);
    return x < last ? x : broadcast<F>(last);
  };
  const F column =
      page_at(along_axis(position, map.column_axis) * map.column_per_m + map.column_offset,
              map.last_column);
  const F row =
      page_at(along_axis(position, map.row_axis) * map.row_per_m + map.row_offset, map.last_row);
  const I i = to_int(column), j = to_int(row);
  SunMapLookup<F> place;
  place.page = j * map.page_columns + i;
  const I tile_and_level = gather(&map.pages->tile_and_level, place.page * 4);
  const I level = tile_and_level & ((1 << sun_level_bits) - 1);
  const F tiles = float_of((level + 127) << 23);
  // In texels of the page, and the tile that has them: half a texel on, the quotient is never near
  // a whole number.
  const F x = (column - to_float(i)) * tiles * static_cast<float>(sun_tile_columns);
  const F y = (row - to_float(j)) * tiles * static_cast<float>(sun_tile_rows);
  const I texel_column = to_int(x), texel_row = to_int(y);
  const I tile_column = to_int((to_float(texel_column) + 0.5f) * (1.0f / sun_tile_columns));
  const I tile_row = to_int((to_float(texel_row) + 0.5f) * (1.0f / sun_tile_rows));
  const I in_row = texel_column - tile_column * sun_tile_columns;
  const I in_column = texel_row - tile_row * sun_tile_rows;
  const I tile = (tile_and_level >> sun_level_bits) + tile_row * to_int(tiles) + tile_column;
  place.word = tile * sun_tile_words + in_column * sun_row_words + (in_row >> 1);
  place.is_odd = in_row & 1;
  place.along_column = x - to_float(texel_column);
  place.along_row = y - to_float(texel_row);
  return place;
}

// Asks for what eval_sun_map will read.
OMMA_HD void fetch_sun_map(const SunMapView& map, std::int32_t word) {
  fetch_line(map.words + word);
}

// The part of the sun that is seen, 0 to 1, from places on triangles with this unit normal; which
// of its sides is meant makes no difference.
template <typename F>
OMMA_HD F eval_sun_map(const SunMapView& map, const SunMapLookup<F>& place,
                       const Vector3<F>& position, const Vector3<F>& normal) {
  const F lowest_m = float_of(gather_pair(&map.pages->tile_and_level, place.page * 2).second);
  const Pair<F> scales = gather_pair(&map.pages->codes_per_m, place.page * 2);
  const F codes_per_m = scales.first, texel_m = scales.second;
  const F facing = along_axis(normal, map.towards);
  const F size = facing < 0.0f ? -facing : facing;
  const F per_cosine = 1.0f / (size > least_sun_cosine ? size : broadcast<F>(least_sun_cosine));
  // How much the triangle's plane rises from texel to texel, and how high it is at the first one.
  const F rise = (facing < 0.0f ? per_cosine : -per_cosine) * texel_m * codes_per_m;
  const F per_column = along_axis(normal, map.column_axis) * rise;
  const F per_row = along_axis(normal, map.row_axis) * rise;
  const F bias_m = (map.bias_m + map.bias_texels * texel_m) * per_cosine;
  const F height_m = along_axis(position, map.towards) - lowest_m + bias_m;
  const F here =
      height_m * codes_per_m + 1.0f - place.along_column * per_column - place.along_row * per_row;
  const auto is_odd = place.is_odd != 0;
  const F one = broadcast<F>(1.0f);
  F lit[2];
  for (int r = 0; r < 2; ++r) {
    const auto at = place.word + r * sun_row_words;
    const auto left = gather(map.words, at), right = gather(map.words, at + place.is_odd);
    const auto first = (is_odd ? left >> 16 : left) & 0xffff;
    const auto second = (is_odd ? right : right >> 16) & 0xffff;
    // At least 0: where nothing was met the code is 0, and that is lit.
    F plane[2] = {r == 0 ? here : here + per_row};
    plane[1] = plane[0] + per_column;
    for (F& x : plane) x = x > 0.0f ? x : broadcast<F>(0.0f);
    const F a = keep(to_float(first) <= plane[0], one);
    const F b = keep(to_float(second) <= plane[1], one);
    lit[r] = a + (b - a) * place.along_column;
  }
  return clamp_unit_lanes(lit[0] + (lit[1] - lit[0]) * place.along_row);
}

// The same for what a packet's rays met, [lane]. Lanes that met nothing get some number, 0 to 1.
template <typename L>
OMMA_HD_CALLED void eval_sun_map(const SunMapView& map, const HitGeometry<L>& geometry,
                                 float (&visible)[L::count]) {
  using F = typename L::F;
  using I = typename L::I;
  constexpr int n = L::count;
  SunMapLookup<F> places[n / L::width];
  for (int l = 0; l < n; l += L::width) {
    places[l / L::width] = find_on_sun_map(map, load_vector<F>(geometry.position, l));
    alignas(L::width * 4) std::int32_t word[L::width];
    store<I>(word, places[l / L::width].word);
    for (int k = 0; k < L::width; ++k) fetch_sun_map(map, word[k]);
  }
  for (int l = 0; l < n; l += L::width) {
    store(visible + l, eval_sun_map(map, places[l / L::width], load_vector<F>(geometry.position, l),
                                    load_vector<F>(geometry.normal, l)));
  }
}

}  // namespace omma
