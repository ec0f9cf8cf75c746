// Rays on their way and what they met, in memory by lane: a packet of many on a processor, one on a
// graphics card and in tests. The order of the arrays for sixteen lanes is that of Embree's
// RTCRayHit16, so that Embree traces them where they are.
#pragma once

#include <cstdint>

namespace omma {

// Rays of a processor's packets.
inline constexpr int packet_rays = 16;

// How the rays of a packet lie to each other, for searches that do better where they know.
enum class Spread : std::uint8_t { together, scattered };

// No surface, no instance.
inline constexpr std::uint32_t none = 0xffffffffu;

// Of rays that meet all there is, and of surfaces that all rays meet.
inline constexpr std::uint32_t all_seen = 0xffffffffu;

template <int count>
struct alignas(count >= 16 ? 64 : 4) RayPacket {
  float origin[3][count];     // m, traced frame
  float t_near_m[count];      // hits nearer than this are not seen
  float direction[3][count];  // unit
  float time[count];
  float t_far_m[count];  // hits further away are not seen; where a hit is found, its distance
  std::uint32_t mask[count];  // surfaces that have none of these bits are not met (PlacedMesh)
  std::uint32_t id[count], flags[count];  // Embree's: the lane, 0

  float normal[3][count];         // of the triangle, not normalised, in the frame of its mesh
  float u[count], v[count];       // barycentric weights of the second and third vertex
  std::uint32_t triangle[count];  // index in its mesh
  // Which placed surface: where `instance` is not `none` that, else `geometry` is an index into the
  // table of placed meshes that the backend keeps; `geometry` is `none` where nothing was met.
  std::uint32_t geometry[count];
  std::uint32_t instance[count];
  std::uint32_t spare[count];  // newer versions of Embree write one more number
};

// A placed surface: which mesh; metres of the mesh per metre of the world along the direction that
// its transform stretches most; which instance of the scene; and which rays meet it, those that have
// a bit of this in their mask.
struct alignas(16) PlacedMesh {
  std::int32_t mesh = -1;
  float mesh_per_world = 0;
  std::int32_t instance = -1;
  std::uint32_t seen_by = all_seen;
};

}  // namespace omma
