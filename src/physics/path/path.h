// The unlit path: what comes along the rays of a packet where surfaces send out their own colours.
// Rays are followed front to back, through surfaces that cover what lies behind in part, to the
// background:
//
//   L = Σ_k α_k C_k Π_{j<k} (1 − α_j),
//
// the `over` operator (Porter and Duff 1984). A backend gives one thing, the closest accepted hits
// of a packet; everything else along rays is here. Gaussian splats between surfaces are seen on the
// way (splat_light.h).
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/path/splat_light.h"
#include "physics/rays/hits.h"
#include "physics/rays/passed.h"
#include "physics/rays/search_rays.h"
#include "physics/surface/background.h"
#include "physics/surface/surface.h"

namespace omma {

// Below this fraction what lies behind cannot change a response: it is less than a float's
// resolution of 1.
inline constexpr float least_throughput = 1e-7f;

// Linear RGB and the fraction of what lies behind that is covered, [lane].
template <typename L>
struct PacketColor {
  alignas(L::count * 4) float rgb[3][L::count];
  alignas(L::count * 4) float alpha[L::count];
};

// Colours of the lanes that met a surface.
template <typename L>
OMMA_HD void eval_surfaces(const SceneView& scene, const RayPacket<L::count>& rays,
                           const Hits<L>& hits, PacketColor<L>& color) {
  using F = typename L::F;
  using I = typename L::I;
  for_each_mesh(hits, [&](std::int32_t mesh, int l, const auto& is_member) {
    // Lanes of other meshes, and without a hit, hold anything; they go through as zeros.
    const auto of_members = [&](const float* p) { return keep(is_member, load<F>(p + l)); };
    const SurfaceColor<F> s = eval_surface(
        scene, scene.meshes[mesh],
        SurfacePoint<F, I>{keep(is_member, load<I>(rays.triangle + l)), of_members(rays.u),
                           of_members(rays.v), of_members(hits.footprint_m)});
    for (int c = 0; c < 3; ++c)
      store(color.rgb[c] + l, is_member ? s.rgb[c] : load<F>(color.rgb[c] + l));
    store(color.alpha + l, is_member ? s.alpha : load<F>(color.alpha + l));
  });
}

// The background, which covers all, of all lanes at once.
template <typename L>
OMMA_HD void eval_backgrounds(const SceneView& scene, const Packet<L>& packet,
                              PacketColor<L>& color) {
  const float(&direction)[3][L::count] = packet.rays.direction;
  const auto eval_lanes = [&](const auto& eval) {
    for (int l = 0; l < L::count; ++l) {
      const Vec3 rgb =
          eval(Vec3{direction[0][l], direction[1][l], direction[2][l]}, packet.footprint_rad[l]);
      color.rgb[0][l] = rgb.x;
      color.rgb[1][l] = rgb.y;
      color.rgb[2][l] = rgb.z;
    }
  };
  const BackgroundView& background = scene.background;
  for (int l = 0; l < L::count; ++l) color.alpha[l] = 1;
  switch (background.type) {
    case BackgroundType::constant:
      return eval_lanes([&](Vec3, float) { return background.color; });
    case BackgroundType::simple_sky:
      return eval_lanes([](Vec3 d, float) { return eval_simple_sky(d); });
    case BackgroundType::test_pattern:
      return eval_lanes([](Vec3 d, float) { return eval_test_pattern(d); });
    case BackgroundType::image:
      return eval_lanes([&](Vec3 d, float footprint_rad) {
        return eval_background_image(background, d, footprint_rad);
      });
  }
}

// Hands each band of some lanes' colours to `consume(band, radiance)`: linear RGB itself, or what
// the scene's matrix makes of it.
template <typename F, typename Consume>
OMMA_HD void lift(const SceneView& scene, const F (&rgb)[3], const Consume& consume) {
  if (scene.band_from_rgb == nullptr) {
    for (int b = 0; b < 3; ++b) consume(b, rgb[b]);
    return;
  }
  for (int b = 0; b < scene.bands; ++b) {
    const float* row = scene.band_from_rgb + 3 * b;
    consume(b, rgb[0] * row[0] + rgb[1] * row[1] + rgb[2] * row[2]);
  }
}

// What the rays of a packet are followed in.
template <typename L, typename Search>
struct UnlitFlight {
  const SceneView& scene;
  Search& search;
  Packet<L>& packet;
  const PassedSurfaces* passed;  // where surfaces let light through in part, else null
};

// One step along the rays of some lanes: the closest hits and the colours there, or the
// background's.
template <typename L, typename Search>
OMMA_HD void eval_closest(const UnlitFlight<L, Search>& flight, LaneMask<L> on, Hits<L>& hits,
                          PacketColor<L>& color) {
  Packet<L>& packet = flight.packet;
  // Intersect.
  clear_hits<L>(packet.rays);
  search_closest(flight.search, on, packet.rays, flight.passed, Spread::together);
  find_hits<L>(flight.search.placed(), packet, hits);
  // What the background sends, where nothing was met, and what surfaces do.
  if ((~lanes_met(hits)).any()) eval_backgrounds<L>(flight.scene, packet, color);
  eval_surfaces<L>(flight.scene, packet.rays, hits, color);
}

// Radiance [band][lane] of the rays of some lanes of a packet. `first`: takes what they met first,
// or null.
template <typename L, typename Search>
OMMA_HD_CALLED void eval_path(const UnlitFlight<L, Search>& flight, LaneMask<L> on, float* radiance,
                              FirstHits<L>* first = nullptr) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  Packet<L>& packet = flight.packet;
  Hits<L> hits;
  PacketColor<L> color;
  alignas(L::count * 4) float seen_m[L::count];  // up to where splats have been seen
  for (int l = 0; l < L::count; ++l) seen_m[l] = 0;
  const auto eval_step = [&] {
    eval_closest(flight, on, hits, color);
    if (first != nullptr) *first = {packet, hits};
    if (scene.splats != nullptr) cover_with_splats(flight, on, seen_m, color, first);
    first = nullptr;
  };
  const auto colors_at = [&](int l, F(&rgb)[3]) {
    for (int c = 0; c < 3; ++c) rgb[c] = load<F>(color.rgb[c] + l);
  };

