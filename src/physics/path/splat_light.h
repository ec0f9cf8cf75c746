// Light of Gaussian splats along rays, between where the rays are and what they meet. Splats are
// composited front to back in the space in which they were trained,
//
//   C = Σ_k c_k α_k Π_{j<k} (1 − α_j),  T = Π_k (1 − α_k)
//
// (Kerbl et al. 2023, eq. 3), then decoded to linear light. What they cover, 1 − T of what lies
// behind, has the colour C / (1 − T), so that
//
//   L = (1 − T) linear(C / (1 − T)) + T L_behind.
//
// The average over an acceptance is one of linear light, as rays are averaged behind this.
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/rays/hits.h"
#include "physics/search/splat_search.h"
#include "physics/surface/harmonics.h"
#include "physics/views/scene_view.h"

namespace omma {

// What splats between two places along rays add, in as many channels as are asked for, and how much
// of the light behind them they let through, [lane].
template <typename L>
struct SplatLight {
  int channels;
  alignas(L::count * 4) float color[splat_channels_kept][L::count];  // linear
  alignas(L::count * 4) float transmittance[L::count];
};

// Where splats are along rays, [lane], where ground truth is asked for.
template <typename L>
struct SplatDepths {
  float weighted_m[L::count];  // Σ_k t_k α_k Π_{j<k} (1 − α_j), m
  float transmittance[L::count];
  float half_m[L::count];         // from where on no more than half gets through, or infinite
  std::uint32_t cloud[L::count];  // of the splat there
};

// A colour in the space in which it is composited.
struct SplatChannels {
  float channel[splat_channels_kept];
};

// Where packets keep colours of splats that were asked for last, as long as all rays see them from
// one place.
template <typename L>
struct SplatColors {
  static constexpr int size = L::width > 1 ? 64 : 1;
  bool one_origin;
  int channels;
  std::int32_t index[size];
  SplatChannels color[size];
};

// 0.5 + Σ_k y_k c_k over a splat's harmonics c, [term][stride], where that is positive.
// `fixed`: how many channels, where that is known beforehand, or 0.
template <int fixed>
OMMA_HD void sum_harmonics(const float (&y)[most_harmonics], const float* c,
                           const SplatCloudView& cloud, int asked, SplatChannels& color) {
  const int channels = fixed > 0 ? fixed : asked;
  for (int i = 0; i < channels; ++i) color.channel[i] = 0.5f;
  for (int k = 0; k < cloud.terms; ++k, c += cloud.channels)
    for (int i = 0; i < channels; ++i) color.channel[i] += c[i] * y[k];
  for (int i = 0; i < channels; ++i)
    color.channel[i] = color.channel[i] > 0 ? color.channel[i] : 0.0f;
}

// The colour of a splat in the space in which it is composited, its first `channels`.
template <typename L>
OMMA_HD_CALLED void splat_color(const SplatCloudView& cloud, std::uint32_t splat, Vec3 seen_along,
                                int channels, SplatChannels& color) {
  const Vec3 d = vec_of(normalize(whiten(cloud.cloud_from_frame, vector_of(seen_along))));
  float y[most_harmonics];
  eval_harmonics(d, cloud.terms, y);
  const float* c = cloud.harmonics + std::ptrdiff_t{cloud.channels} * cloud.terms * splat;
  if (channels == 3) {
    sum_harmonics<3>(y, c, cloud, channels, color);  // RGB, which most have
  } else {
    sum_harmonics<0>(y, c, cloud, channels, color);
  }
}

// Asks for the harmonics of a splat, which lie anywhere.
OMMA_HD void fetch_harmonics(const SplatsView& view, std::int32_t index) {
  const TracedSplat& splat = view.splats[index];
  const SplatCloudView& cloud = view.clouds[splat.cloud];
  const int numbers = cloud.channels * cloud.terms;
  constexpr int per_line = 16;
  const float* const first = cloud.harmonics + std::ptrdiff_t{numbers} * splat.splat;
  for (int k = 0; k < numbers; k += per_line) fetch_line(first + k);
}

// That of a splat as a lane sees it; `rays` are in the frame of splats.
template <typename L>
OMMA_HD const SplatChannels& color_for(const SplatsView& view, std::int32_t index,
                                       const RayFrame<L>& rays, int l, SplatColors<L>& known) {
  const TracedSplat& splat = view.splats[index];
  const SplatCloudView& cloud = view.clouds[splat.cloud];
  const int at = index % SplatColors<L>::size;
  SplatChannels& color = known.color[at];
  if (cloud.by_ray) {
    const Vec3 direction{rays.direction[0][l], rays.direction[1][l], rays.direction[2][l]};
    splat_color<L>(cloud, splat.splat, direction, known.channels, color);
    known.index[at] = -1;
  } else if (!known.one_origin || known.index[at] != index) {
    const Vec3 along = Vec3{splat.center[0], splat.center[1], splat.center[2]} -
                       Vec3{rays.origin[0][l], rays.origin[1][l], rays.origin[2][l]};
    splat_color<L>(cloud, splat.splat, along, known.channels, color);
    known.index[at] = index;
  }
  return color;
}

// Adds the splats of a lane's buffer to its light, as long as light gets through, and notes where
// they have come. Returns whether more may follow.
template <typename L, typename Color>
OMMA_HD bool add_splats(const SplatsView& view, SplatBuffer<L>& buffer, int l, const Color& color,
                        SplatLight<L>& light, SplatDepths<L>* depths) {
  constexpr int ahead = 4;
  float through = light.transmittance[l];
  for (int k = 0; k < buffer.count[l] && through >= least_splat_transmittance; ++k) {
    const float alpha = buffer.alpha[l][1 + k], weight = through * alpha;
    const SplatPlace place = buffer.place(l, k);
    if (light.channels > 0) {
      if (k + ahead < buffer.count[l]) fetch_harmonics(view, buffer.place(l, k + ahead).index);
      const SplatChannels& c = color(place.index);
      for (int i = 0; i < light.channels; ++i) light.color[i][l] += c.channel[i] * weight;
    }
    through *= 1.0f - alpha;
    buffer.near_m[l] = place.t_m;
    buffer.last[l] = place.index;
    if (depths == nullptr) continue;
    depths->weighted_m[l] += weight * place.t_m;
    if (through > 0.5f || depths->half_m[l] <= place.t_m) continue;
    depths->half_m[l] = place.t_m;
    depths->cloud[l] = view.splats[place.index].cloud;
  }
  light.transmittance[l] = buffer.through_near[l] = through;
  return through >= least_splat_transmittance && buffer.count[l] == SplatBuffer<L>::capacity;
}

// What splats add to linear light, of sums in the space in which they are composited.
template <typename L>
OMMA_HD void decode_splats(const SplatsView& view, SplatLight<L>& light) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    const F covered = 1.0f - load<F>(light.transmittance + l);
    const F at_least = covered > 1e-6f ? covered : broadcast<F>(1e-6f);
    for (int i = 0; i < light.channels; ++i) {
      float* const at = light.color[i] + l;
      const F sum = load<F>(at);
      store(at, view.white[i] * (view.is_srgb ? covered * linear_of_srgb(sum / at_least) : sum));
    }
  }
}

