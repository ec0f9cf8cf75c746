// Makes opacity maps: bounds of what reading the image can give in each piece of a triangle.
#include "backend/opacity_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <unordered_map>

#include "backend/alpha_blocks.h"
#include "physics/sampling/hash.h"
#include "physics/surface/opacity.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Of float: the most that rounding changes a number near 1.
constexpr double rounding = 0x1p-24;
// Numbers this small are taken for zero while rays are traced.
constexpr double least_number = 1e-36;
// Where alpha becomes larger, arithmetic could overflow.
constexpr double most_alpha = 1e30;

// Of 4^10 states, 256 KiB. A level of one state for four does not fill a word.
constexpr int most_level = 10, least_level = 2;
// Where only the alpha of vertices varies: 1024 states.
constexpr int level_without_image = 5;

// Where the alpha of a cut-out comes from, as eval_base_color has it.
struct CutOut {
  double factor = 1, cutoff = 0;
  const AlphaBlocks* image = nullptr;  // null where the image has no part in it
  const float* uvs = nullptr;          // [corner or vertex][2], with the image
  const float* colors = nullptr;       // [corner or vertex][4], or null
  const std::int32_t* vertex_of_corner = nullptr;
  std::int32_t material = 0;
};

// What decides about one triangle.
struct Corners {
  float u[3] = {}, v[3] = {};  // texture coordinates
  float alpha[3] = {1, 1, 1};  // of vertex colours
};

Corners corners_of(const CutOut& cut_out, std::size_t triangle) {
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k) {
    std::size_t at = 3 * triangle + k;
    if (cut_out.vertex_of_corner != nullptr)
      at = static_cast<std::size_t>(cut_out.vertex_of_corner[at]);
    if (cut_out.image != nullptr) {
      corners.u[k] = cut_out.uvs[2 * at];
      corners.v[k] = cut_out.uvs[2 * at + 1];
    }
    if (cut_out.colors != nullptr) corners.alpha[k] = cut_out.colors[4 * at + 3];
  }
  return corners;
}

// Three values interpolated in floats, a w + b u + c v with w = 1 - u - v, are off by at most 2
// ulps of w, one for each product and two for the sums: less than 8 roundings of |a| + |b| + |c|.
// Weights outside the triangle add the overhang times how the value changes.
double interpolation_margin(const float (&value)[3]) {
  double sum = 0, change = 0;
  for (const float x : value) {
    sum += std::fabs(static_cast<double>(x));
    change = std::max(change, std::fabs(static_cast<double>(x) - value[0]));
  }
  return 8 * rounding * sum + 4 * static_cast<double>(opacity_overhang) * change + least_number;
}

// The same in texels, and what follows: wrapping rounds twice near 1 at most, the multiplication by
// the size and the steps to the texel's centre once each near the size.
double texel_margin(const float (&coordinate)[3], int size) {
  return size * (interpolation_margin(coordinate) + 8 * rounding) + 0x1p-20;
}

// Texel alpha t for which factor x t x vertex alpha is on one side of the cutoff, whatever the
// rounding. A mean of texels in floats has at most 12 roundings in each of its terms, and weights
// that lie outside [0, 1] by one: it is off by less than 32 roundings of the largest texel. The two
// products add less than 4.
AlphaLimits limits_of(const CutOut& cut_out, AlphaRange texels, double least_vertex,
                      double most_vertex) {
  AlphaLimits limits{std::numeric_limits<double>::infinity(),
                     -std::numeric_limits<double>::infinity()};
  const double most_texel = std::max(std::fabs(static_cast<double>(texels.least)),
                                     std::fabs(static_cast<double>(texels.most)));
  const double largest = std::max(1.0, cut_out.factor) * std::max(1.0, most_texel) *
                         std::max({1.0, most_vertex, -least_vertex});
  if (!(largest < most_alpha)) return limits;
  const double tiny = least_number * largest, mean_error = 32 * rounding * most_texel;
  const double least_factor = cut_out.factor * least_vertex * (1 - 8 * rounding);
  const double most_factor = cut_out.factor * most_vertex * (1 + 8 * rounding);
  if (least_factor > tiny)
    limits.opaque_from = mean_error + (std::max(cut_out.cutoff, 0.0) + tiny) / least_factor;
  // Two negative numbers, or a mean that is negative by its rounding, make a product above zero.
  const double of_negatives = std::max(0.0, -least_vertex) * cut_out.factor *
                              (texels.least < 0 ? 2 * most_texel : mean_error);
  if (cut_out.cutoff > tiny + 2 * of_negatives)
    limits.transparent_below = (cut_out.cutoff - tiny) / std::max(most_factor, tiny) - mean_error;
  return limits;
}

