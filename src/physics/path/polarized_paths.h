// What polarisation adds to the lit path: Mueller matrices of paths, which grow with each surface,
// and Stokes vectors of light that arrives or is scattered. Nothing here is called where light is
// not polarised.
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/path/flight.h"
#include "physics/path/scattered.h"
#include "physics/surface/boundary_table.h"
#include "physics/surface/fresnel.h"

namespace omma {

template <typename L>
OMMA_HD Mueller3<typename L::F> load_mueller(const PathState<L>& state, int l) {
  Mueller3<typename L::F> m;
  for (int k = 0; k < 9; ++k) m.m[k / 3][k % 3] = load<typename L::F>(state.mueller[k] + l);
  return m;
}

// Element k of the matrices of paths in a band, [lane].
template <typename L>
OMMA_HD const float* mueller_in(const SceneView& scene, const PathState<L>& state,
                                const PathMemory& memory, int k, int band) {
  return memory.mueller == nullptr ? state.mueller[k]
                                   : memory.mueller + (k * scene.bands + band) * L::count;
}
template <typename L>
OMMA_HD Mueller3<typename L::F> load_mueller(const SceneView& scene, const PathState<L>& state,
                                             const PathMemory& memory, int band, int l) {
  Mueller3<typename L::F> m;
  for (int k = 0; k < 9; ++k)
    m.m[k / 3][k % 3] = load<typename L::F>(mueller_in(scene, state, memory, k, band) + l);
  return m;
}

// Whether of light that arrives at a path's end more than I counts: not where a diffuse surface
// lies on it.
template <typename L>
OMMA_HD bool keeps_polarisation(const PathState<L>& state, int l) {
  for (int k = 0; k < 9; ++k)
    if (k % 3 != 0 && state.mueller[k][l] != 0.0f) return true;
  return false;
}

// Lanes whose path's Mueller matrix has something in one of the places for which `counts(k)` is so.
template <typename L, typename Counts>
OMMA_HD LaneMask<L> where_mueller(const PathState<L>& state, const Counts& counts) {
  return lanes_where<L>([&](int l) {
    using F = typename L::F;
    F most{};
    for (int k = 0; k < 9; ++k) {
      if (!counts(k)) continue;
      const F x = load<F>(state.mueller[k] + l);
      most = most + x * x;
    }
    return most > 0.0f;
  });
}

// Lanes of whose path's light more than I counts: those without a diffuse surface on it.
template <typename L>
OMMA_HD LaneMask<L> keeping_polarisation(const PathState<L>& state) {
  return where_mueller<L>(state, [](int k) { return k % 3 != 0; });
}

// Lanes whose path brings more than I to the eye: not where the surface nearest to it is diffuse.
template <typename L>
OMMA_HD LaneMask<L> bringing_polarisation(const PathState<L>& state) {
  return where_mueller<L>(state, [](int k) { return k / 3 != 0; });
}

// The reference axis of light from afar in a direction (omma/light.h).
template <typename F>
OMMA_HD Vector3<F> vertical_axis(const Vector3<F>& d) {
  const F level = d.x * d.x + d.z * d.z, one = broadcast<F>(1.0f);
  const auto is_zenith = level < 1e-14f;  // or nadir: of azimuth 0
  const F scale = 1.0f / sqrt_lanes(is_zenith ? one : level);
  return {is_zenith ? F{} : (0.0f - d.y * d.x) * scale, is_zenith ? F{} : level * scale,
          is_zenith ? (d.y > 0.0f ? one : 0.0f - one) : (0.0f - d.y * d.z) * scale};
}

// The same of a packet's directions, [lane].
template <typename L>
OMMA_HD void vertical_axes(const float (&direction)[3][L::count], float (&axis)[3][L::count]) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width)
    store_vector(axis, l, vertical_axis(load_vector<F>(direction, l)));
}

// add_light of the lanes from l on, with weights w, where light is polarised.
template <typename L, typename Search>
OMMA_HD void add_polarized_light(const Flight<L, Search>& flight, typename L::F w, int l,
                                 const float (*axis)[L::count], const float* light) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  const PathState<L>& state = flight.state;
  const int stride = flight.stride();
  const bool by_band = flight.memory.mueller != nullptr;
  const auto is_on = w != 0.0f;
  Mueller3<F> path = load_mueller(state, l);
  FrameTurn<F> turn{};
  bool keeps = false;
  for (int k = l; k < l + L::width; ++k) keeps = keeps || keeps_polarisation<L>(state, k);
  const bool turns = axis != nullptr && keeps;
  if (turns) {
    const auto own = load_vector<F>(flight.packet.reference, l);
    const Vector3<F> across = cross(load_vector<F>(flight.packet.rays.direction, l), own);
    turn =
        frame_turn(own, across, {load<F>(axis[0] + l), load<F>(axis[1] + l), load<F>(axis[2] + l)});
    path = path * turn;
  }
  for (int b = 0; b < scene.bands; ++b) {
    if (by_band) {
      path = load_mueller(scene, state, flight.memory, b, l);
      if (turns) path = path * turn;
    }
    const int at = b * L::count + l;
    const F scale = load<F>(flight.memory.throughput + at) * w;
    const F i = load<F>(light + at);
    Stokes<F> s{path.m[0][0] * i, path.m[1][0] * i, path.m[2][0] * i};
    if (turns)
      s = path * Stokes<F>{i, load<F>(light + stride + at), load<F>(light + 2 * stride + at)};
    else if (keeps)
      s = path * Stokes<F>{i, F{}, F{}};
    const F of_eye[3] = {s.i, s.q, s.u};
    for (int p = 0; p < 3; ++p) {
      float* const sum = flight.radiance + p * stride + at;
      store(sum, load<F>(sum) + keep(is_on, scale * of_eye[p]));
    }
  }
}

