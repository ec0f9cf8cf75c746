// Our own search beside Embree's, on the same packets and one thread, in turns so that a
// disturbance meets both: rtcIntersect16, coherent, and `closest` of physics/search/traverse.h.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <string>

#include "backend/denormals.h"
#include "backend/embree/embree_backend.h"
#include "backend/embree/embree_tracer.h"
#include "backend/eye_arrays.h"
#include "backend/shading_data.h"
#include "packet_search.h"
#include "physics/rays/replicates.h"
#include "scenes.h"

namespace omma::bench {
namespace {

// Packets of 16 as a render makes them, of a part of the eye.
std::vector<RayPacket<16>> packets_of(const Setup& setup, int samples, const ShadingData& shading,
                                      const Placement& placement) {
  const DirectionTables directions = make_direction_tables(setup.eye, {}, samples);
  const EyeArrays eye = make_eye_arrays(setup.eye, directions);
  const DirectionsView directions_view = view(directions);
  const EyeView eye_view = view(eye);
  const FrameView frame{&shading.view, &eye_view, &directions_view};
  std::vector<RayPacket<16>> packets;
  const int per_block = std::clamp(block_rays / samples, 1, block_capacity);
  const int ommatidia = static_cast<int>(setup.eye.size());
  for (int first = 0; first < ommatidia; first += per_block) {
    BlockTask task;
    const double origin[3] = {placement.origin_m.x, placement.origin_m.y, placement.origin_m.z};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c)
        task.world_from_head[r][c] =
            static_cast<float>(setup.poses.front().m[r][c] - (c == 3 ? origin[r] : 0));
    task.first = first;
    task.count = std::min(per_block, ommatidia - first);
    const std::size_t before = packets.size();
    packets.resize(before + static_cast<std::size_t>((task.count * samples + 15) / 16));
    embree_block_functions().prepare(frame, task, packets.data() + before);
  }
  return packets;
}

// The same rays where they have been scattered: each starts where one of them met something, and
// goes on in any direction.
void scatter(const EmbreeTracer& tracer, std::vector<RayPacket<16>>& packets) {
  std::mt19937 random(1);
  std::normal_distribution<float> component;  // three of these are a direction that is even
  for (RayPacket<16>& packet : packets) {
    embree_block_functions().closest(&tracer, 0xffff, packet);
    for (int l = 0; l < 16; ++l) {
      const bool met = packet.geometry[l] != none;
      float to[3] = {component(random), component(random), component(random)};
      const float length = std::hypot(to[0], to[1], to[2]);
      for (int a = 0; a < 3; ++a) {
        if (met) packet.origin[a][l] += 0.999f * packet.t_far_m[l] * packet.direction[a][l];
        packet.direction[a][l] = to[a] / length;
      }
      packet.t_near_m[l] = 0;
      packet.t_far_m[l] = std::numeric_limits<float>::infinity();
      packet.geometry[l] = packet.instance[l] = none;
    }
  }
}

constexpr int scattered = 0;  // in place of a number of samples

constexpr std::size_t together = 32;  // packets that are in the cache, as in a render

// Of each part of the packets, the shortest time that tracing it took.
struct BestTimes {
  std::vector<double> part_s;

