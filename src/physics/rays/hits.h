// What rays met, where that is, and how rays leave it again without meeting it (self-intersection
// offset).
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/lanes/vector3.h"
#include "physics/rays/rays.h"
#include "physics/views/scene_view.h"

namespace omma {

// In place of a mesh: nothing was met; as ground truth has it, splats were (path/splat_light.h),
// whose cloud stands as an instance behind those of the scene.
inline constexpr std::int32_t no_mesh = -1, mesh_of_splats = -2;

// What each ray met, [lane].
template <typename L>
struct Hits {
  alignas(L::count * 4) std::int32_t mesh[L::count];      // index, or one of the two below
  alignas(L::count * 4) std::int32_t instance[L::count];  // of the scene, where there is a mesh
  alignas(L::count * 4) float footprint_m[L::count];      // of the ray there, in metres of the mesh
};

// The rays of a packet as they left the eye, and what they met.
template <typename L>
struct FirstHits {
  Packet<L> packet;
  Hits<L> hits;
  // Among Gaussian splats: Σ w_k t_k and Σ w_k over all that light comes from, w_k the share of it.
  alignas(L::count * 4) float source_m[L::count] = {};
  alignas(L::count * 4) float source_weight[L::count] = {};
};

template <typename L>
OMMA_HD void find_hits(const PlacedMesh* placed, const Packet<L>& packet, Hits<L>& hits) {
  using F = typename L::F;
  using I = typename L::I;
  static_assert(sizeof(PlacedMesh) == 16);
  for (int l = 0; l < L::count; l += L::width) {
    const I geometry = load<I>(packet.rays.geometry + l);
    const I instance = load<I>(packet.rays.instance + l);
    const I top = instance < 0 ? geometry : instance;  // `none` is -1
    const I index = top < 0 ? top * 0 : top;
    const Pair<I> found = gather_pair(&placed->mesh, index * 2);
    store(hits.mesh + l, geometry < 0 ? geometry : found.first);
    store(hits.instance + l, gather(&placed->instance, index * 4));
    store(hits.footprint_m + l, load<F>(packet.footprint_rad + l) *
                                    load<F>(packet.rays.t_far_m + l) * float_of(found.second));
  }
}

// Nothing found yet.
template <typename L>
OMMA_HD void clear_hits(RayPacket<L::count>& rays) {
  for (int l = 0; l < L::count; ++l) {
    rays.t_far_m[l] = INFINITY;
    rays.geometry[l] = none;
    rays.instance[l] = none;
  }
}

// Lanes whose rays met a surface.
template <typename L>
OMMA_HD LaneMask<L> lanes_met(const Hits<L>& hits) {
  return lanes_where<L>([&](int l) { return load<typename L::I>(hits.mesh + l) >= 0; });
}

// Calls `eval(mesh, l, is_member)` for lanes from l on of each mesh that was met: mostly all lanes
// see the same one.
template <typename L, typename Eval>
OMMA_HD void for_each_mesh(const Hits<L>& hits, const Eval& eval) {
  using I = typename L::I;
  for (LaneMask<L> left = lanes_met(hits); left.any();) {
    const std::int32_t mesh = hits.mesh[lowest_bit(left.bits)];
    const auto members = lanes_where<L>([&](int l) { return load<I>(hits.mesh + l) == mesh; });
    left &= ~members;
    for (int l = 0; l < L::count; l += L::width)
      if (members.word(l) != 0) eval(mesh, l, load<I>(hits.mesh + l) == mesh);
  }
}

// The transforms of meshes' frames, [row][column], of the instances that some lanes from l on met;
// mostly all met the same. The other lanes get any.
template <typename L, typename Members, typename F>
OMMA_HD void load_frames(const SceneView& scene, const Hits<L>& hits, int l,
                         const Members& is_member, F (&m)[3][4]) {
  using I = typename L::I;
  const float* const frames = scene.frame_from_mesh;
  const std::int32_t one = hits.instance[l + lowest_bit(lane_bits(is_member))];
  const I met = load<I>(hits.instance + l), instance = is_member ? met : met * 0 + one;
  const bool is_one = !any_lane(instance != one);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) {
      const int at = 4 * r + c;
      m[r][c] = is_one ? broadcast<F>(frames[std::ptrdiff_t{12} * one + at])
                       : gather(frames + at, instance * 12);
    }
}

// Where surfaces were met, in the traced frame, [lane]; zeros where nothing was.
template <typename L>
struct HitGeometry {
  alignas(L::count * 4) float position[3][L::count];  // m
  // The triangle's own: unit, towards the side from which corners are seen counter-clockwise.
  // Normals of vertices and normal maps are read by lit_surface.h.
  alignas(L::count * 4) float normal[3][L::count];
  // The largest coordinate of the triangle's corners, in magnitude, m: by it places on the surface
  // are known.
  alignas(L::count * 4) float reach_m[L::count];
};