// How the light that leaves diffusely is polarised, by the reference axes of the lanes' rays.
template <typename L>
OMMA_HD void polarize_diffuse(const Packet<L>& packet, int l, ScatteringPacket<L>& scattering) {
  using F = typename L::F;
  const int v = l / L::width;
  const ScatterPoint<F>& point = scattering.point[v];
  const auto own = load_vector<F>(packet.reference, l);
  const Vector3<F> s = reflection_axis(point.direction, point.normal, own);
  const Stokes<F> seen = frame_turn(own, cross(point.direction, own), s) *
                         Stokes<F>{broadcast<F>(1.0f), diffuse_polarization(point), F{}};
  scattering.diffuse_q[v] = seen.q;
  scattering.diffuse_u[v] = seen.u;
}

// Of a packet's directions those of the lanes from l on.
template <typename L>
struct DirectionsAt {
  const float (&w)[3][L::count];  // [lane]
  int l;
};

// scatter_light of the lanes from l on, where light is polarised; `metal_in`: with_metal_lobe's.
template <typename L, typename Search, typename Metal>
OMMA_HD void scatter_polarized_light(const Flight<L, Search>& flight,
                                     const ScatteringPacket<L>& points, const Scattered<L>& by,
                                     const DirectionsAt<L>& from, const Metal& metal_in,
                                     float* light) {
  using F = typename L::F;
  const Packet<L>& packet = flight.packet;
  const int stride = flight.stride(), l = from.l;
  const LobeValues<F> lobes = load_lobes(by, l);
  const Mueller<F> dielectric{lobes.dielectric, load<F>(by.dielectric[1] + l),
                              load<F>(by.dielectric[2] + l)};
  const Mueller<F> coat{lobes.coat, load<F>(by.coat[1] + l), load<F>(by.coat[2] + l)};
  const auto d = load_vector<F>(packet.rays.direction, l), w = load_vector<F>(from.w, l);
  const auto own = load_vector<F>(packet.reference, l);
  const Vector3<F> s = reflection_axis(d, w, own);
  // From the light's axes to s, and from s to the ray's.
  const FrameTurn<F> before = frame_turn(s, cross(w, s), vertical_axis(w));
  const FrameTurn<F> after = frame_turn(own, cross(d, own), s);
  for (int b = 0; b < flight.scene.bands; ++b) {
    const int at = b * L::count + l;
    const BandColor<F> color = load_color<L>(flight.memory, at);
    const F i = load<F>(light + at), tint = dielectric_tint(lobes, color);
    const Mueller<F> metal = metal_in(lobes, color, b);
    const Stokes<F> arriving{i, load<F>(light + stride + at), load<F>(light + 2 * stride + at)};
    const Mueller<F> mirrored{dielectric.a * tint + coat.a + metal.a,
                              dielectric.b * tint + coat.b + metal.b,
                              dielectric.c * tint + coat.c + metal.c};
    const Stokes<F> out = after * (mirrored * (before * arriving));
    const F diffuse = diffuse_lobes(lobes, color) * i;
    store(light + at, out.i + diffuse);
    store(light + stride + at, out.q + diffuse * points.diffuse_q[l / L::width]);
    store(light + 2 * stride + at, out.u + diffuse * points.diffuse_u[l / L::width]);
  }
}

// How a mirror reflects in a band, over what it reflects, where that is by a table; else `mirror`.
template <typename F, typename Mask>
OMMA_HD Mueller<F> band_mirror(const float* tables, const BoundaryPlace<F>& at, Mask is_metal,
                               const Mueller<F>& mirror, int band) {
  const auto by_table = is_metal && at.table >= 0;
  const Mueller<F> table = eval_boundary(tables, at, band);
  const F scale = 1.0f / (table.a > 0.0f ? table.a : broadcast<F>(1.0f));
  return {mirror.a, by_table ? table.b * scale : mirror.b, by_table ? table.c * scale : mirror.c};
}

