// Reading a texture: wrap modes, nearest and bilinear filtering in linear light (glTF 2.0, 3.8.4).
// Row 0 is v = 0, as in glTF. One texture, any number of lanes (kernel/lanes.h).
#pragma once

#include "kernel/lanes.h"
#include "kernel/scene_view.h"

namespace omma {

// In units of 1/65535 for 16-bit images; eval_texture scales.
template <typename F, typename I>
OMMA_HD Color<F> load_texel(const TextureView& texture, I x, I y) {
  const I texel = y * texture.width + x;
  if (texture.linear16 != nullptr) {
    // A texel is two words of two components each.
    const Pair<I> words = gather_pair(texture.linear16, texel);
    return {to_float(words.first & 0xffff), to_float((words.first >> 16) & 0xffff),
            to_float(words.second & 0xffff), to_float((words.second >> 16) & 0xffff)};
  }
  const Pair<F> red_green = gather_pair(texture.linear, texel * 2);
  const Pair<F> blue_alpha = gather_pair(texture.linear, texel * 2 + 1);
  return {red_green.first, red_green.second, blue_alpha.first, blue_alpha.second};
}

// Texture coordinate to texel units, in [0, size]. Coordinates are bounded (backend/shading_data),
// so that they have a fraction.
template <typename F>
OMMA_HD F wrap_coordinate(F u, Wrap wrap, float size) {
  if (wrap == Wrap::repeat) return (u - floor_lanes(u)) * size;
  if (wrap == Wrap::mirrored_repeat) {
    const F t = u - 2.0f * floor_lanes(0.5f * u);
    return (t > 1.0f ? 2.0f - t : t) * size;
  }
  return clamp_unit_lanes(u) * size;
}

// Texel index one before the first or one behind the last: goes round for repeat, stays for the
// other two (where a mirrored neighbour is the edge texel itself).
template <typename I>
OMMA_HD I wrap_before(I i, Wrap wrap, int size) {
  const int round = wrap == Wrap::repeat ? size : 1;
  return i < 0 ? i + round : i;
}
template <typename I>
OMMA_HD I wrap_behind(I i, Wrap wrap, int size) {
  const int round = wrap == Wrap::repeat ? size : 1;
  return i >= size ? i - round : i;
}

template <typename F>
OMMA_HD Color<F> eval_texture(const TextureView& texture, F u, F v) {
  const float unit = texture.linear16 != nullptr ? 1.0f / 65535.0f : 1.0f;
  const F x = wrap_coordinate(u, texture.wrap_u, static_cast<float>(texture.width));
  const F y = wrap_coordinate(v, texture.wrap_v, static_cast<float>(texture.height));
  if (texture.filter == Filter::nearest) {
    // On the far edge the texel before it, whatever the wrap mode.
    const auto i = wrap_behind(to_int(x), Wrap::clamp_to_edge, texture.width);
    const auto j = wrap_behind(to_int(y), Wrap::clamp_to_edge, texture.height);
    return load_texel<F>(texture, i, j) * broadcast<F>(unit);
  }
  // The texel whose centre lies at or before the point, -1 to size - 1, and the one behind it.
  const auto i = to_int(x + 0.5f) - 1, j = to_int(y + 0.5f) - 1;
  const F fx = x - 0.5f - to_float(i), fy = y - 0.5f - to_float(j);
  const auto x0 = wrap_before(i, texture.wrap_u, texture.width);
  const auto x1 = wrap_behind(i + 1, texture.wrap_u, texture.width);
  const auto y0 = wrap_before(j, texture.wrap_v, texture.height);
  const auto y1 = wrap_behind(j + 1, texture.wrap_v, texture.height);
  const F upper = (1.0f - fy) * unit, lower = fy * unit;
  return load_texel<F>(texture, x0, y0) * ((1.0f - fx) * upper) +
         load_texel<F>(texture, x1, y0) * (fx * upper) +
         load_texel<F>(texture, x0, y1) * ((1.0f - fx) * lower) +
         load_texel<F>(texture, x1, y1) * (fx * lower);
}

}  // namespace omma
