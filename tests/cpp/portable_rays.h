// What tests of the portable search share: rays, what they meet by each build of the search in
// sixteen lanes and in one, and the same found slowly, in double precision, by trying everything.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "backend/portable/portable_tracer.h"
#include "backend/shading_data.h"
#include "packet_search.h"
#include "test_scenes.h"

namespace omma::test {

struct TestRay {
  Vec3 origin, direction;  // m, in the traced frame
  float t_near_m = 0;
  float t_far_m = std::numeric_limits<float>::infinity();
};

struct TestHit {
  float t_m = 0, u = 0, v = 0;
  float normal[3] = {};
  std::uint32_t triangle = none, placed = none;  // `none` where nothing was met

  bool operator==(const TestHit& other) const {
    return std::memcmp(this, &other, sizeof other) == 0;
  }
};

// A scene and what the search needs of it.
struct TracedScene {
  Scene scene;
  std::unique_ptr<ShadingData> shading;
  Placement placement;
  std::unique_ptr<PortableTracer> tracer;

  explicit TracedScene(Scene from)
      : scene(std::move(from)),
        shading(make_shading_data(scene)),
        placement(placement_of(scene)),
        tracer(make_portable_tracer(scene, shading->view, placement)) {}

  // As World does it: what moves for the first time has all built again.
  void move(std::span<const std::int32_t> instances, std::span<const Mat4> to) {
    bool newly = false;
    for (std::size_t k = 0; k < instances.size(); ++k) {
      const auto i = static_cast<std::size_t>(instances[k]);
      newly = newly || !placement.moves[i];
      placement.moves[i] = 1;
      placement.world_from_mesh[i] = to[k];
    }
    if (newly)
      tracer = make_portable_tracer(scene, shading->view, placement);
    else
      move_instances(*tracer, instances, {}, placement);
  }
};

template <int count>
void put_ray(RayPacket<count>& packet, int l, const TestRay& ray) {
  const float origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
  const float direction[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  for (int a = 0; a < 3; ++a) packet.origin[a][l] = origin[a];
  for (int a = 0; a < 3; ++a) packet.direction[a][l] = direction[a];
  packet.t_near_m[l] = ray.t_near_m;
  packet.t_far_m[l] = ray.t_far_m;
  packet.geometry[l] = packet.instance[l] = none;
}

template <int count>
TestHit hit_of(const RayPacket<count>& packet, int l) {
  TestHit hit;
  if (packet.geometry[l] == none) return hit;
  hit.t_m = packet.t_far_m[l];
  hit.u = packet.u[l];
  hit.v = packet.v[l];
  for (int a = 0; a < 3; ++a) hit.normal[a] = packet.normal[a][l];
  hit.triangle = packet.triangle[l];
  hit.placed = packet.geometry[l];
  return hit;
}

// In packets of `count` in the order given; the last one may have idle lanes.
template <int count, typename Trace>
void for_packets(const std::vector<TestRay>& rays, const Trace& trace) {
  for (std::size_t first = 0; first < rays.size(); first += count) {
    RayPacket<count> packet{};
    alignas(64) int valid[count];
    for (int l = 0; l < count; ++l) {
      const bool is_valid = first + static_cast<std::size_t>(l) < rays.size();
      valid[l] = is_valid ? -1 : 0;
      put_ray(packet, l, rays[is_valid ? first + static_cast<std::size_t>(l) : first]);
    }
    trace(packet, valid, static_cast<int>(std::min<std::size_t>(count, rays.size() - first)));
  }
}

inline std::vector<TestHit> hits_in_16(const SearchFunctions& search, const PortableTracer& tracer,
                                       const std::vector<TestRay>& rays) {
  std::vector<TestHit> hits;
  for_packets<16>(rays, [&](RayPacket<16>& packet, const int* valid, int filled) {
    search.closest_16(tracer, valid, &packet, 1);
    for (int l = 0; l < filled; ++l) hits.push_back(hit_of(packet, l));
  });
  return hits;
}

inline std::vector<TestHit> hits_in_1(const SearchFunctions& search, const PortableTracer& tracer,
                                      const std::vector<TestRay>& rays) {
  std::vector<TestHit> hits;
  for_packets<1>(rays, [&](RayPacket<1>& packet, const int* valid, int) {
    search.closest_1(tracer, valid, &packet, 1);
    hits.push_back(hit_of(packet, 0));
  });
  return hits;
}

inline std::vector<bool> occluded_in_16(const SearchFunctions& search, const PortableTracer& tracer,
                                        const std::vector<TestRay>& rays) {
  std::vector<bool> occluded;
  for_packets<16>(rays, [&](const RayPacket<16>& packet, const int* valid, int filled) {
    const unsigned bits = search.occluded_16(tracer, valid, packet);
    for (int l = 0; l < filled; ++l) occluded.push_back((bits >> l & 1u) != 0);
    EXPECT_EQ(filled == 16 ? 0u : bits >> filled, 0u) << "an idle lane is occluded";
  });
  return occluded;
}

inline std::vector<bool> occluded_in_1(const SearchFunctions& search, const PortableTracer& tracer,
                                       const std::vector<TestRay>& rays) {
  std::vector<bool> occluded;
  for_packets<1>(rays, [&](const RayPacket<1>& packet, const int* valid, int) {
    occluded.push_back(search.occluded_1(tracer, valid, packet) != 0);
  });
  return occluded;
}

// Closest hits, which must be the same in sixteen lanes and in one, in every build, and agree with
// what is occluded.
inline std::vector<TestHit> hits_of(const PortableTracer& tracer,
                                    const std::vector<TestRay>& rays) {
  std::vector<TestHit> first;
  for (const SearchFunctions& search : portable_searches()) {
    const std::vector<TestHit> sixteen = hits_in_16(search, tracer, rays);
    const std::vector<TestHit> one = hits_in_1(search, tracer, rays);
    const std::vector<bool> occluded_16 = occluded_in_16(search, tracer, rays);
    const std::vector<bool> occluded_1 = occluded_in_1(search, tracer, rays);
    if (first.empty()) first = sixteen;
    std::size_t lanes_differ = 0, builds_differ = 0, occluded_differ = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      lanes_differ += !(sixteen[i] == one[i]);
      builds_differ += !(sixteen[i] == first[i]);
      const bool hit = sixteen[i].placed != none;
      occluded_differ += occluded_16[i] != hit || occluded_1[i] != hit;
    }
    EXPECT_EQ(lanes_differ, 0u) << "between sixteen lanes and one";
    EXPECT_EQ(builds_differ, 0u) << "between instruction sets";
    EXPECT_EQ(occluded_differ, 0u) << "between closest and occluded";
  }
  return first;
}

// A triangle of the scene as placed, in the traced frame.
struct FlatTriangle {
  Vec3d corner[3];
  std::uint32_t triangle, placed;
  bool is_shared;  // its normal is found in the mesh's frame
};

std::vector<FlatTriangle> flatten(const PortableTracer& tracer);

// Whether what was found is right, up to rounding: in single precision a ray is off by `slack` of
// its distance at most.
//
// What was hit must be hit, when widened by that; nothing that is hit, when narrowed by that, may
// be nearer. Says what is wrong, or nothing.
std::string check_hit(const std::vector<FlatTriangle>& triangles, const TestRay& ray,
                      const TestHit& hit, double slack);

// Checks all hits of `rays` in the ways above; returns how many rays met something.
std::size_t expect_as_brute_force(const PortableTracer& tracer, const std::vector<TestRay>& rays,
                                  double slack = 2e-6);

}  // namespace omma::test