// A triangle being mapped.
struct Mapped {
  const CutOut& cut_out;
  Corners corners;
  double x[3] = {}, y[3] = {};  // corners in texels
  double margin_x = 0, margin_y = 0, margin_alpha = 0;
  AlphaLimits limits = {};  // for all of it, where its corners have the same alpha
};

AlphaLimits limits_of(const Mapped& m, double least_vertex, double most_vertex) {
  const AlphaBlocks* const image = m.cut_out.image;
  const AlphaRange texels =
      image == nullptr ? AlphaRange{1, 1} : image->levels.back().ranges.front();
  return limits_of(m.cut_out, texels, least_vertex - m.margin_alpha, most_vertex + m.margin_alpha);
}

bool has_one_alpha(const Corners& corners) {
  return corners.alpha[0] == corners.alpha[1] && corners.alpha[0] == corners.alpha[2];
}

Mapped map_triangle(const CutOut& cut_out, std::size_t triangle) {
  Mapped m{cut_out, corners_of(cut_out, triangle)};
  m.margin_alpha = interpolation_margin(m.corners.alpha);
  m.limits = limits_of(m, m.corners.alpha[0], m.corners.alpha[0]);
  if (cut_out.image == nullptr) return m;
  const TextureView& texture = cut_out.image->texture;
  for (int k = 0; k < 3; ++k) {
    m.x[k] = static_cast<double>(m.corners.u[k]) * texture.width;
    m.y[k] = static_cast<double>(m.corners.v[k]) * texture.height;
  }
  m.margin_x = texel_margin(m.corners.u, texture.width);
  m.margin_y = texel_margin(m.corners.v, texture.height);
  return m;
}

// What is known of the half of a square of `size` squares of the finest level, of which there are
// `side` a side; (i, j) is the first of them.
struct Piece {
  int i = 0, j = 0, size = 1, half = 0;
};

Opacity state_of(const Mapped& m, const Piece& piece, int side) {
  const double a = static_cast<double>(piece.i) / side, b = static_cast<double>(piece.j) / side;
  const double d = static_cast<double>(piece.size) / side;
  const bool other = piece.half != 0;
  const double u[3] = {other ? a + d : a, other ? a : a + d, other ? a + d : a};
  const double v[3] = {other ? b + d : b, other ? b + d : b, other ? b : b + d};
  const auto at = [&](const auto& value, int k) {
    return value[0] + (value[1] - static_cast<double>(value[0])) * u[k] +
           (value[2] - static_cast<double>(value[0])) * v[k];
  };
  AlphaLimits limits = m.limits;
  if (!has_one_alpha(m.corners)) {
    double alpha[3];
    for (int k = 0; k < 3; ++k) alpha[k] = at(m.corners.alpha, k);
    const auto [least, most] = std::minmax_element(alpha, alpha + 3);
    limits = limits_of(m, *least, *most);
  }
  if (m.cut_out.image == nullptr) {
    if (1 >= limits.opaque_from) return Opacity::opaque;
    return 1 < limits.transparent_below ? Opacity::transparent : Opacity::ask;
  }
  TexelTriangle triangle{{}, {}, m.margin_x, m.margin_y};
  for (int k = 0; k < 3; ++k) {
    triangle.x[k] = at(m.x, k);
    triangle.y[k] = at(m.y, k);
  }
  return kind_of_texels(*m.cut_out.image, limits, triangle);
}

std::array<Piece, 4> quarters(const Piece& p) {
  const int h = p.size / 2, k = p.half * h;
  return {{{p.i + k, p.j + k, h, p.half},
           {p.i + h, p.j, h, p.half},
           {p.i, p.j + h, h, p.half},
           {p.i + k, p.j + k, h, 1 - p.half}}};
}

