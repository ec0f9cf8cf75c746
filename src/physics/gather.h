// Light that arrives at places from all around, as it is baked: paths begin at points of a patch of
// a surface, or at a place in the air, in directions by the cosine, and are followed like those of an
// eye; in a scene with baked light, to the first diffuse surface, as in the final gathering of a
// radiosity (Ward, Rubinstein and Clear 1988). What comes straight from discs and lamps is left out.
// A packet holds the paths of one place, or of several that have few each.
#pragma once

#include "physics/lit_path.h"
#include "physics/vector3.h"

namespace omma {

struct GatherPlace {
  // A patch of a triangle, on one side: its corners [corner][u, v]. mesh -1: a place in the air.
  std::int32_t instance = -1, mesh = -1, triangle = 0;
  bool is_back = false;
  float uv[3][2] = {};
  float reach_m = 0;  // of a patch: what is nearer hides points from eyes
  Vec3 position, normal;  // of a place in the air, traced frame
  std::uint32_t hash = 0;
};

struct GatherTask {
  const GatherPlace* places = nullptr;
  int count = 0;  // of places; more than one only where a packet holds all their paths
  int paths = 0;  // of each
  // Whose light surfaces that shine are sampled from: of a scene without baked light, which leaves
  // them out.
  const SceneView* shining = nullptr;
};

// Whose path a lane is: the place, null for none, and its number among those of the place.
template <int n>
struct GatherLanes {
  const GatherPlace* place[n];
  std::uint32_t sample[n];
};

// `first`: the number of the first path in the packet.
template <int n>
OMMA_HD void assign_lanes(const GatherTask& task, int first, GatherLanes<n>& lanes) {
  const int each = task.paths < n ? task.paths : n;
  for (int l = 0; l < n; ++l) {
    const int k = l / each, sample = first + l % each;
    lanes.place[l] = k < task.count && sample < task.paths ? task.places + k : nullptr;
    lanes.sample[l] = static_cast<std::uint32_t>(sample);
  }
}

// Choices at the beginning of paths; those on the way count up from 0 (Choice).
inline constexpr std::uint32_t choice_of_point = 0xfffffff0u, choice_of_way = 0xfffffff1u,
                               choice_of_shining = 0xfffffff2u, choice_on_shining = 0xfffffff3u,
                               choice_of_look = 0xfffffff4u;

// Points that are cut out of a patch, or hidden, are chosen anew, so often at most.
inline constexpr std::uint32_t most_attempts = 8;

OMMA_HD std::uint32_t hash_of_attempt(const GatherPlace& place, std::uint32_t attempt) {
  return place.hash + attempt * 0x9e3779b9u;
}

// Of the lanes in `lanes` those whose points are hidden: a ray from there, in a direction by the
// cosine, meets something within the place's reach. By reciprocity points that are kept are as
// frequent as eyes all around see them. What falls on one side of a sheet is seen from both.
template <typename L, typename Search>
OMMA_HD unsigned find_hidden(const SceneView& scene, Search& search,
                             const GatherLanes<L::count>& of, std::uint32_t attempt, unsigned lanes,
                             const HitGeometry<L>& geometry, const PathMemory& memory) {
  constexpr int n = L::count;
  Packet<L> look;
  clear<L>(look.rays);
  alignas(n * 4) std::int32_t asked[n];
  for (int l = 0; l < n; ++l) {
    asked[l] = (lanes >> l & 1u) != 0 ? -1 : 0;
    look.footprint_rad[l] = 0;
    Vector3<float> towards = {0, 1, 0};
    look.rays.t_far_m[l] = 0;
    if (asked[l] != 0) {
      const GatherPlace& place = *of.place[l];
      auto pair = path_pair(hash_of_attempt(place, attempt), of.sample[l], choice_of_look);
      bool from_back = place.is_back;
      if (scene.scatter[scene.meshes[place.mesh].material].transmittance != nullptr) {
        from_back = pair.y < 0.5f;
        pair.y = 2.0f * pair.y - (from_back ? 0.0f : 1.0f);
      }
      const auto normal = load_vector<float>(geometry.normal, l);
      const Vector3<float> up = from_back ? -normal : normal;
      towards = from_local(make_axes(up), up, sample_cosine(pair.x, pair.y));
    }
    leave_surface<L>(geometry, l, towards, look.rays);
    if (asked[l] != 0) look.rays.t_far_m[l] = of.place[l]->reach_m;
  }
  return scene.has_blend || scene.has_glass
             ? lanes & ~dim_by_passing<L>(scene, search, lanes, look, memory.shadow)
             : search.occluded(asked, look.rays);
}

// The packet's points on their patches, as rays would have met them, and their geometry; false where
// none is on a surface. Lanes whose points are all hidden or cut out begin where others of their
// place do; where all of a place are hidden the last ones are taken.
template <typename L, typename Search>
OMMA_HD bool choose_points(const SceneView& scene, Search& search,
                           const GatherLanes<L::count>& of, const PathMemory& memory,
                           Packet<L>& packet, Hits<L>& hits, HitGeometry<L>& geometry) {
  constexpr int n = L::count;
  unsigned all = 0;
  for (int l = 0; l < n; ++l) {
    hits.mesh[l] = -1;
    hits.instance[l] = of.place[l] != nullptr ? of.place[l]->instance : 0;
    hits.footprint_m[l] = 0;
    if (of.place[l] != nullptr) all |= 1u << l;
  }
  const auto put = [&](int l, float u, float v) {
    hits.mesh[l] = of.place[l]->mesh;
    packet.rays.triangle[l] = static_cast<unsigned>(of.place[l]->triangle);
    packet.rays.u[l] = u;
    packet.rays.v[l] = v;
  };
  unsigned seen = 0, any = 0;
  for (std::uint32_t attempt = 0; attempt < most_attempts && seen != all; ++attempt) {
    unsigned tried = 0;
    for (unsigned left = all & ~seen; left != 0; left &= left - 1) {
      const int l = lowest_bit(left);
      const GatherPlace& place = *of.place[l];
      const auto pair = path_pair(hash_of_attempt(place, attempt), of.sample[l], choice_of_point);
      const float root = sqrtf(pair.x), b = root * pair.y, a = root - b;
      const float u = place.uv[0][0] + a * (place.uv[1][0] - place.uv[0][0]) +
                      b * (place.uv[2][0] - place.uv[0][0]);
      const float v = place.uv[0][1] + a * (place.uv[1][1] - place.uv[0][1]) +
                      b * (place.uv[2][1] - place.uv[0][1]);
      const SurfaceHit hit{place.mesh, static_cast<std::uint32_t>(place.triangle), u, v, 0.0f};
      const bool has_holes =
          scene.materials[scene.meshes[place.mesh].material].alpha_mode == AlphaMode::mask;
      if (has_holes && !accept_hit(scene, hit, false)) continue;
      put(l, u, v);
      tried |= 1u << l;
    }
    if (tried == 0) continue;
    any |= tried;
    eval_geometry<L>(scene, packet.rays, hits, geometry);
    seen |= tried & ~find_hidden<L>(scene, search, of, attempt, tried, geometry, memory);
  }
  if (seen == 0 || seen == all) return any != 0;
  int other = 0;
  for (unsigned left = all & ~seen; left != 0; left &= left - 1) {
    const int l = lowest_bit(left);
    const auto serves = [&](int k) { return (seen >> k & 1u) != 0 && of.place[k] == of.place[l]; };
    for (int tries = 0; tries < n; ++tries) {
      other = (other + 1) % n;
      if (!serves(other)) continue;
      put(l, packet.rays.u[other], packet.rays.v[other]);
      break;
    }
  }
  eval_geometry<L>(scene, packet.rays, hits, geometry);
  return true;
}

// Light that surfaces which shine send straight to the beginnings of paths, [band][lane] added to
// `radiance`, as radiance that a white surface sends back.
template <typename L, typename Search>
OMMA_HD void add_shining(const SceneView& scene, Search& search, const GatherLanes<L::count>& of,
                         const HitGeometry<L>& geometry,
                         const float (&normal)[3][L::count],
                         const ScatterPoint<typename L::F>* points, const std::int32_t* valid,
                         const PathMemory& memory, float* radiance) {
  using F = typename L::F;
  constexpr int n = L::count;
  LightSample lights[n];
  Packet<L> shadow;
  clear<L>(shadow.rays);
  alignas(n * 4) std::int32_t asked[n];
  alignas(n * 4) float cosine[n], weight[n];
  unsigned open = 0;
  for (int l = 0; l < n; ++l) {
    lights[l] = {};
    asked[l] = 0;
    cosine[l] = weight[l] = 0;
    for (int r = 0; r < 3; ++r) shadow.rays.origin[r][l] = shadow.rays.direction[r][l] = 0;
    shadow.rays.t_near_m[l] = shadow.rays.t_far_m[l] = shadow.footprint_rad[l] = 0;
    if (valid[l] == 0) continue;
    const GatherPlace& place = *of.place[l];
    const auto which = path_pair(place.hash, of.sample[l], choice_of_shining);
    const auto on = path_pair(place.hash, of.sample[l], choice_on_shining);
    lights[l] = sample_surfaces(scene, vec_at(geometry.position, l), which.x, on.x, on.y);
    const Vec3 d = lights[l].direction;
    cosine[l] = normal[0][l] * d.x + normal[1][l] * d.y + normal[2][l] * d.z;
    float facing = dot(vec_at(geometry.normal, l), d);
    if (place.mesh >= 0 && place.is_back) facing = -facing;
    if (!(lights[l].pdf > 0.0f) || !(cosine[l] > 0.0f) || !(facing > 0.0f)) continue;
    leave_surface<L>(geometry, l, vector_of(d), shadow.rays);
    shadow.rays.t_far_m[l] = lights[l].distance_m * up_to_light;
    weight[l] = cosine[l] * inverse_pi / (lights[l].pdf / scene.light->emissive_probability);
    asked[l] = -1;
    open |= 1u << l;
  }
  const bool lets_through = scene.has_blend || scene.has_glass;
  if (open != 0)
    open = lets_through ? dim_by_passing<L>(scene, search, open, shadow, memory.shadow)
                        : open & ~search.occluded(asked, shadow.rays);
  if (open == 0) return;
  for (int i = 0; i < scene.bands * n; ++i) memory.light[i] = 0;
  for (int l = 0; l < n; ++l)
    if ((open >> l & 1u) != 0)
      eval_light_sample(scene, lights[l], 1, memory.light + l, n, scene.bands * n);
  for (int l = 0; l < n; l += L::width) {
    F entering = load<F>(weight + l);
    if (points != nullptr)
      entering = entering * eval_entering(points[l / L::width], load<F>(cosine + l));
    for (int k = 0; k < L::width; ++k)
      if ((open >> (l + k) & 1u) == 0) weight[l + k] = 0;
    entering = keep(load<F>(weight + l) > 0.0f, entering);
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * n + l;
      F light = load<F>(memory.light + at);
      if (lets_through) light = light * load<F>(memory.shadow.throughput + at);
      store(radiance + at, load<F>(radiance + at) + entering * light);
    }
  }
}

