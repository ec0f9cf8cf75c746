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
    const I red_green = gather(texture.linear16, texel * 2);
    const I blue_alpha = gather(texture.linear16, texel * 2 + 1);
    return {to_float(red_green & 0xffff), to_float((red_green >> 16) & 0xffff),
            to_float(blue_alpha & 0xffff), to_float((blue_alpha >> 16) & 0xffff)};
  }
  return {gather(texture.linear, texel * 4), gather(texture.linear, texel * 4 + 1),
          gather(texture.linear, texel * 4 + 2), gather(texture.linear, texel * 4 + 3)};
}

// Texture coordinate to texel units, in [0, size]. Clamped in every mode: coordinates past the range
// of an integer, and what lanes without a hit hold, must not reach outside the image either.
template <typename F>
OMMA_HD F wrap_coordinate(F u, Wrap wrap, float size) {
  if (wrap == Wrap::repeat) return clamp_unit_lanes(u - floor_lanes(u)) * size;
  if (wrap == Wrap::mirrored_repeat) {
    const F t = u - 2.0f * floor_lanes(0.5f * u);
    return clamp_unit_lanes(t > 1.0f ? 2.0f - t : t) * size;
  }
  return clamp_unit_lanes(u) * size;
}

// Texel index beside the edge: goes round for repeat, stays for the other two (where a mirrored
// neighbour is the edge texel itself).
template <typename I>
OMMA_HD I wrap_texel(I i, Wrap wrap, int size) {
  const I below = wrap == Wrap::repeat ? i + size : i * 0;
  const I above = wrap == Wrap::repeat ? i - size : i * 0 + (size - 1);
  i = i < 0 ? below : i;
  return i >= size ? above : i;
}

template <typename F>
OMMA_HD Color<F> eval_texture(const TextureView& texture, F u, F v) {
  const float unit = texture.linear16 != nullptr ? 1.0f / 65535.0f : 1.0f;
  const F x = wrap_coordinate(u, texture.wrap_u, static_cast<float>(texture.width));
  const F y = wrap_coordinate(v, texture.wrap_v, static_cast<float>(texture.height));
  if (texture.filter == Filter::nearest) {
    // On the far edge the texel before it, whatever the wrap mode.
    const auto i = wrap_texel(to_int(x), Wrap::clamp_to_edge, texture.width);
    const auto j = wrap_texel(to_int(y), Wrap::clamp_to_edge, texture.height);
    return load_texel<F>(texture, i, j) * broadcast<F>(unit);
  }
  const F left = floor_lanes(x - 0.5f), top = floor_lanes(y - 0.5f);
  const F fx = x - 0.5f - left, fy = y - 0.5f - top;
  const auto i = to_int(left), j = to_int(top);
  const auto x0 = wrap_texel(i, texture.wrap_u, texture.width);
  const auto x1 = wrap_texel(i + 1, texture.wrap_u, texture.width);
  const auto y0 = wrap_texel(j, texture.wrap_v, texture.height);
  const auto y1 = wrap_texel(j + 1, texture.wrap_v, texture.height);
  const F upper = (1.0f - fy) * unit, lower = fy * unit;
  return load_texel<F>(texture, x0, y0) * ((1.0f - fx) * upper) +
         load_texel<F>(texture, x1, y0) * (fx * upper) +
         load_texel<F>(texture, x0, y1) * ((1.0f - fx) * lower) +
         load_texel<F>(texture, x1, y1) * (fx * lower);
}

}  // namespace omma
