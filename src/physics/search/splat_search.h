// The search for Gaussian splats along rays: those next in order behind where a ray has come, as
// many as a buffer holds, so that light is put together front to back in as many passes as it takes
// (3D Gaussian Ray Tracing, Moenne-Loccoz et al. 2024, doi:10.1145/3687934, section 4.1).
//
// A splat counts where the ray comes closest to its middle in standard deviations, at the point of
// greatest response: with o and d, the ray's origin from the middle and direction, whitened,
//
//   t = −o·d / d·d,  α = opacity · exp(−|o + t d|² / 2).
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/lanes/powers.h"
#include "physics/lanes/vector3.h"
#include "physics/search/splats_view.h"
#include "physics/search/traverse.h"

namespace omma {

// A place along a ray: splats at one distance are in the order of their index.
struct SplatPlace {
  float t_m;
  std::int32_t index;  // into SplatsView::splats
};

// In place of an index: nothing at that distance counts any more.
inline constexpr std::int32_t behind_all = 0x7fffffff;

OMMA_HD bool is_behind(const SplatPlace& a, const SplatPlace& b) {
  return a.t_m > b.t_m || (a.t_m == b.t_m && a.index > b.index);
}

// The splats of a scene, and where a search keeps what is still to be visited of their tree.
template <typename L>
struct SplatTree {
  const SplatsView& view;
  Visits<L::count> visits;
};

// Where the rays of a packet have come, and the next splats of each lane in order, [lane].
template <typename L>
struct SplatBuffer {
  static constexpr int capacity = L::width > 1 ? 64 : 16;  // a thread of a card has a small stack
  static_assert(capacity % L::width == 0);                 // rows are moved so many at a time
  alignas(L::count * 4) float near_m[L::count];
  std::int32_t last[L::count];   // index of the splat at near_m that was found last, or behind_all
  float through_near[L::count];  // how much light gets through up to there
  alignas(L::count * 4) float far_m[L::count];  // how far rays look
  int count[L::count];
  float through[L::count];  // through_near · Π (1 − α) over the splats here
  // What was found, [lane][1 + k]: rows begin with one number more, as they are moved up by one.
  float t_m[L::count][1 + capacity];
  std::int32_t index[L::count][1 + capacity];
  float alpha[L::count][1 + capacity];