  // Opaque scenes: what is met first is all there is.
  if (flight.passed == nullptr) {
    eval_step();
    for (int l = 0; l < L::count; l += L::width) {
      F rgb[3];
      colors_at(l, rgb);
      lift(scene, rgb, [&](int b, F x) { store(radiance + b * L::count + l, x); });
    }
    return;
  }

  clear<L>(*flight.passed);
  alignas(L::count * 4) float throughput[L::count];  // Π (1 − α): what lies behind still counts
  for (int l = 0; l < L::count; ++l) throughput[l] = 1;
  for (int i = 0; i < scene.bands * L::count; ++i) radiance[i] = 0;
  while (on.any()) {
    eval_step();
    // Composite: what the surface covers of what still counts; paths end where nothing gets
    // through.
    LaneMask<L> through;
    for (int l = 0; l < L::count; l += L::width) {
      const auto is_on = on.at(l);
      const F before = load<F>(throughput + l), alpha = load<F>(color.alpha + l);
      F rgb[3];
      colors_at(l, rgb);
      lift(scene, rgb, [&](int b, F x) {
        float* sum = radiance + b * L::count + l;
        store(sum, is_on ? load<F>(sum) + before * alpha * x : load<F>(sum));
      });
      const F after = before * (1.0f - alpha);
      store(throughput + l, is_on ? after : before);
      through.bits |= lane_bits(after > least_throughput) << l;
    }
    // On behind the surface.
    on &= through;
    on.for_each([&](int l) { pass(*flight.passed, l, packet.rays); });
  }
}

}  // namespace omma