// Light of splats along the rays of some lanes, behind begin_m and their t_near_m, up to their
// t_far_m, in light.channels, which may be 0. `depths` may be null.
template <typename L>
OMMA_HD_CALLED void eval_splats(const SplatTree<L>& tree, LaneMask<L> on,
                                const RayPacket<L::count>& rays, const float (&begin_m)[L::count],
                                SplatLight<L>& light, SplatDepths<L>* depths) {
  const SplatsView& view = tree.view;
  SplatBuffer<L> buffer;
  SplatColors<L> colors;
  alignas(L::count * 4) float origin[3][L::count];  // in the frame of splats
  const RayFrame<L> frame{origin, rays.direction};
  for (int l = 0; l < L::count; ++l) {
    buffer.near_m[l] = begin_m[l] > rays.t_near_m[l] ? begin_m[l] : rays.t_near_m[l];
    buffer.last[l] = behind_all;
    buffer.through_near[l] = light.transmittance[l] = 1;
    for (int i = 0; i < light.channels; ++i) light.color[i][l] = 0;
    for (int a = 0; a < 3; ++a) origin[a][l] = rays.origin[a][l] - view.first_origin_m[a];
    if (depths == nullptr) continue;
    depths->weighted_m[l] = 0;
    depths->half_m[l] = INFINITY;
  }
  colors.one_origin = L::count > 1;
  colors.channels = light.channels;
  for (std::int32_t& index : colors.index) index = -1;
  on.for_each([&](int l) {
    for (int a = 0; a < 3; ++a)
      colors.one_origin = colors.one_origin && origin[a][l] == origin[a][lowest_bit(on.bits)];
  });

  // Front to back, as many at once as the buffer holds.
  for (LaneMask<L> left = on; left.any();) {
    for (int l = 0; l < L::count; ++l) buffer.far_m[l] = rays.t_far_m[l];
    find_splats<L>(tree, left, frame, buffer);
    left.for_each([&](int l) {
      const auto color = [&](std::int32_t index) -> const SplatChannels& {
        return color_for<L>(view, index, frame, l, colors);
      };
      if (!add_splats(view, buffer, l, color, light, depths)) left.bits &= ~(1u << l);
    });
  }
  if (depths != nullptr)
    for (int l = 0; l < L::count; ++l) depths->transmittance[l] = light.transmittance[l];
  decode_splats(view, light);
}

