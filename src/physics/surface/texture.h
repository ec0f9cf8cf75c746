// Reading a texture: wrap modes, nearest and bilinear filtering in linear light (glTF 2.0, 3.8.4).
// Row 0 is v = 0, as in glTF. A footprint wider than a texel reads coarser levels of the image,
// mixed so that it is continuous in the width. One texture, any number of lanes (physics/lanes/lanes.h).
#pragma once

#include <type_traits>

#include "physics/lanes/lanes.h"
#include "physics/views/scene_view.h"

namespace omma {

// Linear RGBA, or a weight for each.
template <typename F>
struct Color {
  F r, g, b, a;
};

template <typename F>
OMMA_HD Color<F> operator+(const Color<F>& p, const Color<F>& q) {
  return {p.r + q.r, p.g + q.g, p.b + q.b, p.a + q.a};
}
template <typename F>
OMMA_HD Color<F> operator*(const Color<F>& p, const Color<F>& q) {
  return {p.r * q.r, p.g * q.g, p.b * q.b, p.a * q.a};
}
template <typename F>
OMMA_HD Color<F> operator*(const Color<F>& p, F s) {
  return {p.r * s, p.g * s, p.b * s, p.a * s};
}

// One level of a texture: the same for all lanes (I an integer), or one for each.
template <typename I>
struct TextureLevel {
  I first_texel, width, height;
};

// A texel of two words of two components each.
template <typename F, typename I>
OMMA_HD Color<F> load_linear16(const std::int32_t* linear16, I texel) {
  const Pair<I> words = gather_pair(linear16, texel);
  return {to_float(words.first & 0xffff), to_float((words.first >> 16) & 0xffff),
          to_float(words.second & 0xffff), to_float((words.second >> 16) & 0xffff)};
}

// The same of 8 bits.
template <typename F, typename I>
OMMA_HD Color<F> load_code(const TextureView& texture, I texel) {
  const I codes = gather_bytes(texture.codes, texel);
  const auto value = [&](int shift) {
    return to_float(gather(texture.value_of_code, (codes >> shift) & 0xff));
  };
  return {value(0), value(8), value(16), to_float(((codes >> 24) & 0xff) * 257)};
}

// In units of 1/65535 where the image is not of floats; eval_level scales.
template <typename F, typename I>
OMMA_HD Color<F> load_texel(const TextureView& texture, I texel) {
  if (texture.linear == nullptr) {
    if (texture.codes == nullptr) return load_linear16<F>(texture.linear16, texel);
    const I first = texel * 0, behind = texel - texture.width * texture.height;
    if (!any_lane(behind >= 0)) return load_code<F>(texture, texel);
    const Color<F> coarse = load_linear16<F>(texture.linear16, behind < 0 ? first : behind);
    if (!any_lane(behind < 0)) return coarse;
    const Color<F> fine = load_code<F>(texture, behind < 0 ? texel : first);
    return {behind < 0 ? fine.r : coarse.r, behind < 0 ? fine.g : coarse.g,
            behind < 0 ? fine.b : coarse.b, behind < 0 ? fine.a : coarse.a};
  }
  const Pair<F> red_green = gather_pair(texture.linear, texel * 2);
  const Pair<F> blue_alpha = gather_pair(texture.linear, texel * 2 + 1);
  return {red_green.first, red_green.second, blue_alpha.first, blue_alpha.second};
}

// Texture coordinate to texel units, in [0, size]. Coordinates are bounded (backend/shading_data),
// so that they have a fraction.
template <typename F, typename Size>
OMMA_HD F wrap_coordinate(F u, Wrap wrap, Size size) {
  if (wrap == Wrap::repeat) return (u - floor_lanes(u)) * size;
  if (wrap == Wrap::mirrored_repeat) {
    const F t = u - 2.0f * floor_lanes(0.5f * u);
    return (t > 1.0f ? 2.0f - t : t) * size;
  }
  return clamp_unit_lanes(u) * size;
}

// Texel index one before the first or one behind the last: goes round for repeat, stays for the
// other two (where a mirrored neighbour is the edge texel itself).
template <typename I, typename Size>
OMMA_HD I wrap_before(I i, Wrap wrap, Size size) {
  return i < 0 ? (wrap == Wrap::repeat ? i + size : i + 1) : i;
}
template <typename I, typename Size>
OMMA_HD I wrap_behind(I i, Wrap wrap, Size size) {
  return i >= size ? (wrap == Wrap::repeat ? i - size : i - 1) : i;
}

template <typename F, typename Level>
OMMA_HD Color<F> eval_level(const TextureView& texture, const Level& level, F u, F v) {
  const float unit = texture.linear == nullptr ? 1.0f / 65535.0f : 1.0f;
  const F x = wrap_coordinate(u, texture.wrap_u, to_float(level.width));
  const F y = wrap_coordinate(v, texture.wrap_v, to_float(level.height));
  if (texture.filter == Filter::nearest) {
    // On the far edge the texel before it, whatever the wrap mode.
    const auto i = wrap_behind(to_int(x), Wrap::clamp_to_edge, level.width);
    const auto j = wrap_behind(to_int(y), Wrap::clamp_to_edge, level.height);
    return load_texel<F>(texture, j * level.width + i + level.first_texel) * broadcast<F>(unit);
  }
  // The texel whose centre lies at or before the point, -1 to size - 1, and the one behind it.
  const auto i = to_int(x + 0.5f) - 1, j = to_int(y + 0.5f) - 1;
  const F fx = x - 0.5f - to_float(i), fy = y - 0.5f - to_float(j);
  const auto x0 = wrap_before(i, texture.wrap_u, level.width);
  const auto x1 = wrap_behind(i + 1, texture.wrap_u, level.width);
  const auto row0 = wrap_before(j, texture.wrap_v, level.height) * level.width + level.first_texel;
  const auto row1 =
      wrap_behind(j + 1, texture.wrap_v, level.height) * level.width + level.first_texel;
  const F upper = (1.0f - fy) * unit, lower = fy * unit;
  return load_texel<F>(texture, row0 + x0) * ((1.0f - fx) * upper) +
         load_texel<F>(texture, row0 + x1) * (fx * upper) +
         load_texel<F>(texture, row1 + x0) * ((1.0f - fx) * lower) +
         load_texel<F>(texture, row1 + x1) * (fx * lower);
}

// The finer of the two levels that a footprint reads and the weight of the next. Seen from level 0,
// level n has a variance of (4^n - 1)/4 texels^2 along each axis (physics/surface/footprint.h); in between
// the weight is such that the mixture has (width^2 - 1)/4. The level is the exponent of the width,
// so no logarithm is needed.
template <typename F, typename I>
struct FoundLevel {
  I level;
  F next;
};

// `width`: of the footprint, in texels of level 0, at least 0.
template <typename F>
OMMA_HD auto find_level(F width, std::int32_t last_level) {
  const F wide = width > 1.0f ? width : broadcast<F>(1.0f);
  const auto bits = bits_of(wide);
  const auto exponent = (bits >> 23) - 127;
  const F mantissa = float_of((bits & 0x007fffff) | 0x3f800000);
  const auto level = exponent < last_level ? exponent : exponent * 0 + last_level;
  const F next = (mantissa * mantissa - 1.0f) * (1.0f / 3.0f);
  using I = std::remove_const_t<decltype(exponent)>;
  return FoundLevel<F, I>{level, exponent < last_level ? next : broadcast<F>(0.0f)};
}

template <typename I>
OMMA_HD TextureLevel<I> level_of(const TextureView& texture, I level) {
  const I one = level * 0 + 1;
  return {gather(texture.first_texel, level), (((one * (texture.width - 1)) >> level) + 1),
          (((one * (texture.height - 1)) >> level) + 1)};
}

// A texture averaged over `width` texels of level 0. Up to 1 that is the texture itself.
template <typename F>
OMMA_HD Color<F> eval_texture(const TextureView& texture, F u, F v, F width) {
  if (texture.last_level == 0 || !any_lane(width > 1.0f))
    return eval_level(texture, TextureLevel<std::int32_t>{0, texture.width, texture.height}, u, v);
  const auto found = find_level(width, texture.last_level);
  const Color<F> fine = eval_level(texture, level_of(texture, found.level), u, v);
  if (!any_lane(found.next > 0.0f)) return fine;
  const auto behind = found.level < texture.last_level ? found.level + 1 : found.level;
  const Color<F> coarse = eval_level(texture, level_of(texture, behind), u, v);
  return fine * (1.0f - found.next) + coarse * found.next;
}

// The same of lanes that go together: called, as a surface may read ten textures. One lane's is a
// function of floats alone, which instruction sets would share (OMMA_HD).
template <typename F>
  requires(!std::is_same_v<F, float>)
OMMA_HD_CALLED Color<F> call_eval_texture(const TextureView& texture, F u, F v, F width) {
  return eval_texture(texture, u, v, width);
}
OMMA_HD_LARGE Color<float> call_eval_texture(const TextureView& texture, float u, float v, float width) {
  return eval_texture(texture, u, v, width);
}

}  // namespace omma
