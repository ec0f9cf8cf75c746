// Bundles of rays and the boxes of a node's children: an interval around all rays, which no box
// that one of them meets escapes, and the rays themselves.
//
// Nothing that a ray meets is lost. Boxes are widened by more than all rounding: of their own
// decoding, of slopes, of the triangle test (after Ize 2013, jcgt.org/published/0002/02/02, who
// widens by the rounding of the box test itself).
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/lanes/vector3.h"
#include "physics/search/bvh.h"
#include "physics/search/search_lanes.h"

namespace omma {

// Boxes are widened by this fraction of their greatest distance from the rays' origins along an
// axis: 64 roundings. An edge that lies across a ray is off by 16 at most where the triangle test
// decides on which side the ray passes, less than half as many add up in the box test, and edges
// that a ray sees slantwise are off by more.
inline constexpr float box_slack = 0x1p-18f;

// Components of directions that are a smaller fraction of the largest one are taken for as large:
// reciprocals stay finite, and rays move by far less than boxes are widened by.
inline constexpr float least_component = 1e-10f;

// What is in one place may be found in any order: boxes that much behind a hit are still searched.
inline constexpr float hit_slack = 1 + 1e-5f;

// Rays whose directions have the same signs. `near` is what makes entries into boxes earliest,
// `far` what makes exits latest.
template <typename L>
struct RayBundle {
  unsigned lanes;  // a bit for each ray that belongs to it
  bool negative[3];
  bool one_origin;  // exactly the same for all of them
  float near_origin[3], far_origin[3];
  float near_rate[3], far_rate[3];  // 1 / direction
  float t_near_m;
  alignas(L::count >= 16 ? 64 : 4) float near_ratio[3][L::count];  // rate of a ray per near_rate
  alignas(L::count >= 16 ? 64 : 4) float far_ratio[3][L::count];
};

// Rays as they are in a tree's frame.
template <typename L>
struct RayFrame {
  const float (*origin)[L::count];
  const float (*direction)[L::count];

