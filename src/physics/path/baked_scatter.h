// What surfaces make of light that was baked: diffuse lobes send of it to the eye at once; paths
// that gloss sends on are followed while they count.
#pragma once

#include "physics/path/baked.h"
#include "physics/path/path_scatter.h"
#include "physics/path/polarized_paths.h"

namespace omma {

// Paths that gloss sends on are all followed that count for so much, as the first on most surfaces
// do. Those that count for less go on by roulette, and then for so much: no path brings less than
// nothing, and none much more than it counts for.
inline constexpr float least_gloss = 1.0f / 64;

// The probability with which such a path goes on, of what it counts for. Paths between mirrors end
// too.
template <typename F, typename I>
OMMA_HD F gloss_survival(F largest, I scatterings) {
  const F bound = scatterings >= roulette_after ? broadcast<F>(most_survival) : broadcast<F>(1.0f);
  const F survival = largest * (1.0f / least_gloss);
  return survival < bound ? survival : bound;
}

// A cell that may be off by more than this on either side, as a fraction of its light, is not read
// where the eye sees it. In rooms and on open ground most are better, among leaves few are.
inline constexpr float coarse_error = 0.2f;

// Of some lanes those whose surfaces' light is read: all but those that the eye itself sees in
// coarse cells. There the path goes on as if nothing were baked, and reads what it meets next
// (final gathering): what errs is then the mean of many cells, and of the light between surfaces
// alone.
template <typename L, typename Search>
OMMA_HD LaneMask<L> find_read(const Flight<L, Search>& flight, const BakedLookup<L>& found,
                                 LaneMask<L> lanes) {
  const BakedView& baked = *flight.scene.baked;
  if (flight.scene.all_lights == nullptr || flight.state.gathers) return lanes;
  LaneMask<L> coarse;
  lanes.for_each([&](int l) {
    if (found.cell[l] == nullptr || flight.state.scatterings[l] > 0) return;
    const std::ptrdiff_t cell = (found.cell[l] - baked.values) / (2 * flight.scene.bands);
    for (int side = 0; side < 2; ++side) {
      const CellError& error = baked.errors[2 * cell + side];
      const float own = decode_error(error.own), shared = decode_error(error.shared);
      if (own * own + shared * shared > coarse_error * coarse_error) coarse.add(l);
    }
  });
  return lanes & ~coarse;
}

// Adds what the diffuse lobes of some lanes' surfaces send to the eye: no light is sampled for
// them.
template <typename L, typename Search>
OMMA_HD_CALLED void add_baked(const Flight<L, Search>& flight,
                              const ScatteringPacket<L>& scattering, LaneMask<L> lanes) {
  using F = typename L::F;
  constexpr int n = L::count;
  const SceneView& scene = flight.scene;
  const PathMemory& memory = flight.memory;
  const int stride = flight.stride();
  for (int l = 0; l < n; l += L::width) {
    const auto scatters = lanes.at(l);
    if (!any_lane(scatters)) continue;
    const F diffuse = scattering.point[l / L::width].diffuse;
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * n + l;
      // Lanes that met nothing have anything for spectra, also what is not a number.
      const F sent =
          keep(scatters, diffuse * load<F>(memory.throughput + at) *
                             (load<F>(memory.reflectance + at) * load<F>(memory.front + at) +
                              load<F>(memory.transmittance + at) * load<F>(memory.back + at)));
      if (!scene.polarized) {
        store(flight.radiance + at, load<F>(flight.radiance + at) + sent);
        continue;
      }
      const int v = l / L::width;
      const Stokes<F> leaving{broadcast<F>(1.0f), scattering.diffuse_q[v], scattering.diffuse_u[v]};
      const Stokes<F> seen = load_mueller<L>(scene, flight.state, memory, b, l) * leaving;
      const F of_eye[3] = {seen.i, seen.q, seen.u};
      for (int p = 0; p < 3; ++p) {
        float* const to = flight.radiance + p * stride + at;
        store(to, load<F>(to) + keep(scatters, of_eye[p] * sent));
      }
    }
  }
}

// What a side of a cell may be off by under each sign, as a fraction of its light.
OMMA_HD void signed_errors(const BakedView& baked, std::ptrdiff_t side,
                           float (&error)[most_error_signs]) {
  const CellError& of = baked.errors[side];
  const float own = decode_error(of.own), shared = decode_error(of.shared);
  const std::uint32_t signs = mix_bits_32(static_cast<std::uint32_t>(side));
  for (int k = 0; k < most_error_signs; ++k)
    error[k] =
        ((signs >> k & 1u) != 0 ? own : -own) + ((of.signs >> k & 1u) != 0 ? shared : -shared);
}

// What of light that leaves a surface with these Stokes parameters arrives at the eye, in a lane
// and a band; throughput is not in it.
template <typename L, typename Search>
OMMA_HD Stokes<float> seen_along_path(const Flight<L, Search>& flight, int l, int b,
                                      const Stokes<float>& leaving) {
  if (!flight.scene.polarized) return leaving;
  Mueller3<float> path;
  for (int k = 0; k < 9; ++k)
    path.m[k / 3][k % 3] = mueller_in<L>(flight.scene, flight.state, flight.memory, k, b)[l];
  return path * leaving;
}

// Adds to the sums of ommatidia what add_baked may be off by: cells err each by itself, but an
// ommatidium by the same for all rays that meet one cell. Bands and components err together.
template <typename L, typename Search>
OMMA_HD_CALLED void add_cell_errors(const Flight<L, Search>& flight,
                                    const ScatteringPacket<L>& scattering,
                                    const BakedLookup<L>& found, LaneMask<L> lanes) {
  constexpr int n = L::count;
  const SceneView& scene = flight.scene;
  const PathMemory& memory = flight.memory;
  const BakedView& baked = *scene.baked;
  const int signs = error_signs(scene);
  alignas(n * 4) float diffuse[n], diffuse_q[n] = {}, diffuse_u[n] = {};
  for (int l = 0; l < n; l += L::width) {
    store(diffuse + l, scattering.point[l / L::width].diffuse);
    if (!scene.polarized) continue;
    store(diffuse_q + l, scattering.diffuse_q[l / L::width]);
    store(diffuse_u + l, scattering.diffuse_u[l / L::width]);
  }
  lanes.for_each([&](int l) {
    if (found.cell[l] == nullptr) return;
    const std::ptrdiff_t cell = (found.cell[l] - baked.values) / (2 * scene.bands);
    const std::ptrdiff_t near = 2 * cell + (found.from_behind.has(l) ? 1 : 0);
    float front[most_error_signs], back[most_error_signs];
    signed_errors(baked, near, front);
    signed_errors(baked, near ^ 1, back);
    float* const sums = flight.cell_errors + flight.packet.ommatidium[l] * cell_error_count(scene);
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * n + l;
      const float scale = diffuse[l] * memory.throughput[at];
      const float in_front = scale * memory.reflectance[at] * memory.front[at],
                  behind = scale * memory.transmittance[at] * memory.back[at];
      const Stokes<float> seen = seen_along_path(flight, l, b, {1.0f, diffuse_q[l], diffuse_u[l]});
      const float of_eye[3] = {seen.i, seen.q, seen.u};
      for (int p = 0; p < flight.components(); ++p)
        for (int k = 0; k < signs; ++k)
          sums[(p * scene.bands + b) * signs + k] +=
              of_eye[p] * (in_front * front[k] + behind * back[k]);
    }
  });
}

}  // namespace omma
