// What surfaces make of light that was baked: diffuse lobes send of it to the eye at once; of the paths
// that gloss sends on some are followed.
#pragma once

#include "physics/baked.h"
#include "physics/path_scatter.h"

namespace omma {

// A path that gloss sends on is followed with a probability over what it counts for that is the first
// of these where that is little, and grows with it by the second to 1, as in mirrors and metals.
inline constexpr float gloss_rays = 0.25f, more_gloss_rays = 3.0f;

// Adds what the diffuse lobes of some lanes' surfaces send to the eye.
template <typename L>
OMMA_HD void add_baked(const SceneView& scene, const PathState<L>& state,
                       const ScatteringPacket<L>& scattering, unsigned lanes,
                       const PathMemory& memory, float* radiance) {
  using F = typename L::F;
  constexpr int n = L::count;
  const int stride = scene.bands * n;
  for (int l = 0; l < n; l += L::width) {
    const auto scatters = lanes_on<L>(lanes, l);
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
        store(radiance + at, load<F>(radiance + at) + sent);
        continue;
      }
      for (int p = 0; p < 3; ++p) {
        float* const to = radiance + p * stride + at;
        store(to, load<F>(to) + keep(scatters, load<F>(state.mueller[3 * p] + l) * sent));
      }
    }
  }
}

// Cells of the sky above the horizon, along each side of the square that an octahedron's upper half
// is when it is unfolded.
inline constexpr int coarse_sky_side = 16;
inline constexpr int coarse_sky_cells = coarse_sky_side * coarse_sky_side;

// The cell of a direction with y >= 0.
template <typename F>
OMMA_HD auto coarse_sky_cell(F x, F y, F z) {
  const auto size = [](F value) { return value < 0.0f ? 0.0f - value : value; };
  const F scale = (0.5f * coarse_sky_side) / (size(x) + y + size(z));
  const auto place = [&](F along) {
    const auto i = to_int(along * scale + 0.5f * coarse_sky_side);
    return i < coarse_sky_side ? i : i * 0 + (coarse_sky_side - 1);
  };
  return place(x - z) * coarse_sky_side + place(x + z);
}

// A direction in such a cell, whose corners are u, v = 0, 1.
OMMA_HD Vec3 coarse_sky_direction(int cell, float u, float v) {
  const float along = (to_float(cell % coarse_sky_side) + u) * (2.0f / coarse_sky_side) - 1.0f;
  const float across = (to_float(cell / coarse_sky_side) + v) * (2.0f / coarse_sky_side) - 1.0f;
  const float x = 0.5f * (along + across), z = 0.5f * (along - across);
  const float y = fmaxf(1.0f - fabsf(x) - fabsf(z), 0.0f);
  const float unit = 1.0f / sqrtf(x * x + y * y + z * z);
  return {x * unit, y * unit, z * unit};
}

// A guess of the light that comes to the surfaces of some lanes along `direction`, [band][lane]: of
// the sky as much as the light about the surface is of what it would be in the open; and in place of
// what hides the rest, and from below, the surface itself.
template <typename L>
OMMA_HD void guess_light(const SceneView& scene, const float (&direction)[3][L::count],
                         unsigned lanes, const PathMemory& memory, float* guess) {
  using F = typename L::F;
  constexpr int n = L::count;
  const BakedView& baked = *scene.baked;
  for (int l = 0; l < n; l += L::width) {
    F d[3];
    load_3(direction, l, d);
    const auto is_up = lanes_on<L>(lanes, l) && d[1] > 0.0f;
    alignas(L::width * 4) std::int32_t cell[L::width];
    store(cell, keep(is_up, coarse_sky_cell(keep(is_up, d[0]),
                                            is_up ? d[1] : broadcast<F>(1.0f),
                                            keep(is_up, d[2]))));
    store_rows<L>(scene.bands, lane_bits(is_up), [&](int k, const auto& read) {
      return read(baked.coarse_sky + static_cast<std::ptrdiff_t>(cell[k]) * scene.bands);
    }, guess + l);
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * n + l;
      const F front = load<F>(memory.front + at);
      const F open = keep(is_up, clamp_unit_lanes(front * baked.per_open_sky[b]));
      store(guess + at, open * load<F>(guess + at) +
                            (1.0f - open) * load<F>(memory.reflectance + at) * front);
    }
  }
}

// Follows only some of the paths that gloss sends on, by chance. The guess of what they would find
// stands for the others, and its mean is made up for by those that are followed, so that nothing is
// lost and whatever the guess is, the mean is right.
template <typename L>
OMMA_HD void follow_some(const SceneView& scene, const Packet<L>& packet,
                         const PathState<L>& state, unsigned scattering, Onward<L>& onward,
                         const float* most, const PathMemory& memory, float* radiance) {
  using F = typename L::F;
  using I = typename L::I;
  constexpr int n = L::count;
  alignas(n * 4) float part[n], scale[n];
  unsigned by_gloss = 0;
  bool is_scaled = false;
  const F one = broadcast<F>(1.0f);
  for (int l = 0; l < n; l += L::width) {
    const I lobe = load<I>(onward.lobe + l);
    const F largest = load<F>(most + l);
    const auto asked = lanes_on<L>(scattering, l) && lobe >= 0 &&
                       lobe != static_cast<std::int32_t>(Lobe::straight) && largest > 0.0f &&
                       load<F>(onward.density + l) > 0.0f;
    const F over = gloss_rays + more_gloss_rays * largest;
    const F wanted = largest * (over < 1.0f ? over : one);
    // Paths between mirrors end too.
    const F bound =
        load<I>(state.scatterings + l) >= roulette_after ? broadcast<F>(most_survival) : one;
    const F chance = wanted < bound ? wanted : bound;
    const auto goes_on = load<F>(onward.roulette + l) < chance;
    const F more = asked && goes_on ? one / chance : one;
    by_gloss |= lane_bits(asked) << l;
    store(scale + l, more);
    store(part + l, keep(asked, goes_on ? one - more : one));
    store(onward.lobe + l, asked && !goes_on ? lobe * 0 + no_lobe : lobe);
    is_scaled = is_scaled || any_lane(more != 1.0f);
  }
  if (by_gloss == 0) return;
  guess_light<L>(scene, onward.direction, by_gloss, memory, memory.light);
  add_light<L>(scene, packet, state, part, nullptr, memory, memory.light, radiance);
  if (!is_scaled) return;
  for (int b = 0; b < scene.bands; ++b)
    for (int l = 0; l < n; l += L::width) {
      float* const at = memory.throughput + b * n + l;
      store(at, load<F>(at) * load<F>(scale + l));
    }
}

}  // namespace omma
