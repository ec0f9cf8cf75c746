// Reading a texture: wrap modes, nearest and bilinear filtering in linear light (glTF 2.0, 3.8.4).
// Row 0 is v = 0, as in glTF.
#pragma once

#include "kernel/rgba.h"
#include "kernel/scene_view.h"

namespace omma {

OMMA_HD Rgba load_texel(const TextureView& texture, int x, int y) {
  const long long index = static_cast<long long>(y) * texture.width + x;
  if (texture.linear16 != nullptr) return load_rgba(texture.linear16 + 4 * index);
  return load_rgba(texture.linear[index]);
}

// Texture coordinate to texel units, in [0, size].
OMMA_HD float wrap_coordinate(float u, Wrap wrap, float size) {
  if (wrap == Wrap::repeat) return (u - floorf(u)) * size;
  if (wrap == Wrap::mirrored_repeat) {
    const float t = u - 2.0f * floorf(0.5f * u);
    return (t > 1.0f ? 2.0f - t : t) * size;
  }
  return clamp_unit(u) * size;
}

// Texel index beside the edge: goes round for repeat, stays for the other two (where a mirrored
// neighbour is the edge texel itself).
OMMA_HD int wrap_texel(int i, Wrap wrap, int size) {
  if (i >= 0 && i < size) return i;
  if (wrap == Wrap::repeat) return i < 0 ? i + size : i - size;
  return i < 0 ? 0 : size - 1;
}

OMMA_HD Rgba eval_texture(const TextureView& texture, Vec2 uv) {
  const float unit = texture.linear16 != nullptr ? 1.0f / 65535.0f : 1.0f;
  const float x = wrap_coordinate(uv.x, texture.wrap_u, static_cast<float>(texture.width));
  const float y = wrap_coordinate(uv.y, texture.wrap_v, static_cast<float>(texture.height));
  if (texture.filter == Filter::nearest) {
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    return load_texel(texture, i < texture.width ? i : texture.width - 1,
                      j < texture.height ? j : texture.height - 1) *
           unit;
  }
  const float left = floorf(x - 0.5f), top = floorf(y - 0.5f);
  const float fx = x - 0.5f - left, fy = y - 0.5f - top;
  const int i = static_cast<int>(left), j = static_cast<int>(top);
  const int x0 = wrap_texel(i, texture.wrap_u, texture.width);
  const int x1 = wrap_texel(i + 1, texture.wrap_u, texture.width);
  const int y0 = wrap_texel(j, texture.wrap_v, texture.height);
  const int y1 = wrap_texel(j + 1, texture.wrap_v, texture.height);
  const Rgba upper = load_texel(texture, x0, y0) * (1 - fx) + load_texel(texture, x1, y0) * fx;
  const Rgba lower = load_texel(texture, x0, y1) * (1 - fx) + load_texel(texture, x1, y1) * fx;
  return (upper * (1 - fy) + lower * fy) * unit;
}

}  // namespace omma
