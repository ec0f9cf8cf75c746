// Where the paths of a packet stand, and what light from their end still counts: a throughput for
// each band times, where light is polarised, one Mueller matrix for all bands, as lobes that
// polarise do so alike in all bands, and all others leave of a Stokes vector its I alone. Where
// surfaces reflect by tables (boundary_table.h) each band has a matrix of its own.
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/path/media.h"
#include "physics/rays/rays.h"
#include "physics/sampling/path_points.h"
#include "physics/views/path_memory.h"

namespace omma {

// Most flights of a path. Roulette ends them long before, but for light that goes straight through
// more sheets than that.
inline constexpr int most_flights = 4096;

// From so many scatterings on a path may end before it leaves the scene, and it goes on with at
// most this probability.
inline constexpr int roulette_after = 3;
inline constexpr float most_survival = 0.95f;

// Numbers that decide on the way of a path; each a pair of path_points.h for each flight.
enum class Choice : std::uint32_t { light, place_on_light, lobe_and_roulette, direction, count };

// Where the paths of a packet stand, [lane].
template <typename L>
struct PathState {
  static constexpr int n = L::count;
  // Probability per solid angle with which the ray's direction was chosen, that of its lobe
  // included; infinite for rays from the eye.
  alignas(n * 4) float density[n];
  // Row by row, where light is polarised; with a matrix for each band, PathMemory::mueller, the
  // largest size of each element.
  alignas(n * 4) float mueller[9][n];
  alignas(n * 4) std::int32_t scatterings[n];
  alignas(n * 4) std::int32_t flight[n];  // how many flights lie behind
  // Whether the last surface sampled SceneView::all_lights, 0 or 1; read where there are such.
  alignas(n * 4) std::int32_t sampled_all[n];
  // How that one chose a light, where there are near ones: LightKinds, and LitPoint's normal.
  alignas(n * 4) float chose_far[n], chose_surface[n], lit_normal[3][n];
  float seen_m[n];  // up to where along the ray splats have been seen
  // Whether rays begin at a surface and gather what scattered light comes there: they see neither
  // discs nor what shines until they have met another surface.
  bool gathers = false;
};

// Paths that have not left yet; what is by band is in PathMemory.
template <typename L>
OMMA_HD void reset_paths(const SceneView& scene, PathState<L>& state, const PathMemory& memory) {
  constexpr int n = L::count;
  for (int i = 0; i < scene.bands * n; ++i) memory.throughput[i] = 1;
  for (int l = 0; l < n; ++l) {
    state.density[l] = INFINITY;
    state.scatterings[l] = state.flight[l] = state.sampled_all[l] = 0;
    state.seen_m[l] = 0;
    state.chose_far[l] = 1;
    state.chose_surface[l] = 0;
    store_vector(state.lit_normal, l, Vector3<float>{});
  }
  if (scene.has_volumes) begin_in<L>(memory.media, no_medium);
  if (!scene.polarized) return;
  for (int k = 0; k < 9; ++k)
    for (int l = 0; l < n; ++l) state.mueller[k][l] = k % 4 == 0 ? 1.0f : 0.0f;
  if (memory.mueller == nullptr) return;
  for (int k = 0; k < 9; ++k)
    for (int i = 0; i < scene.bands * n; ++i)
      memory.mueller[k * scene.bands * n + i] = k % 4 == 0 ? 1.0f : 0.0f;
}

// The pair of numbers for a choice on the present flight, of lanes from l on.
template <typename L>
OMMA_HD UnitPair<typename L::F> choose(const Packet<L>& packet, const PathState<L>& state, int l,
                                       Choice choice) {
  using U = typename L::U;
  const U first = load<U>(state.flight + l) * static_cast<std::uint32_t>(Choice::count);
  return path_pair(load<U>(packet.hash + l), load<U>(packet.sample + l),
                   first + static_cast<std::uint32_t>(choice));
}

// Lanes of which the last surface sampled all lights, though others read baked light.
template <typename L>
OMMA_HD LaneMask<L> having_sampled_all(const SceneView& scene, const PathState<L>& state) {
  if (scene.all_lights == nullptr) return {};
  return lanes_where<L>([&](int l) { return load<typename L::I>(state.sampled_all + l) != 0; });
}

// Lanes whose paths have been scattered as often as the depth allows.
template <typename L>
OMMA_HD LaneMask<L> at_full_depth(const SceneView& scene, const PathState<L>& state) {
  return lanes_where<L>(
      [&](int l) { return load<typename L::I>(state.scatterings + l) >= scene.depth; });
}

OMMA_HD bool is_from_eye(float density) {
  return !(density < INFINITY);
}

// Heuristics of multiple importance sampling (Veach 1997, Robust Monte Carlo Methods for Light
// Transport Simulation, 9.2): a direction that was chosen with the density p_1, and could have been
// with p_2, counts by
//
//   w_1 = p_1 / (p_1 + p_2)           balance, for light from afar,
//   w_1 = p_1^2 / (p_1^2 + p_2^2)     power, for surfaces that shine.
//
// Of a sky either way finds as much. A panel is found by few scattered rays, which by the balance
// heuristic count for more: half of the noise, hardly seen in a frame's standard errors.
template <typename F>
OMMA_HD F balance(F chosen, F other) {
  const F sum = chosen + other;
  return sum > 0.0f ? chosen / sum : broadcast<F>(0.0f);
}
template <typename F>
OMMA_HD F power_heuristic(F chosen, F other) {
  const F ratio = other / chosen;
  return chosen > 0.0f ? 1.0f / (1.0f + ratio * ratio) : broadcast<F>(0.0f);
}

}  // namespace omma