// For ground truth rays meet splats where half of their light comes from before, if that is nearer
// than what they met first; and where light comes from.
template <typename L>
OMMA_HD void meet_splats(const SceneView& scene, const SplatDepths<L>& depths,
                         FirstHits<L>& first) {
  for (int l = 0; l < L::count; ++l) {
    const bool met = first.hits.mesh[l] != no_mesh;
    const float behind = met ? depths.transmittance[l] : 0.0f;
    first.source_m[l] = depths.weighted_m[l];
    if (met) first.source_m[l] += behind * first.packet.rays.t_far_m[l];
    first.source_weight[l] = 1.0f - depths.transmittance[l] + behind;
    if (!(depths.half_m[l] < INFINITY)) continue;
    first.packet.rays.t_far_m[l] = depths.half_m[l];
    first.hits.mesh[l] = mesh_of_splats;
    first.hits.instance[l] = scene.instance_count + static_cast<std::int32_t>(depths.cloud[l]);
  }
}

// What a step of an unlit path met, and the splats before it, from seen_m on, as one surface: it
// covers 1 − T (1 − α) of what lies behind. The rays have then been seen up to there. `first`: has
// what they met, and takes the splats before it; or null.
template <typename L, typename Flight, typename Color>
OMMA_HD_CALLED void cover_with_splats(const Flight& flight, LaneMask<L> on,
                                      float (&seen_m)[L::count], Color& color,
                                      FirstHits<L>* first) {
  using F = typename L::F;
  const RayPacket<L::count>& rays = flight.packet.rays;
  SplatLight<L> light;
  light.channels = 3;
  SplatDepths<L> depths;
  eval_splats<L>({*flight.scene.splats, flight.search.visits_of_trees()}, on, rays, seen_m, light,
                 first == nullptr ? nullptr : &depths);
  if (first != nullptr) meet_splats(flight.scene, depths, *first);
  for (int l = 0; l < L::count; l += L::width) {
    const F through = load<F>(light.transmittance + l), alpha = load<F>(color.alpha + l);
    const F covered = 1.0f - through * (1.0f - alpha);
    const F per_covered = covered > 0.0f ? 1.0f / covered : F{};
    for (int c = 0; c < 3; ++c) {
      float* const rgb = color.rgb[c] + l;
      store(rgb, (load<F>(light.color[c] + l) + through * alpha * load<F>(rgb)) * per_covered);
    }
    store(color.alpha + l, covered);
    store(seen_m + l, load<F>(rays.t_far_m + l));
  }
}

}  // namespace omma