void put(std::int32_t* states, std::int32_t index, Opacity state) {
  std::int32_t& word = states[index >> 4];
  word = static_cast<std::int32_t>(static_cast<std::uint32_t>(word) |
                                   static_cast<std::uint32_t>(state) << 2 * (index & 15));
}

// Fills in the states of a piece that is all in `state`, or must be looked at where that is `ask`.
void fill(const Mapped& m, const Piece& p, int level, Opacity state, std::int32_t* states) {
  if (level >= first_tiled_opacity_level && p.size == 1 << opacity_tile_level) {
    const OpacityPiece tile{p.i >> opacity_tile_level, p.j >> opacity_tile_level, p.half};
    put(states, row_by_row(level - opacity_tile_level, tile), state);
    if (state != Opacity::ask) return;  // nothing reads the tile
    check_cancelled();
  }
  if (p.size == 1) {
    const OpacityPiece piece{p.i, p.j, p.half};
    put(states, opacity_index(level, piece, coarser_piece(piece, opacity_tile_level)), state);
    return;
  }
  for (const Piece& quarter : quarters(p))
    fill(m, quarter, level, state == Opacity::ask ? state_of(m, quarter, 1 << level) : state,
         states);
}

// At which states are about as large as texels.
int wanted_level(const Mapped& m) {
  if (m.cut_out.image == nullptr) return level_without_image;
  const double area = 0.5 * std::fabs((m.x[1] - m.x[0]) * (m.y[2] - m.y[0]) -
                                      (m.x[2] - m.x[0]) * (m.y[1] - m.y[0]));
  int level = least_level;
  while (level < most_level && std::ldexp(1.0, 2 * level) < area) ++level;
  return level;
}

std::size_t words_of(int level) {
  if (level < least_level) return 0;
  const std::size_t finest = std::size_t(1) << 2 * level;
  return (finest + (level < first_tiled_opacity_level ? 0 : finest >> 2 * opacity_tile_level)) / 16;
}

// A triangle that is neither wholly opaque nor wholly transparent.
struct Mixed {
  std::size_t cut_out = 0, triangle = 0;
  int level = 0;
  std::size_t first_word = 0;
};

// Mixed triangles without duplicates: those with the same corners in the same image are one, as
// most cards of leaves are.
struct MixedTriangles {
  const std::vector<CutOut>& cut_outs;
  std::vector<Mixed> distinct = {};
  std::unordered_map<std::uint64_t, std::size_t> of_hash = {};

  // Index into `distinct`.
  std::size_t find(std::size_t cut_out, std::size_t triangle) {
    const CutOut& c = cut_outs[cut_out];
    const Corners corners = corners_of(c, triangle);
    std::uint64_t hash = static_cast<std::uint64_t>(c.material);
    std::uint64_t bits[(sizeof corners + 7) / 8] = {};
    std::memcpy(bits, &corners, sizeof corners);
    for (const std::uint64_t b : bits) hash = hash_combine(hash, b);
    const auto [known, is_new] = of_hash.try_emplace(hash, distinct.size());
    if (!is_new) {
      const Mixed& other = distinct[known->second];
      const CutOut& d = cut_outs[other.cut_out];
      const Corners same = corners_of(d, other.triangle);
      if (d.material == c.material && d.image == c.image && d.factor == c.factor &&
          std::memcmp(&same, &corners, sizeof corners) == 0)
        return known->second;
    }
    distinct.push_back({cut_out, triangle});
    return distinct.size() - 1;
  }
};

// Assigns each triangle its words in the table of states: at the level that it wants, or where
// memory is short at most at the finest common level that fits. Returns the number of words.
std::size_t place_states(const std::vector<CutOut>& cut_outs, std::vector<Mixed>& distinct,
                         std::size_t most_words) {
  parallel_for(std::size_t{0}, distinct.size(), [&](std::size_t i) {
    Mixed& mixed = distinct[i];
    mixed.level = wanted_level(map_triangle(cut_outs[mixed.cut_out], mixed.triangle));
  });
  for (int finest = most_level;; --finest) {
    std::size_t words = 0;
    for (Mixed& mixed : distinct) {
      mixed.level = std::min(mixed.level, finest);
      mixed.first_word = words;
      words += words_of(mixed.level);
    }
    if (words <= most_words) return words;
  }
}

