// Volumes that rays go through, such as water and glass: which one a ray is in, and what it
// absorbs,
//
//   L = L_0 exp(-a d)    (Beer and Lambert),
//
// a by band, over the distance d between surfaces. A volume is bounded by meshes whose material
// refracts, seen from outside by their front.
//
// Rays from the eye bend at boundaries, by Snell's law. Radiance changes there by the square of the
// indices' ratio (Born and Wolf 1999, 4.8.3): over n^2 is what comes out of a volume, n^2 times
// what gets in. All other rays, as those to lights, go straight on, which no sample of a light
// could do otherwise. Through a level surface they bring what bent ones would: the flux through it
// is the same, and so is the way in the volume, of which those that go through count
//
//   d cos(t) / cos(t'),   sin(t') = sin(t) / n.
//
// What leaves a volume for a surface outside is over n^2 for them too, so that light through a
// whole body has lost nothing of that. Of rays that begin within, at all angles, a boundary
// reflects what it does within: in the mean what does not get out by them comes in by their
// reciprocal. Once they have been mirrored, or have come straight, it is the sheet that it is from
// outside: whatever the shape of a body, it then gives back no more than it gets.
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/lanes/powers.h"
#include "physics/surface/lit_surface.h"

namespace omma {

// In place of a medium's material: none that is known; and of rays from the eye that must not bend,
// for which boundaries hide what lies straight on.
inline constexpr std::int32_t no_medium = -1, seen_by_eye = -2;

OMMA_HD void set_came(const RayMedia& media, int lane, Came came) {
  media.came[lane] = static_cast<std::int32_t>(came);
}
// Of lanes from l on.
template <typename L>
OMMA_HD auto has_come(const RayMedia& media, int l, Came came) {
  return load<typename L::I>(media.came + l) == static_cast<std::int32_t>(came);
}

// Rays begin.
template <typename L>
OMMA_HD void begin_in(const RayMedia& media, std::int32_t material) {
  for (int l = 0; l < L::count; ++l) {
    media.material[l] = material;
    set_came(media, l, Came::from_within);
    media.from_m[l] = 0;
  }
}

// Rays begin in what others are in.
template <typename L>
OMMA_HD void begin_in(const RayMedia& media, const RayMedia& others) {
  begin_in<L>(media, no_medium);
  for (int l = 0; l < L::count; ++l) media.material[l] = others.material[l];
}

// The same of rays that go on in place of others, which have just left a surface.
template <typename L>
OMMA_HD void go_on_in(const RayMedia& media, const RayMedia& others) {
  begin_in<L>(media, others);
  for (int l = 0; l < L::count; ++l) media.came[l] = others.came[l];
}

// Rays of some lanes go on past what they met at t_far_m, bent there, or straight on.
template <typename L>
OMMA_HD_CALLED void pass_boundaries(const LitSurface<L>& surface, LaneMask<L> straight,
                                    LaneMask<L> bent, const float (&t_far_m)[L::count],
                                    const RayMedia& media) {
  (straight | bent).for_each([&](int l) {
    const std::int32_t volume = surface.volume[l];
    const bool is_straight = straight.has(l);
    if (volume != 0) {
      media.material[l] = volume > 0 ? surface.material[l] : no_medium;
      set_came(media, l, volume > 0 && is_straight ? Came::straight : Came::from_within);
    }
    media.from_m[l] = is_straight ? t_far_m[l] : 0;
  });
}

// By what light that goes through boundaries changes as radiance: of lanes from l on, of which
// those in `bend` do so. 0 where nothing may go straight on.
template <typename L>
OMMA_HD typename L::F radiance_scale(const LitSurface<L>& surface, const RayMedia& media, int l,
                                     LaneMask<L> bend) {
  using F = typename L::F;
  using I = typename L::I;
  const I volume = load<I>(surface.volume + l);
  const F one = broadcast<F>(1.0f), n = load<F>(surface.ior + l);
  const auto leaves = volume < 0 && (bend.at(l) || has_come<L>(media, l, Came::straight));
  const F out = leaves ? n * n : one, scale = volume > 0 ? one / (n * n) : out;
  return volume != 0 && load<I>(media.material + l) == seen_by_eye ? F{} : scale;
}

// What the volume absorbs that a ray is in before it meets a surface, [band]; null: nothing.
template <typename L>
OMMA_HD const float* absorption_before(const SceneView& scene, const RayMedia& media,
                                       const LitSurface<L>& surface, int l) {
  const std::int32_t material = surface.volume[l] < 0 ? surface.material[l] : media.material[l];
  return material < 0 ? nullptr : scene.scatter[material].absorption_per_m;
}

// The way in a volume of light that comes in where a ray of some lane goes straight out, over the
// ray's own: of rays that begin within or have come straight, and meet the boundary with this
// cosine.
template <typename L>
OMMA_HD float bent_way(const RayMedia& media, const LitSurface<L>& surface, int l, float cosine) {
  if (surface.volume[l] >= 0 || media.came[l] == static_cast<std::int32_t>(Came::mirrored))
    return 1;
  const float ior = surface.ior[l];
  return cosine / sqrt_lanes(1.0f - (1.0f - cosine * cosine) / (ior * ior));
}

// Rays to what was met, [lane]: how far that is, and what part of the way in a volume counts.
template <typename L>
struct VolumeWays {
  LaneMask<L> met;
  const float (&t_far_m)[L::count];
  const float (&part)[L::count];
};

// Multiplies `throughput` [band][lane] of some lanes by what volumes leave of light on the way to
// what was met.
template <typename L>
OMMA_HD_CALLED void absorb(const SceneView& scene, const RayMedia& media,
                           const LitSurface<L>& surface, const VolumeWays<L>& ways,
                           float* throughput) {
  ways.met.for_each([&](int l) {
    const float* const absorption_per_m = absorption_before(scene, media, surface, l);
    if (absorption_per_m == nullptr) return;
    const float way_m = (ways.t_far_m[l] - media.from_m[l]) * ways.part[l];
    for (int b = 0; b < scene.bands; ++b)
      throughput[b * L::count + l] *= left_by_depth(absorption_per_m[b] * way_m);
  });
}

// What volumes leave, of lights within them, on the last part of the way, to t_far_m.
template <typename L>
OMMA_HD_CALLED void absorb_to_end(const SceneView& scene, const RayMedia& media, LaneMask<L> lanes,
                                  const float (&t_far_m)[L::count], float* throughput) {
  lanes.for_each([&](int l) {
    if (media.material[l] < 0 || !(t_far_m[l] < INFINITY)) return;
    const float* const absorption_per_m = scene.scatter[media.material[l]].absorption_per_m;
    if (absorption_per_m == nullptr) return;
    const float way_m = t_far_m[l] - media.from_m[l];
    for (int b = 0; b < scene.bands; ++b)
      throughput[b * L::count + l] *= left_by_depth(absorption_per_m[b] * way_m);
  });
}

}  // namespace omma
