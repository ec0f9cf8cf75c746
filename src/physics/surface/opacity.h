// What is known of a cut-out before its image is asked: an opacity micromap (Gruen, Benthin, Woop
// 2020, Sub-triangle opacity masks for faster ray tracing of transparent objects). A triangle is
// cut into 4^level equal ones, each of which is surely there, surely not, or to be asked of the
// image. backend/opacity_maps makes them.
//
// A mesh has a word for each triangle: the lowest 4 bits are the level, those above them, at level
// 0, the state of all of the triangle, else where its states begin among those of the scene, which
// triangles that are cut out alike share. States are two bits each, 16 to a word, the first lowest,
// row by row of constant v: rows grow shorter, and in each a piece with the corner at the smaller u
// and v comes before the one that completes its square. From level 6 on the states of the level
// four before come first, which are few enough to stay in a cache and often suffice; then those of
// the level itself follow tile by tile, a tile being a piece of that coarser level and a line of
// the cache.
#pragma once

#include <cstdint>

#include "omma/vec.h"

namespace omma {

enum class Opacity : std::int32_t { ask = 0, transparent = 1, opaque = 2 };

inline constexpr int opacity_level_bits = 4;

// Tracers find weights that are outside [0, 1] by their rounding; further out nothing is known.
inline constexpr float opacity_overhang = 1e-6f;

inline constexpr std::int32_t opacity_tile_level = 4;
inline constexpr std::int32_t first_tiled_opacity_level = 6;

// A piece of a triangle: which half of the square (i, j), of 2^level squares a side.
struct OpacityPiece {
  std::int32_t i, j, half;
};

OMMA_HD std::int32_t row_by_row(std::int32_t level, const OpacityPiece& p) {
  return p.j * ((2 << level) - p.j) + 2 * p.i + p.half;
}

// The piece of a coarser level that it lies in.
OMMA_HD OpacityPiece coarser_piece(const OpacityPiece& p, std::int32_t levels) {
  const std::int32_t mask = (1 << levels) - 1;
  return {p.i >> levels, p.j >> levels, (p.i & mask) + (p.j & mask) + p.half > mask ? 1 : 0};
}

// Where in the states of a triangle that of a piece is. `coarser`: that it lies in, by the levels
// of a tile.
OMMA_HD std::int32_t opacity_index(std::int32_t level, const OpacityPiece& p,
                                   const OpacityPiece& coarser) {
  if (level < first_tiled_opacity_level) return row_by_row(level, p);
  constexpr std::int32_t mask = (1 << opacity_tile_level) - 1;
  OpacityPiece in_tile{p.i & mask, p.j & mask, p.half};
  if (coarser.half != 0) in_tile = {mask - in_tile.i, mask - in_tile.j, 1 - in_tile.half};
  const std::int32_t coarse_level = level - opacity_tile_level;
  const std::int32_t tile = row_by_row(coarse_level, coarser);
  return (1 << 2 * coarse_level) + (tile << 2 * opacity_tile_level) +
         row_by_row(opacity_tile_level, in_tile);
}

OMMA_HD Opacity opacity_at(const std::int32_t* states, std::int32_t index) {
  const auto sixteen = static_cast<std::uint32_t>(states[index >> 4]);
  return static_cast<Opacity>(sixteen >> 2 * (index & 15) & 3u);
}

// At barycentric weights u, v of the second and third corner of a triangle with that word.
OMMA_HD Opacity find_opacity(std::int32_t of_triangle, const std::int32_t* states, float u,
                             float v) {
  const auto word = static_cast<std::uint32_t>(of_triangle);
  const auto level = static_cast<std::int32_t>(word & ((1u << opacity_level_bits) - 1));
  const std::uint32_t rest = word >> opacity_level_bits;
  // Written so that what is not a number is asked too.
  if (!(u > -opacity_overhang && v > -opacity_overhang && u + v < 1.0f + opacity_overhang))
    return Opacity::ask;
  if (level == 0) return static_cast<Opacity>(rest);
  const std::int32_t side = 1 << level;
  const float x = u * static_cast<float>(side), y = v * static_cast<float>(side);
  const auto i = static_cast<std::int32_t>(x), j = static_cast<std::int32_t>(y);
  const OpacityPiece piece{
      i, j, (x - static_cast<float>(i)) + (y - static_cast<float>(j)) > 1.0f ? 1 : 0};
  if (i + j + piece.half >= side) return Opacity::ask;  // on the far edge, or beyond it
  const std::int32_t* of_this = states + rest;
  const OpacityPiece coarser = coarser_piece(piece, opacity_tile_level);
  if (level >= first_tiled_opacity_level) {
    const Opacity coarse = opacity_at(of_this, row_by_row(level - opacity_tile_level, coarser));
    if (coarse != Opacity::ask) return coarse;
  }
  return opacity_at(of_this, opacity_index(level, piece, coarser));
}

}  // namespace omma