  OMMA_HD SplatPlace place(int l, int k) const { return {t_m[l][1 + k], index[l][1 + k]}; }
};

// How many of a lane's places are not behind another.
template <typename L>
OMMA_HD int count_before(const SplatBuffer<L>& buffer, int l, const SplatPlace& place) {
  using F = typename L::F;
  using I = typename L::I;
  int before = 0;
  for (int k = 0; k < buffer.count[l]; k += L::width) {
    const F t = load<F>(buffer.t_m[l] + 1 + k);
    const I index = load<I>(buffer.index[l] + 1 + k);
    const unsigned bits =
        lane_bits(t < place.t_m) | (lane_bits(t == place.t_m) & lane_bits(index < place.index));
    const int left = buffer.count[l] - k;
    before += bits_in(left < L::width ? bits & ((1u << left) - 1u) : bits);
  }
  return before;
}

// Puts a value at `at` of a row, whose last ones move up by one.
template <typename V, typename L, typename T, std::size_t size>
OMMA_HD void put_between(T (&row)[size], int at, int count, T value) {
  const auto number = lane_numbers<L>();
  for (int k = (count - 1) / L::width * L::width; k > at - L::width; k -= L::width) {
    const V moved = load<V>(row + k);
    const auto lane = number + k;
    store(row + 1 + k, lane < at ? load<V>(row + 1 + k) : (lane == at ? V{} + value : moved));
  }
}

// Leaves out what is behind where next to no light gets through any more, whatever else is found
// before. By half of the threshold, so that rounding never decides.
template <typename L>
OMMA_HD void cut_unseen(SplatBuffer<L>& buffer, int l) {
  constexpr float unseen = 0.5f * least_splat_transmittance;
  if (buffer.through[l] >= unseen) return;
  for (; buffer.count[l] > 0; --buffer.count[l]) {
    const float past_last = 1.0f - buffer.alpha[l][buffer.count[l]];
    if (buffer.through[l] >= unseen * past_last) break;
    buffer.through[l] /= past_last;
  }
  buffer.far_m[l] = buffer.t_m[l][buffer.count[l]];
}

// Puts a splat where it belongs; the last one makes room for it.
template <typename L>
OMMA_HD void insert_splat(SplatBuffer<L>& buffer, int l, const SplatPlace& place, float alpha) {
  constexpr int capacity = SplatBuffer<L>::capacity;
  const int at = count_before(buffer, l, place);
  if (at == capacity) return;
  if (buffer.count[l] == capacity) {
    buffer.through[l] /= 1.0f - buffer.alpha[l][capacity];
  } else {
    ++buffer.count[l];
  }
  const int count = buffer.count[l];
  put_between<typename L::F, L>(buffer.t_m[l], at, count, place.t_m);
  put_between<typename L::I, L>(buffer.index[l], at, count, place.index);
  put_between<typename L::F, L>(buffer.alpha[l], at, count, alpha);
  if (count == capacity) buffer.far_m[l] = buffer.t_m[l][capacity];
  buffer.through[l] *= 1.0f - alpha;
  cut_unseen(buffer, l);
}

// By a splat's whitening.
template <typename F>
OMMA_HD Vector3<F> whiten(const float (&m)[3][3], const Vector3<F>& v) {
  return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
          m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
          m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}

// Rays in the frame of splats, of which a search asks.
template <typename L>
struct SplatRays {
  const RayFrame<L>& frame;
  bool one_origin;  // of all that ask
};

// Puts what the lanes meet of one splat into the buffer.
template <typename L>
OMMA_HD void meet_splat(const TracedSplat& splat, std::int32_t index, const SplatRays<L>& rays,
                        unsigned lanes, SplatBuffer<L>& buffer) {
  using F = typename L::F;
  const Vector3<float> center = vector_of(splat.center);
  const int any = lowest_bit(lanes);
  const float(*const origin)[L::count] = rays.frame.origin;
  const Vector3<float> from_one = whiten(
      splat.whitening, Vector3<float>{origin[0][any], origin[1][any], origin[2][any]} - center);
  for (int l = 0; l < L::count; l += L::width) {
    if constexpr (L::count > L::width)
      if ((lanes >> l & LaneMask<L>::vector_bits) == 0) continue;
    const Vector3<F> d = whiten(splat.whitening, rays.frame.load_direction(l));
    const Vector3<F> o = rays.one_origin
                             ? Vector3<F>{} + from_one
                             : whiten(splat.whitening, rays.frame.load_origin(l) - center);
    const F t = (0.0f - dot(o, d)) / dot(d, d);
    const Vector3<F> closest = o + d * t;
    const F square = dot(closest, closest);
    const unsigned met = lanes >> l & lane_bits(square <= splat.most_square) &
                         lane_bits(t >= load<F>(buffer.near_m + l)) &
                         lane_bits(t <= load<F>(buffer.far_m + l));
    if (met == 0) continue;
    const F response = exp2_lanes(square * -0.721347520f) * splat.opacity;
    const F alpha = response < most_splat_alpha ? response : broadcast<F>(most_splat_alpha);
    float t_of[L::width], alpha_of[L::width];
    store(t_of, t);
    store(alpha_of, alpha);
    for (unsigned left = met; left != 0; left &= left - 1) {
      const int i = lowest_bit(left), lane = l + i;
      const SplatPlace place{t_of[i], index};
      if (is_behind(place, {buffer.near_m[lane], buffer.last[lane]}))
        insert_splat(buffer, lane, place, alpha_of[i]);
    }
  }
}

// Fills the buffer of those lanes with what comes next. Its far_m comes nearer where it is full and
// where no light gets through; `rays` are in the frame of splats.
template <typename L>
OMMA_HD_CALLED void find_splats(const SplatTree<L>& tree, LaneMask<L> on, const RayFrame<L>& rays,
                                SplatBuffer<L>& buffer) {
  const SplatsView& view = tree.view;
  on.for_each([&](int l) {
    buffer.count[l] = 0;
    buffer.through[l] = buffer.through_near[l];
  });
  for (unsigned left = on.bits; left != 0;) {
    RayBundle<L> bundle;
    make_bundle<L>(rays, buffer.near_m, left, bundle);
    left &= ~bundle.lanes;
    const auto meet_leaf = [&](std::uint32_t block, std::uint32_t splats, unsigned asked) {
      for (std::uint32_t k = 0; k < splats; ++k) {
        const std::uint32_t index = block * splats_per_block + k;
        meet_splat<L>(view.splats[index], static_cast<std::int32_t>(index),
                      {rays, bundle.one_origin}, asked, buffer);
      }
      return asked;
    };
    search_tree<L, most_tree_depth>({view.nodes, 0, tree.visits.tree}, bundle, bundle.lanes,
                                    buffer.far_m, meet_leaf);
  }
}

}  // namespace omma