// Lengthens the paths of the lanes from l on whose matrices differ by band:
// lengthen(path, band, keep_at), which calls keep_at(k, x) for the elements k of the longer path.
template <typename L, typename Lengthen>
OMMA_HD void lengthen_by_band(const SceneView& scene, PathState<L>& state, const PathMemory& memory,
                              int l, const Lengthen& lengthen) {
  using F = typename L::F;
  F largest[9] = {};
  for (int b = 0; b < scene.bands; ++b)
    lengthen(load_mueller(scene, state, memory, b, l), b, [&](int k, F x) {
      store(memory.mueller + (k * scene.bands + b) * L::count + l, x);
      const F size = x < 0.0f ? 0.0f - x : x;
      largest[k] = size > largest[k] ? size : largest[k];
    });
  for (int k = 0; k < 9; ++k) store(state.mueller[k] + l, largest[k]);
}

// What goes straight through a sheet of glass, over how much: of each polarisation what its
// boundary does not reflect, so that sheets in even light leave it even.
template <typename F>
OMMA_HD Mueller<F> straight_mueller(const ScatterPoint<F>& point) {
  const F one = broadcast<F>(1.0f), b = diffuse_polarization(point), c_2 = one - b * b;
  return {one, b, sqrt_lanes(c_2 > 0.0f ? c_2 : F{})};
}

// Mueller matrices of paths that have gone on by a sample, of the lanes from l on, and the
// reference axes of their new rays.
template <typename L, typename Search>
OMMA_HD void lengthen_matrices(const Flight<L, Search>& flight, const ScatteringPacket<L>& points,
                               const ScatteringSample<L>& sample, int l) {
  using F = typename L::F;
  using I = typename L::I;
  const SceneView& scene = flight.scene;
  Packet<L>& packet = flight.packet;
  PathState<L>& state = flight.state;
  const PathMemory& memory = flight.memory;
  const Scattered<L>& by = sample.by;
  const LobeValues<F> lobes = load_lobes(by, l);
  const I lobe = load<I>(sample.lobe + l);
  const auto is = [&](Lobe one) { return lobe == static_cast<std::int32_t>(one); };
  const auto d = load_vector<F>(packet.rays.direction, l), w = load_vector<F>(sample.direction, l);
  const auto own = load_vector<F>(packet.reference, l);
  const Vector3<F> s = reflection_axis(d, w, own), across = cross(d, own);
  // As parts of what is reflected, which the throughput has.
  const auto is_coat = is(Lobe::coat);
  const auto is_metal = is(Lobe::metal);
  const F a = is_coat ? lobes.coat : lobes.dielectric;
  const F scale = 1.0f / (a > 0.0f ? a : broadcast<F>(1.0f));
  const F b = (is_coat ? load<F>(by.coat[1] + l) : load<F>(by.dielectric[1] + l)) * scale;
  const F c = (is_coat ? load<F>(by.coat[2] + l) : load<F>(by.dielectric[2] + l)) * scale;
  const F one = broadcast<F>(1.0f);
  const Mueller<F> mirror{one, is_metal ? F{} : b, is_metal ? 0.0f - one : c};
  const Stokes<F> leaving{one, points.diffuse_q[l / L::width], points.diffuse_u[l / L::width]};
  const FrameTurn<F> turn = frame_turn(own, across, s);
  const auto is_mirrored = is_coat || is_metal || is(Lobe::dielectric) || lobe == refracted;
  const auto is_straight = is(Lobe::straight) || lobe == let_by;
  const auto is_glass = is(Lobe::straight);
  const Mueller<F> let_through = straight_mueller(points.point[l / L::width]);
  const FrameTurn<F> turn_back{turn.cosine, 0.0f - turn.sine};
  const auto lengthen = [&](const Mueller3<F>& before, const Mueller<F>& by_mirror,
                            const auto& keep_at) {
    const Mueller3<F> mirrored = before * turn * by_mirror;
    const Mueller3<F> diffuse = depolarized(before, leaving);
    const Mueller3<F> straight = before * turn * let_through * turn_back;
    for (int k = 0; k < 9; ++k) {
      const int r = k / 3, q = k % 3;
      const F scattered = is_mirrored ? mirrored.m[r][q] : diffuse.m[r][q];
      const F on = is_glass ? straight.m[r][q] : before.m[r][q];
      keep_at(k, is_straight ? on : scattered);
    }
  };
  if (memory.mueller == nullptr) {
    lengthen(load_mueller(state, l), mirror, [&](int k, F x) { store(state.mueller[k] + l, x); });
  } else {
    const BoundaryPlace<F> at = load_boundary(scene, points.boundary, by, l);
    lengthen_by_band(
        scene, state, memory, l, [&](const Mueller3<F>& path, int band, const auto& keep_at) {
          lengthen(path, band_mirror(scene.boundaries, at, is_metal, mirror, band), keep_at);
        });
  }
  // Any axis across the new ray will do for what was depolarised.
  const Vector3<F> next = select(is_mirrored, s, make_axes(w).tangent);
  store_vector(packet.reference, l, select(is_straight, own, next));
}

}  // namespace omma