  // Of lanes from l on.
  OMMA_HD Vector3<typename L::F> load_origin(int l) const {
    using F = typename L::F;
    return {load<F>(origin[0] + l), load<F>(origin[1] + l), load<F>(origin[2] + l)};
  }
  OMMA_HD Vector3<typename L::F> load_direction(int l) const {
    using F = typename L::F;
    return {load<F>(direction[0] + l), load<F>(direction[1] + l), load<F>(direction[2] + l)};
  }
};

// The bundle of the first of those lanes and all that go with it.
template <typename L>
OMMA_HD void make_bundle(const RayFrame<L>& frame, const float (&t_near_m)[L::count],
                         unsigned lanes, RayBundle<L>& bundle) {
  using F = typename L::F;
  unsigned negative[3] = {};
  const int first = lowest_bit(lanes);
  unsigned others = 0;
  for (int a = 0; a < 3; ++a) {
    for (int l = 0; l < L::count; l += L::width)
      negative[a] |= lane_bits(load<F>(frame.direction[a] + l) < 0.0f) << l;
    bundle.negative[a] = (negative[a] >> first & 1u) != 0;
    others |= bundle.negative[a] ? ~negative[a] : negative[a];
  }
  bundle.lanes = lanes & ~others;

  // Idle lanes repeat the first ray of the bundle.
  const auto lane = [&](const float* values, int l) {
    return LaneMask<L>{bundle.lanes}.at(l) ? load<F>(values + l) : broadcast<F>(values[first]);
  };
  const auto span = [&](const float* values, float& lowest, float& highest) {
    unsigned others_than_first = 0;
    for (int l = 0; l < L::count; l += L::width)
      others_than_first |= lane_bits(lane(values, l) != values[first]);
    lowest = highest = values[first];
    if (others_than_first == 0) return true;
    F low = lane(values, 0), high = low;
    for (int l = L::width; l < L::count; l += L::width) {
      low = least(low, lane(values, l));
      high = most(high, lane(values, l));
    }
    lowest = least_lane(low);
    highest = most_lane(high);
    return false;
  };

  F low_rate[3], high_rate[3];
  for (int l = 0; l < L::count; l += L::width) {
    F component[3];
    for (int a = 0; a < 3; ++a) {
      component[a] = lane(frame.direction[a], l);
      component[a] = component[a] < 0.0f ? -component[a] : component[a];
    }
    const F floor = most(component[0], most(component[1], component[2])) * least_component;
    for (int a = 0; a < 3; ++a) {
      const F rate = 1.0f / most(component[a], floor);
      store(bundle.near_ratio[a] + l, rate);
      low_rate[a] = l == 0 ? rate : least(low_rate[a], rate);
      high_rate[a] = l == 0 ? rate : most(high_rate[a], rate);
    }
  }
  bundle.one_origin = true;
  for (int a = 0; a < 3; ++a) {
    float low, high;
    bundle.one_origin = span(frame.origin[a], low, high) && bundle.one_origin;
    bundle.near_origin[a] = bundle.negative[a] ? low : high;
    bundle.far_origin[a] = bundle.negative[a] ? high : low;
    const float least_rate = least_lane(low_rate[a]), most_rate = most_lane(high_rate[a]);
    bundle.near_rate[a] = bundle.negative[a] ? -least_rate : least_rate;
    bundle.far_rate[a] = bundle.negative[a] ? -most_rate : most_rate;
    const float per_least = 1.0f / least_rate, per_most = 1.0f / most_rate;
    for (int l = 0; l < L::count; l += L::width) {
      const F rate = load<F>(bundle.near_ratio[a] + l);
      store(bundle.near_ratio[a] + l, rate * per_least);
      store(bundle.far_ratio[a] + l, rate * per_most);
    }
  }
  float highest;
  span(t_near_m, bundle.t_near_m, highest);
}

// Where the bundle enters and leaves the slabs of a node's children at the earliest and latest; of
// one ray no more is asked than `near`.
template <typename L>
struct ChildSlabs {
  static constexpr bool is_packet = L::count > 1;
  static constexpr int kept = is_packet ? node_width : 1;
  alignas(is_packet ? 32 : 4) float enter[3][kept], leave[3][kept];
  alignas(is_packet ? 32 : 4) float near[node_width];  // of all three, and of the rays themselves
};

// A bit for each child that a ray of the bundle may meet.
template <typename L>
OMMA_HD unsigned hit_children(const WideNode& node, const RayBundle<L>& bundle, float t_far_m,
                              ChildSlabs<L>& slabs) {
  float step[3], distance = 0, size = 0;
  for (int a = 0; a < 3; ++a) {
    step[a] = float_of(static_cast<std::int32_t>(node.exponent[a]) << 23);
    distance = most(distance, most(fabsf(node.origin[a] - bundle.near_origin[a]),
                                   fabsf(node.origin[a] - bundle.far_origin[a])));
    size = most(size, step[a]);
  }
  const float slack = box_slack * (distance + 255.0f * size);
  float enter_step[3], enter_base[3], leave_step[3], leave_base[3];
  for (int a = 0; a < 3; ++a) {
    enter_step[a] = step[a] * bundle.near_rate[a];
    leave_step[a] = step[a] * bundle.far_rate[a];
    enter_base[a] = (node.origin[a] - bundle.near_origin[a]) * bundle.near_rate[a] -
                    slack * fabsf(bundle.near_rate[a]);
    leave_base[a] = (node.origin[a] - bundle.far_origin[a]) * bundle.far_rate[a] +
                    slack * fabsf(bundle.far_rate[a]);
  }
  unsigned bits = 0;
  for (int c = 0; c < node_width; c += child_lanes) {
    ChildFloats near = broadcast<ChildFloats>(bundle.t_near_m);
    ChildFloats far = broadcast<ChildFloats>(t_far_m);
    for (int a = 0; a < 3; ++a) {
      const std::uint8_t* first = bundle.negative[a] ? node.upper[a] : node.lower[a];
      const std::uint8_t* second = bundle.negative[a] ? node.lower[a] : node.upper[a];
      const ChildFloats enter = read_children(first + c) * enter_step[a] + enter_base[a];
      const ChildFloats leave = read_children(second + c) * leave_step[a] + leave_base[a];
      if constexpr (L::count > 1) {
        store(slabs.enter[a] + c, enter);
        store(slabs.leave[a] + c, leave);
      }
      near = most(enter, near);
      far = least(leave, far);
    }
    store(slabs.near + c, near);
    bits |= child_bits(near <= far) << c;
  }
  return bits & ((1u << (node.counts >> 4)) - 1u);
}

// A bit for each of those lanes whose ray meets a child.
template <typename L>
OMMA_HD unsigned hits_child(const RayBundle<L>& bundle, unsigned lanes, const ChildSlabs<L>& slabs,
                            int c, const float (&t_far_m)[L::count]) {
  using F = typename L::F;
  if constexpr (L::count == 1) return lanes;
  unsigned bits = 0;
  for (int l = 0; l < L::count; l += L::width) {
    F near = broadcast<F>(bundle.t_near_m);
    F far = load<F>(t_far_m + l) * hit_slack;
    for (int a = 0; a < 3; ++a) {
      near = most(load<F>(bundle.near_ratio[a] + l) * slabs.enter[a][c], near);
      far = least(load<F>(bundle.far_ratio[a] + l) * slabs.leave[a][c], far);
    }
    bits |= lane_bits(near <= far) << l;
  }
  return bits & lanes;
}

// How far the rays of some lanes look at most.
template <typename L>
OMMA_HD float furthest(const float (&t_far_m)[L::count], unsigned lanes) {
  using F = typename L::F;
  F far = broadcast<F>(0.0f);
  for (int l = 0; l < L::count; l += L::width)
    far = most(LaneMask<L>{lanes}.at(l) ? load<F>(t_far_m + l) : far, far);
  return most_lane(far) * hit_slack;
}

}  // namespace omma
