// Air between surfaces: haze, mist, fog. Over a distance d it leaves T = exp(-σ d) of light (σ its
// extinction coefficient, alike everywhere, by band) and adds light of its own,
//
//   L = T L_0 + (1 - T) J,
//
// J what a level line of sight without end shows, so the sky at the horizon in the ray's azimuth,
// with its polarisation (Koschmieder 1924, Theorie der horizontalen Sichtweite; Duntley 1948, The
// reduction of apparent contrast by the atmosphere). Where a line of sight has no end below either,
// in deep water, J of rays that go down is the sky in their own direction (Duntley 1963, Light in
// the sea). Light from afar is as it arrives, through air.
#pragma once

#include "physics/lanes/powers.h"
#include "physics/path/path_light.h"
#include "physics/path/path_scatter.h"
#include "physics/path/polarized_paths.h"

namespace omma {

OMMA_HD bool has_air(const SceneView& scene) {
  return scene.light->extinction_per_m != nullptr;
}

// T of a band over a distance, m; 1 where that has no end.
template <typename F>
OMMA_HD F air_transmittance(const SceneView& scene, int band, F distance_m) {
  const F left = left_by_depth(distance_m * scene.light->extinction_per_m[band]);
  return distance_m < INFINITY ? left : broadcast<F>(1.0f);
}

// What air leaves of light from lamps and surfaces that shine, `light` [component][band][lane].
template <typename L>
OMMA_HD_CALLED void dim_by_air(const SceneView& scene, LaneMask<L> lanes, const float* distance_m,
                               int components, float* light) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    const auto is = lanes.at(l);
    if (!any_lane(is)) continue;
    for (int b = 0; b < scene.bands; ++b) {
      const F left = is ? air_transmittance(scene, b, load<F>(distance_m + l)) : broadcast<F>(1.0f);
      for (int c = 0; c < components; ++c) {
        float* const at = light + (c * scene.bands + b) * L::count + l;
        store(at, load<F>(at) * left);
      }
    }
  }
}

// Adds (1 - T) J of the rays of some lanes, and leaves T of their paths' throughput. What goes
// straight on through a surface is left out: the ray to what lies behind has all of the way, so
// that sheets that let all light by are not seen.
template <typename L, typename Search>
OMMA_HD_CALLED void pass_air(const Flight<L, Search>& flight, const LitSurface<L>& surface,
                             const ScatteringPacket<L>& points, LaneMask<L> met) {
  using F = typename L::F;
  constexpr int n = L::count;
  const SceneView& scene = flight.scene;
  const PathMemory& memory = flight.memory;
  const RayPacket<n>& rays = flight.packet.rays;
  const LaneMask<L> keeps =
      scene.polarized ? keeping_polarisation<L>(flight.state) & met : LaneMask<L>{};

  // J: the sky where a line of sight has no end, level or down; else its horizon below or above.
  alignas(n * 4) float level[3][n], axis[3][n] = {}, weight[n] = {};
  for (int l = 0; l < n; l += L::width) {
    const auto d = load_vector<F>(rays.direction, l);
    const F down = scene.light->bottomless && any_lane(d.y < 0.0f) ? keep(d.y < 0.0f, d.y) : F{};
    store_vector(level, l, Vector3<F>{d.x, down, d.z});
    store(weight + l, keep(met.at(l), load<F>(surface.alpha + l)));
  }
  SkyLookups<L> on_sky;
  find_far<L>(*scene.light, level, met, on_sky);
  eval_sky_lanes<L>(*scene.light, {level, on_sky, met, keeps, false}, flight.components(),
                    memory.light);

  for (int l = 0; l < n; l += L::width) {
    const auto is = met.at(l);
    if (!any_lane(is)) continue;
    const F straight = points.point[l / L::width].straight, one = broadcast<F>(1.0f);
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * n + l;
      const F left = is ? air_transmittance(scene, b, load<F>(rays.t_far_m + l)) : one;
      const F added =
          keep(is, (1.0f - left) * (1.0f - straight * load<F>(memory.reflectance + at)));
      for (int c = 0; c < flight.components(); ++c) {
        float* const light = memory.light + c * flight.stride() + at;
        store(light, load<F>(light) * added);
      }
    }
  }
  if (keeps.any()) vertical_axes<L>(rays.direction, axis);
  add_light(flight, weight, axis, memory.light);
  for (int l = 0; l < n; l += L::width) {
    const auto is = met.at(l);
    for (int b = 0; b < scene.bands; ++b) {
      float* const at = memory.throughput + b * n + l;
      const F all = load<F>(at);
      store(at, is ? all * air_transmittance(scene, b, load<F>(rays.t_far_m + l)) : all);
    }
  }
}

// Lanes whose paths go straight on through what they met.
template <typename L>
OMMA_HD LaneMask<L> goes_straight(const ScatteringSample<L>& sample) {
  using I = typename L::I;
  constexpr auto straight = static_cast<std::int32_t>(Lobe::straight);
  return lanes_where<L>([&](int l) {
    const I lobe = load<I>(sample.lobe + l);
    return lobe == let_by || lobe == straight;
  });
}

// Takes T back for paths that go straight on: what they meet next is dimmed by all of the way.
template <typename L, typename Search>
OMMA_HD_CALLED void undo_air(const Flight<L, Search>& flight, LaneMask<L> straight) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  for (int l = 0; l < L::count; l += L::width) {
    const auto is = straight.at(l);
    if (!any_lane(is)) continue;
    const F distance_m = load<F>(flight.packet.rays.t_far_m + l);
    for (int b = 0; b < scene.bands; ++b) {
      float* const at = flight.memory.throughput + b * L::count + l;
      const F dimmed = load<F>(at);
      store(at, is ? dimmed / air_transmittance(scene, b, distance_m) : dimmed);
    }
  }
}

}  // namespace omma