  // Takes the times of `trace(packets, count)` on copies of all.
  template <typename Packet, typename Trace>
  void take(const std::vector<Packet>& made, std::vector<Packet>& traced, const Trace& trace) {
    const DenormalsAreZero denormals_are_zero;
    part_s.resize((made.size() + together - 1) / together, 1e9);
    for (std::size_t k = 0; k < part_s.size(); ++k) {
      const std::size_t first = k * together, count = std::min(together, made.size() - first);
      std::copy_n(made.data() + first, count, traced.data() + first);
      const auto start = Clock::now();
      trace(traced.data() + first, count);
      part_s[k] = std::min(part_s[k], seconds_since(start));
    }
  }
  double sum() const { return std::accumulate(part_s.begin(), part_s.end(), 0.0); }
};

RayPacket<1> ray_of(const RayPacket<16>& packet, int l) {
  RayPacket<1> ray;
  for (int a = 0; a < 3; ++a) {
    ray.origin[a][0] = packet.origin[a][l];
    ray.direction[a][0] = packet.direction[a][l];
  }
  ray.t_near_m[0] = packet.t_near_m[l];
  ray.t_far_m[0] = packet.t_far_m[l];
  ray.geometry[0] = ray.instance[0] = none;
  return ray;
}

// Of rays, how many meet something in one search alone, and how many meet it elsewhere.
struct Differences {
  std::size_t in_one = 0, elsewhere = 0;
};

Differences compare(const std::vector<RayPacket<16>>& ours,
                    const std::vector<RayPacket<16>>& theirs) {
  Differences d;
  for (std::size_t p = 0; p < ours.size(); ++p)
    for (int l = 0; l < 16; ++l) {
      const float a = ours[p].t_far_m[l], b = theirs[p].t_far_m[l];
      const bool hit = ours[p].geometry[l] != none;
      if (hit != (theirs[p].geometry[l] != none))
        ++d.in_one;
      else if (hit && std::fabs(a - b) > 1e-4f * b)
        ++d.elsewhere;
    }
  return d;
}

}  // namespace

void search(bool quick) {
  const double least_s = quick ? 0.05 : 2;
  std::vector<Setup> setups;
  if (have_data("searching in natural-standin-sky")) setups.push_back(meadow());
  setups.push_back(bundled());
  setups.push_back(hills(quick ? 100 : 708));
  std::printf(
      "scene,samples,rays,embree_mrays_per_s,portable_mrays_per_s,one_lane_mrays_per_s,"
      "hit_in_one,hit_elsewhere,build_s\n");
  for (const Setup& setup : setups) {
    const auto shading = make_shading_data(*setup.scene);
    const Placement placement = placement_of(*setup.scene);
    const auto embree = make_embree_tracer(*setup.scene, shading->view, placement);
    const auto before = Clock::now();
    const auto portable = make_portable_tracer(*setup.scene, shading->view, placement);
    const double build_s = seconds_since(before);
    const SearchFunctions search = portable_searches().back();
    alignas(64) int valid[16];
    for (int& v : valid) v = -1;
    for (const int samples : {1, 16, 256, scattered}) {
      std::vector<RayPacket<16>> made =
          packets_of(setup, samples == scattered ? 16 : samples, *shading, placement);
      if (samples == scattered) scatter(*embree, made);
      std::vector<RayPacket<1>> singles;
      for (std::size_t p = 0; p < made.size(); ++p)
        for (int l = 0; l < 16; ++l) singles.push_back(ray_of(made[p], l));
      std::vector<RayPacket<16>> theirs(made), ours(made);
      std::vector<RayPacket<1>> single_hits(singles);
      BestTimes embree_times, portable_times, single_times;
      const auto start = Clock::now();
      for (int i = 0; i < 3 || seconds_since(start) < least_s; ++i) {
        embree_times.take(made, theirs, [&](RayPacket<16>* packets, std::size_t count) {
          IntersectArguments arguments;
          for (std::size_t p = 0; p < count; ++p)
            intersect_16(embree->scene, valid, reinterpret_cast<RTCRayHit16&>(packets[p]),
                         arguments);
        });
        portable_times.take(made, ours, [&](RayPacket<16>* packets, std::size_t count) {
          search.closest_16(*portable, valid, packets, count);
        });
        if (i < 3)
          single_times.take(singles, single_hits, [&](RayPacket<1>* rays, std::size_t count) {
            search.closest_1(*portable, valid, rays, count);
          });
      }
      const Differences d = compare(ours, theirs);
      const double mrays = 16e-6 * static_cast<double>(made.size());
      const std::string which = samples == scattered ? "scattered" : std::to_string(samples);
      std::printf("%s,%s,%.0f,%.2f,%.2f,%.2f,%zu,%zu,%.3f\n", setup.name.c_str(), which.c_str(),
                  1e6 * mrays, mrays / embree_times.sum(), mrays / portable_times.sum(),
                  mrays / single_times.sum(), d.in_one, d.elsewhere, build_s);
      std::fflush(stdout);
    }
  }
}

}  // namespace omma::bench
