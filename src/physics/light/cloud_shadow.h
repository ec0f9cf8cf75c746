// Shadows of clouds: how much of a disc's light comes through a level layer at the place where the
// way to the disc's centre crosses it (omma::CloudShadow).
#pragma once

#include "physics/lanes/powers.h"
#include "physics/lanes/vector3.h"
#include "physics/views/light_view.h"

namespace omma {

// u modulo a whole number of nodes: the node at or before u, the next one, and how far it is to it.
template <typename F, typename I>
struct MapPlace {
  I node, next;
  F along;
};

template <typename F>
OMMA_HD auto find_on_map(F u, std::int32_t nodes) {
  const auto count = static_cast<float>(nodes);
  const F within = u - floor_lanes(u * (1.0f / count)) * count;
  const F whole = floor_lanes(within);
  auto node = to_int(whole);
  node = node < nodes ? node : node * 0;  // as rounding may have it
  const auto next = node + 1 < nodes ? node + 1 : node * 0;
  return MapPlace<F, decltype(node)>{node, next, within - whole};
}

// exp(-depth / sin e) for places, m, in the traced frame. Discs at and below the horizon are not
// shaded.
template <typename F>
OMMA_HD F eval_cloud_shadow(const LightView& light, const DiscView& disc, Vector3<F> place) {
  const CloudShadowView& clouds = light.clouds;
  const F open = broadcast<F>(1.0f);
  if (!(disc.direction.y > 0.0f)) return open;
  if (light.lamp_origin_m != nullptr)
    place = place - Vector3<float>{light.lamp_origin_m[0], light.lamp_origin_m[1],
                                   light.lamp_origin_m[2]};
  const float per_sine = 1.0f / disc.direction.y;
  const F to_layer = (clouds.height_m - place.y) * per_sine;
  const auto column = find_on_map(
      (place.x + to_layer * disc.direction.x) * clouds.per_m + clouds.first_column, clouds.columns);
  const auto row = find_on_map(
      (place.z + to_layer * disc.direction.z) * clouds.per_m + clouds.first_row, clouds.rows);
  const auto at = [&](const auto& r, const auto& c) {
    return gather(clouds.optical_depth, r * clouds.columns + c);
  };
  const auto between = [](F a, F b, F along) { return a + (b - a) * along; };
  const F low = between(at(row.node, column.node), at(row.node, column.next), column.along);
  const F high = between(at(row.next, column.node), at(row.next, column.next), column.along);
  const F left = left_by_depth(between(low, high, row.along) * per_sine);
  return to_layer > 0.0f ? left : open;
}

}  // namespace omma
