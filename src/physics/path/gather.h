// Light that arrives from all around at a receiver, as it is baked: paths begin at points of a
// patch of a surface, or at a point in the air, in directions by the cosine, and are followed like
// those of an eye; in a scene with baked light, to the first diffuse surface, as in the final
// gathering of a radiosity (Ward, Rubinstein and Clear 1988). What comes straight from discs and
// lamps is left out. A packet holds the paths of one receiver, or of several that have few each.
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/path/lit_path.h"
#include "physics/path/transmittance.h"
#include "physics/views/gather_task.h"

namespace omma {

// Whose path a lane is: the receiver, null for none, and its number among those of the receiver.
template <int n>
struct GatherLanes {
  const Receiver* receiver[n];
  std::uint32_t sample[n];
};

// `first`: the number of the first path in the packet.
template <int n>
OMMA_HD void assign_lanes(const GatherTask& task, int first, GatherLanes<n>& lanes) {
  const int each = task.paths < n ? task.paths : n;
  for (int l = 0; l < n; ++l) {
    const int k = l / each, sample = first + l % each;
    lanes.receiver[l] = k < task.count && sample < task.paths ? task.receivers + k : nullptr;
    lanes.sample[l] = static_cast<std::uint32_t>(sample);
  }
}

// Choices at the beginning of paths; those on the way count up from 0 (Choice).
inline constexpr std::uint32_t choice_of_point = 0xfffffff0u, choice_of_way = 0xfffffff1u,
                               choice_of_shining = 0xfffffff2u, choice_on_shining = 0xfffffff3u,
                               choice_of_look = 0xfffffff4u;

// Points that are cut out of a patch, or hidden, are chosen anew, so often at most.
inline constexpr std::uint32_t most_attempts = 8;

OMMA_HD std::uint32_t hash_of_attempt(const Receiver& receiver, std::uint32_t attempt) {
  return receiver.hash + attempt * 0x9e3779b9u;
}

// Of some lanes those whose points are hidden: a ray from there, in a direction by the cosine,
// meets something within the receiver's reach. By reciprocity, rejection sampling by such rays
// leaves points as frequent as eyes all around see them. What falls on one side of a sheet is seen
// from both.
template <typename L, typename Search>
OMMA_HD LaneMask<L> find_hidden(const Flight<L, Search>& flight, const GatherLanes<L::count>& of,
                                std::uint32_t attempt, LaneMask<L> lanes,
                                const HitGeometry<L>& geometry) {
  constexpr int n = L::count;
  const SceneView& scene = flight.scene;
  Packet<L> look;
  clear<L>(look.rays);
  alignas(n * 4) float way[3][n];
  for (int l = 0; l < n; ++l) {
    look.footprint_rad[l] = 0;
    Vector3<float> towards = {0, 1, 0};
    look.rays.t_far_m[l] = 0;
    if (lanes.has(l)) {
      const Receiver& receiver = *of.receiver[l];
      auto pair = path_pair(hash_of_attempt(receiver, attempt), of.sample[l], choice_of_look);
      bool from_back = receiver.is_back;
      if (scene.scatter[scene.meshes[receiver.mesh].material].transmittance != nullptr) {
        from_back = pair.y < 0.5f;
        pair.y = 2.0f * pair.y - (from_back ? 0.0f : 1.0f);
      }
      const auto normal = load_vector<float>(geometry.normal, l);
      const Vector3<float> up = from_back ? -normal : normal;
      towards = from_local(make_axes(up), up, sample_cosine(pair.x, pair.y));
      look.rays.t_far_m[l] = receiver.reach_m;
    }
    store_vector(way, l, towards);
  }
  leave_surfaces<L>(geometry, way, look.rays);
  if (scene.has_volumes) begin_in<L>(flight.memory.shadow.media, no_medium);
  return lets_through(scene) ? lanes & ~trace_transmittance<L>(scene, flight.search, lanes, look,
                                                               flight.memory.shadow)
                             : search_occluded(flight.search, lanes, look.rays);
}

// The packet's points on their patches, as rays would have met them, and their geometry; false
// where none is on a surface. Lanes whose points are all hidden or cut out begin where others of
// their receiver do; where all of a receiver are hidden the last ones are taken.
template <typename L, typename Search>
OMMA_HD bool choose_points(const Flight<L, Search>& flight, const GatherLanes<L::count>& of,
                           Hits<L>& hits, HitGeometry<L>& geometry) {
  constexpr int n = L::count;
  const SceneView& scene = flight.scene;
  Packet<L>& packet = flight.packet;
  LaneMask<L> all;
  for (int l = 0; l < n; ++l) {
    hits.mesh[l] = -1;
    hits.instance[l] = of.receiver[l] != nullptr ? of.receiver[l]->instance : 0;
    hits.footprint_m[l] = 0;
    if (of.receiver[l] != nullptr) all.add(l);
  }
  const auto put = [&](int l, float u, float v) {
    hits.mesh[l] = of.receiver[l]->mesh;
    packet.rays.triangle[l] = static_cast<unsigned>(of.receiver[l]->triangle);
    packet.rays.u[l] = u;
    packet.rays.v[l] = v;
  };
  LaneMask<L> seen, any;
  for (std::uint32_t attempt = 0; attempt < most_attempts && !(seen == all); ++attempt) {
    LaneMask<L> tried;
    (all & ~seen).for_each([&](int l) {
      const Receiver& receiver = *of.receiver[l];
      const auto pair =
          path_pair(hash_of_attempt(receiver, attempt), of.sample[l], choice_of_point);
      const float root = sqrtf(pair.x), b = root * pair.y, a = root - b;
      const float u = receiver.uv[0][0] + a * (receiver.uv[1][0] - receiver.uv[0][0]) +
                      b * (receiver.uv[2][0] - receiver.uv[0][0]);
      const float v = receiver.uv[0][1] + a * (receiver.uv[1][1] - receiver.uv[0][1]) +
                      b * (receiver.uv[2][1] - receiver.uv[0][1]);
      const SurfaceHit hit{receiver.mesh, static_cast<std::uint32_t>(receiver.triangle), u, v,
                           0.0f};
      const bool has_holes =
          scene.materials[scene.meshes[receiver.mesh].material].alpha_mode == AlphaMode::mask;
      if (has_holes && !accept_hit(scene, hit, false)) return;
      put(l, u, v);
      tried.add(l);
    });
    if (!tried.any()) continue;
    any |= tried;
    eval_geometry<L>(scene, packet.rays, hits, geometry);
    seen |= tried & ~find_hidden(flight, of, attempt, tried, geometry);
  }
  if (!seen.any() || seen == all) return any.any();
  int other = 0;
  (all & ~seen).for_each([&](int l) {
    for (int tries = 0; tries < n; ++tries) {
      other = (other + 1) % n;
      if (!seen.has(other) || of.receiver[other] != of.receiver[l]) continue;
      put(l, packet.rays.u[other], packet.rays.v[other]);
      break;
    }
  });
  eval_geometry<L>(scene, packet.rays, hits, geometry);
  return true;
}

// What rays begin at, of those that gather light: receivers and the normals about which it counts.
// `points` is null in the air.
template <typename L>
struct GatherPoints {
  GatherLanes<L::count> of;
  HitGeometry<L> geometry;
  alignas(L::count * 4) float normal[3][L::count];
  const ScatterPoint<typename L::F>* points;
};

// Next-event estimation from the beginnings of paths, towards surfaces that shine: [band][lane]
// added to the flight's radiance, as radiance that a white surface sends back. The flight's scene
// is the one whose light is sampled.
template <typename L, typename Search>
OMMA_HD void add_shining(const Flight<L, Search>& flight, const GatherPoints<L>& at,
                         LaneMask<L> lanes) {
  using F = typename L::F;
  constexpr int n = L::count;
  const SceneView& scene = flight.scene;
  const PathMemory& memory = flight.memory;
  LightSamples<L> lights = {};
  alignas(n * 4) float cosine[n] = {}, weight[n] = {};
  lanes.for_each([&](int l) {
    const Receiver& receiver = *at.of.receiver[l];
    const auto which = path_pair(receiver.hash, at.of.sample[l], choice_of_shining);
    const auto on = path_pair(receiver.hash, at.of.sample[l], choice_on_shining);
    Vec3 outwards = vec_at(at.geometry.normal, l);
    if (receiver.mesh >= 0 && receiver.is_back) outwards = outwards * -1.0f;
    LightSample& sample = lights.other[l];
    sample_surfaces(scene, *scene.light, {vec_at(at.geometry.position, l), outwards},
                    {which.x, on.x, on.y}, sample);
    cosine[l] = dot(vec_at(at.normal, l), sample.direction);
    if (!(sample.pdf > 0.0f) || !(cosine[l] > 0.0f) || !(dot(outwards, sample.direction) > 0.0f))
      return;
    lights.near.add(l);
    store_vector(lights.direction, l, vector_of(sample.direction));
    lights.distance_m[l] = sample.distance_m;
    weight[l] = cosine[l] * inverse_pi / sample.pdf;
  });
  const LaneMask<L> open = trace_shadow_rays(flight, at.geometry, lights, lights.near);
  if (!open.any()) return;
  for (int i = 0; i < flight.stride(); ++i) memory.light[i] = 0;
  open.for_each([&](int l) {
    eval_light_sample(scene, lights.other[l], 1, memory.light + l, n, flight.stride());
  });
  if (has_air(scene)) dim_by_air<L>(scene, open, lights.distance_m, 1, memory.light);
  const bool dims = lets_through(scene);
  for (int l = 0; l < n; l += L::width) {
    F entering = load<F>(weight + l);
    if (at.points != nullptr)
      entering = entering * eval_entering(at.points[l / L::width], load<F>(cosine + l),
                                          load_vector<F>(lights.direction, l));
    entering = keep(open.at(l), entering);
    for (int b = 0; b < scene.bands; ++b) {
      const int k = b * n + l;
      F light = load<F>(memory.light + k);
      if (dims) light = light * load<F>(memory.shadow.throughput + k);
      store(flight.radiance + k, load<F>(flight.radiance + k) + entering * light);
    }
  }
}

// Mean of what white surfaces there would send back, [receiver][band].
template <typename L, typename Search>
OMMA_HD void gather_light(const SceneView& scene, Search& search, const GatherTask& task,
                          const PathMemory& memory, float* radiance) {
  using F = typename L::F;
  constexpr int n = L::count;
  int points_found[n] = {};
  double* const mean = task.mean;
  for (int i = 0; i < task.count * scene.bands; ++i) mean[i] = 0;
  const bool is_on_surface = task.receivers->mesh >= 0;
  GatherPoints<L> at;
  GatherLanes<n>& of = at.of;
  HitGeometry<L>& geometry = at.geometry;
  for (int first = 0; first < task.paths; first += n) {
    assign_lanes(task, first, of);
    Packet<L> packet;
    clear<L>(packet.rays);
    Hits<L> hits;
    LitSurface<L> surface;
    ScatterPoint<F> points[n / L::width];
    at.points = is_on_surface ? points : nullptr;
    alignas(n * 4) float way[3][n], entering[n];
    PathState<L> state;
    state.gathers = true;
    const Flight<L, Search> flight{
        scene, search, packet, state, memory, radiance, passed_in(scene, memory)};
    for (int l = 0; l < n; ++l) {
      packet.rays.t_far_m[l] = INFINITY;
      packet.footprint_rad[l] = 0;
      packet.hash[l] =
          of.receiver[l] != nullptr ? static_cast<std::int32_t>(of.receiver[l]->hash) : 0;
      packet.sample[l] = static_cast<std::int32_t>(of.sample[l]);
    }
    if (is_on_surface) {
      geometry = {};
      if (!choose_points(flight, of, hits, geometry)) continue;
      // Seen by one who looks straight down on it.
      for (int l = 0; l < n; ++l) {
        const bool is_back = of.receiver[l] != nullptr && of.receiver[l]->is_back;
        const auto outwards = load_vector<float>(geometry.normal, l);
        store_vector(packet.rays.direction, l, is_back ? outwards : -outwards);
      }
      eval_lit_surfaces<L>(scene, packet, hits, geometry, memory, surface);
    } else {
      geometry = {};
      for (int l = 0; l < n; ++l) {
        hits.mesh[l] = of.receiver[l] != nullptr ? 0 : -1;
        if (of.receiver[l] == nullptr) continue;
        const Receiver& receiver = *of.receiver[l];
        store_vector(geometry.position, l, vector_of(receiver.position));
        store_vector(geometry.normal, l, vector_of(receiver.normal));
      }
    }
    for (int l = 0; l < n; l += L::width) {
      if (is_on_surface)
        points[l / L::width] =
            make_scatter_point(scatter_surface<L>(scene, packet.rays, surface, l));
      const Vector3<F> up =
          is_on_surface ? points[l / L::width].base_normal : load_vector<F>(geometry.normal, l);
      const auto pair = path_pair(load<typename L::U>(packet.hash + l),
                                  load<typename L::U>(packet.sample + l), choice_of_way);
      const LocalDirection<F> local = sample_cosine(pair.x, pair.y);
      const Vector3<F> w = without_noise(from_local(make_axes(up), up, local));
      store_vector(way, l, w);
      store_vector(at.normal, l, up);
      F reaches_base = broadcast<F>(1.0f);
      if (is_on_surface) {
        const ScatterPoint<F>& point = points[l / L::width];
        const F side = dot(point.geometric_normal, w);
        reaches_base = keep(side > 0.0f, eval_entering(point, local.z, w));
      }
      store(entering + l, reaches_base);
    }
    // Places that there are, and those of which a path goes on.
    const LaneMask<L> on = lanes_met(hits);
    const LaneMask<L> going =
        on & lanes_where<L>([&](int l) { return load<F>(entering + l) > 0.0f; });
    for (int l = 0; l < n; ++l) {
      // Rays that are not traced must be such as could be: Embree checks all.
      const bool goes_on = going.has(l);
      if (!goes_on) store_vector(way, l, Vector3<float>{0, 1, 0});
      store_vector(packet.reference, l,
                   goes_on ? load_vector<float>(at.normal, l) : Vector3<float>{1, 0, 0});
    }
    leave_surfaces<L>(geometry, way, packet.rays);
    // What shines is sampled first: the paths move on from where they begin.
    for (int i = 0; i < scene.bands * n; ++i) memory.front[i] = 0;
    if (task.shining->light->from_surfaces.all > 0.0f)
      add_shining(
          Flight<L, Search>{*task.shining, search, packet, state, memory, memory.front, nullptr},
          at, on);
    // What shines has been put aside: paths that read baked light need the memory.
    const auto add = [&](int l, const float* light, float weight) {
      const std::ptrdiff_t k = of.receiver[l] - task.receivers;
      for (int b = 0; b < scene.bands; ++b)
        mean[k * scene.bands + b] += static_cast<double>(light[b * n + l] * weight);
    };
    on.for_each([&](int l) {
      ++points_found[of.receiver[l] - task.receivers];
      add(l, memory.front, 1.0f);
    });
    trace_paths(flight, going);
    going.for_each([&](int l) { add(l, radiance, entering[l]); });
  }
  for (int k = 0; k < task.count; ++k)
    for (int b = 0; b < scene.bands; ++b)
      mean[k * scene.bands + b] *= points_found[k] > 0 ? 1.0 / points_found[k] : 0.0;
}

}  // namespace omma