// As physics/surface/opacity.h has it.
std::int32_t word_of(const Mixed& mixed) {
  if (mixed.level < least_level) return static_cast<std::int32_t>(Opacity::ask);
  return static_cast<std::int32_t>(mixed.first_word << opacity_level_bits) | mixed.level;
}

// Of the states of a scene with so many triangles of cut-outs; a word of a triangle has 28 bits for
// where they begin.
std::size_t most_words(std::size_t triangles) {
  const std::size_t bytes = most_opacity_bytes + most_opacity_bytes_per_triangle * triangles;
  return std::min(bytes / sizeof(std::int32_t), std::size_t(1) << (32 - opacity_level_bits));
}

}  // namespace

OpacityMaps make_opacity_maps(const SceneView& scene,
                              std::span<const std::size_t> triangle_counts) {
  OpacityMaps maps;
  maps.triangles.resize(triangle_counts.size());
  std::vector<CutOut> cut_outs;
  std::vector<std::size_t> mesh_of_cut_out;
  std::map<std::int32_t, AlphaBlocks> image_of_texture;
  std::size_t triangles = 0;
  for (std::size_t mesh = 0; mesh < triangle_counts.size(); ++mesh) {
    const MeshView& view = scene.meshes[mesh];
    const MaterialView& material = scene.materials[view.material];
    if (material.alpha_mode != AlphaMode::mask || triangle_counts[mesh] == 0) continue;
    CutOut cut_out{material.base_color.w, material.alpha_cutoff, nullptr,      view.base_uv,
                   view.colors,           view.vertex_of_corner, view.material};
    const bool color_alone = scene.power_22 != nullptr && view.colors != nullptr;
    if (color_alone) cut_out.factor = 1;
    if (view.base_uv != nullptr && !color_alone) {
      const std::int32_t texture = material.base_texture;
      if (!image_of_texture.contains(texture))
        image_of_texture.emplace(texture, make_alpha_blocks(scene.textures[texture]));
      cut_out.image = &image_of_texture.at(texture);
    }
    cut_outs.push_back(cut_out);
    mesh_of_cut_out.push_back(mesh);
    triangles += triangle_counts[mesh];
  }

  // First the state of each triangle as a whole; for mixed ones, less than zero, which of them.
  MixedTriangles mixed{cut_outs};
  for (std::size_t c = 0; c < cut_outs.size(); ++c) {
    const std::size_t mesh = mesh_of_cut_out[c];
    std::vector<std::int32_t>& words = maps.triangles[mesh];
    words.resize(triangle_counts[mesh]);
    parallel_for(std::size_t{0}, words.size(), [&](std::size_t t) {
      const Opacity state = state_of(map_triangle(cut_outs[c], t), {}, 1);
      words[t] = static_cast<std::int32_t>(state) << opacity_level_bits;
    });
    for (std::size_t t = 0; t < words.size(); ++t) {
      if (t % 1024 == 0) check_cancelled();
      if (words[t] == 0) words[t] = -1 - static_cast<std::int32_t>(mixed.find(c, t));
    }
  }

  maps.states.resize(place_states(cut_outs, mixed.distinct, most_words(triangles)));
  parallel_for(std::size_t{0}, mixed.distinct.size(), [&](std::size_t i) {
    const Mixed& one = mixed.distinct[i];
    if (one.level < least_level) return;
    const Mapped m = map_triangle(cut_outs[one.cut_out], one.triangle);
    fill(m, {0, 0, 1 << one.level}, one.level, Opacity::ask, maps.states.data() + one.first_word);
  });
  for (std::vector<std::int32_t>& words : maps.triangles)
    for (std::int32_t& word : words)
      if (word < 0) word = word_of(mixed.distinct[static_cast<std::size_t>(-1 - word)]);
  return maps;
}

}  // namespace omma