// Mean of what white surfaces there would send back, [place][band].
template <typename L, typename Search>
OMMA_HD void gather_light(const SceneView& scene, Search& search, const GatherTask& task,
                          const PathMemory& memory, float* radiance, double* mean) {
  using F = typename L::F;
  constexpr int n = L::count;
  int points_found[n] = {};
  for (int i = 0; i < task.count * scene.bands; ++i) mean[i] = 0;
  const bool is_on_surface = task.places->mesh >= 0;
  GatherLanes<n> of;
  for (int first = 0; first < task.paths; first += n) {
    assign_lanes(task, first, of);
    Packet<L> packet;
    clear<L>(packet.rays);
    Hits<L> hits;
    HitGeometry<L> geometry;
    LitSurface<L> surface;
    ScatterPoint<F> points[n / L::width];
    alignas(n * 4) float normal[3][n], way[3][n], entering[n];
    for (int l = 0; l < n; ++l) {
      packet.rays.t_far_m[l] = INFINITY;
      packet.footprint_rad[l] = 0;
      packet.hash[l] = of.place[l] != nullptr ? static_cast<std::int32_t>(of.place[l]->hash) : 0;
      packet.sample[l] = static_cast<std::int32_t>(of.sample[l]);
    }
    if (is_on_surface) {
      geometry = {};
      if (!choose_points<L>(scene, search, of, memory, packet, hits, geometry)) continue;
      // Seen by one who looks straight down on it.
      for (int l = 0; l < n; ++l) {
        const bool is_back = of.place[l] != nullptr && of.place[l]->is_back;
        const auto outwards = load_vector<float>(geometry.normal, l);
        store_vector(packet.rays.direction, l, is_back ? outwards : -outwards);
      }
      eval_lit_surfaces<L>(scene, packet, hits, geometry, memory, surface);
    } else {
      geometry = {};
      for (int l = 0; l < n; ++l) {
        hits.mesh[l] = of.place[l] != nullptr ? 0 : -1;
        if (of.place[l] == nullptr) continue;
        const GatherPlace& place = *of.place[l];
        store_vector(geometry.position, l, vector_of(place.position));
        store_vector(geometry.normal, l, vector_of(place.normal));
      }
    }
    for (int l = 0; l < n; l += L::width) {
      if (is_on_surface)
        points[l / L::width] =
            make_scatter_point(scatter_surface<L>(scene, packet.rays, surface, l));
      const Vector3<F> up = is_on_surface ? points[l / L::width].base_normal
                                          : load_vector<F>(geometry.normal, l);
      const auto pair = path_pair(load<typename L::U>(packet.hash + l),
                                  load<typename L::U>(packet.sample + l), choice_of_way);
      const LocalDirection<F> local = sample_cosine(pair.x, pair.y);
      const Vector3<F> w = without_noise(from_local(make_axes(up), up, local));
      store_vector(way, l, w);
      store_vector(normal, l, up);
      F reaches_base = broadcast<F>(1.0f);
      if (is_on_surface) {
        const ScatterPoint<F>& point = points[l / L::width];
        const F side = dot(point.geometric_normal, w);
        reaches_base = keep(side > 0.0f, eval_entering(point, local.z));
      }
      store(entering + l, reaches_base);
    }
    // Places that there are, and those of which a path goes on.
    alignas(n * 4) std::int32_t on[n], valid[n];
    for (int l = 0; l < n; ++l) {
      on[l] = hits.mesh[l] >= 0 ? -1 : 0;
      valid[l] = entering[l] > 0.0f ? on[l] : 0;
      // Rays that are not traced must be such as could be: Embree checks all.
      const bool goes_on = valid[l] != 0;
      leave_surface<L>(geometry, l,
                       goes_on ? load_vector<float>(way, l) : Vector3<float>{0, 1, 0}, packet.rays);
      store_vector(packet.reference, l,
                   goes_on ? load_vector<float>(normal, l) : Vector3<float>{1, 0, 0});
    }
    // What shines is sampled first: the paths move on from where they begin.
    for (int i = 0; i < scene.bands * n; ++i) memory.front[i] = 0;
    if (task.shining->light->emissive_probability > 0.0f)
      add_shining<L>(*task.shining, search, of, geometry, normal,
                     is_on_surface ? points : nullptr, on, memory, memory.front);
    // What shines has been put aside: paths that read baked light need the memory.
    const auto add = [&](int l, const float* light, float weight) {
      const std::ptrdiff_t k = of.place[l] - task.places;
      for (int b = 0; b < scene.bands; ++b)
        mean[k * scene.bands + b] += static_cast<double>(light[b * n + l] * weight);
    };
    for (int l = 0; l < n; ++l) {
      if (on[l] == 0) continue;
      ++points_found[of.place[l] - task.places];
      add(l, memory.front, 1.0f);
    }
    eval_lit_path<L>(scene, search, valid, packet, memory, radiance, true);
    for (int l = 0; l < n; ++l)
      if (valid[l] != 0) add(l, radiance, entering[l]);
  }
  for (int k = 0; k < task.count; ++k)
    for (int b = 0; b < scene.bands; ++b)
      mean[k * scene.bands + b] *= points_found[k] > 0 ? 1.0 / points_found[k] : 0.0;
}

}  // namespace omma