template <typename L>
OMMA_HD_CALLED void eval_geometry(const SceneView& scene, const RayPacket<L::count>& rays,
                                  const Hits<L>& hits, HitGeometry<L>& geometry) {
  using F = typename L::F;
  using I = typename L::I;
  geometry = {};
  for_each_mesh(hits, [&](std::int32_t mesh, int l, const auto& is_member) {
    const MeshView& view = scene.meshes[mesh];
    const I triangle = keep(is_member, load<I>(rays.triangle + l));
    const F weight_1 = load<F>(rays.u + l), weight_2 = load<F>(rays.v + l);
    const F weight[3] = {1.0f - weight_1 - weight_2, weight_1, weight_2};
    F m[3][4], reach = {};
    load_frames(scene, hits, l, is_member, m);
    I vertex[3];
    gather_3(view.triangles, triangle, vertex);
    Vector3<F> corner[3], position = {};
    for (int k = 0; k < 3; ++k) {
      corner[k] = transform_point(m, gather_vector<F>(view.positions, vertex[k]));
      position = position + corner[k] * weight[k];
      for (int r = 0; r < 3; ++r) {
        const F x = corner[k][r], size = x < 0.0f ? -x : x;
        reach = size > reach ? size : reach;
      }
    }
    // A mirrored mesh is seen from the side on which its own corners go counter-clockwise.
    const F det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) +
                  m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
                  m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    const F side = det < 0.0f ? broadcast<F>(-1.0f) : broadcast<F>(1.0f);
    Vector3<F> n = cross(corner[1] - corner[0], corner[2] - corner[0]);
    // Scaled first, so that squares of small areas do not vanish.
    F largest = {};
    for (int r = 0; r < 3; ++r) {
      const F size = n[r] < 0.0f ? -n[r] : n[r];
      largest = size > largest ? size : largest;
    }
    n = n * (1.0f / (largest > 0.0f ? largest : broadcast<F>(1.0f)));
    const F length = sqrt_lanes(dot(n, n));
    const F unit = side / (length > 0.0f ? length : broadcast<F>(1.0f));
    const auto set = [&](float* values, F value) {
      store(values + l, is_member ? value : load<F>(values + l));
    };
    const auto set_vector = [&](float(&values)[3][L::count], const Vector3<F>& value) {
      store_vector(values, l, select(is_member, value, load_vector<F>(values, l)));
    };
    set_vector(geometry.position, position);
    set_vector(geometry.normal, n * unit);
    set(geometry.reach_m, reach);
  });
}

// A ray that leaves a surface starts so far above it that it does not meet it again, on its own
// side of the triangle: rounding puts places on it, and what a search computes of its plane, off by
// some multiples of float's resolution of its corners' coordinates. Waechter and Binder 2019 (Ray
// Tracing Gems, chapter 6) go by the resolution of the place itself instead, which fails where
// triangles are large beside their distance from the origin, or scenes are of micrometres.
// `towards`: the new direction; all of one lane.
inline constexpr float leave_resolutions = 0x1p-19f;  // 32 of them

template <typename F>
OMMA_HD Vector3<F> leave_surface(const Vector3<F>& position, const Vector3<F>& normal, F reach_m,
                                 const Vector3<F>& towards) {
  const F distance = reach_m * leave_resolutions;
  const F step = dot(normal, towards) < 0.0f ? 0.0f - distance : distance;
  return position + normal * step;
}

// The same of what rays of lanes from l on met.
template <typename L, typename F>
OMMA_HD Vector3<F> leave_surface(const HitGeometry<L>& geometry, int l, const Vector3<F>& towards) {
  return leave_surface(load_vector<F>(geometry.position, l), load_vector<F>(geometry.normal, l),
                       load<F>(geometry.reach_m + l), towards);
}

// Rays begin at what others met; `towards` [lane].
template <typename L>
OMMA_HD void leave_surfaces(const HitGeometry<L>& geometry, const float (&towards)[3][L::count],
                            RayPacket<L::count>& rays) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    const auto direction = load_vector<F>(towards, l);
    store_vector(rays.origin, l, leave_surface(geometry, l, direction));
    store_vector(rays.direction, l, without_noise(direction));
    store(rays.t_near_m + l, F{});
  }
}

// Rays of some lanes go on from what they met; the others' are left.
template <typename L>
OMMA_HD void leave_surfaces(const HitGeometry<L>& geometry, const float (&towards)[3][L::count],
                            LaneMask<L> lanes, RayPacket<L::count>& rays) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    const auto leaves = lanes.at(l);
    if (!any_lane(leaves)) continue;
    const auto direction = load_vector<F>(towards, l);
    const auto set = [&](float(&values)[3][L::count], const Vector3<F>& value) {
      store_vector(values, l, select(leaves, value, load_vector<F>(values, l)));
    };
    set(rays.origin, leave_surface(geometry, l, direction));
    set(rays.direction, without_noise(direction));
    store(rays.t_near_m + l, leaves ? F{} : load<F>(rays.t_near_m + l));
  }
}

}  // namespace omma
