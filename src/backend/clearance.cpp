// Clearances by a packet of rays from each triangle.
#include "backend/clearance.h"

#include <algorithm>
#include <cmath>

#include "physics/rays/hits.h"
#include "physics/sampling/hash.h"
#include "physics/sampling/path_points.h"
#include "physics/surface/scatter.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Instances of a mesh that clearances are measured at.
constexpr std::size_t most_looked_at = 3;
constexpr std::size_t triangles_of_launch = 1024;
constexpr std::uint32_t hash_of_clearances = 0x726f6f6du;

using L = Lanes<packet_rays, 1>;

// A packet of rays from a triangle, half of them from each side; from one without area they have no
// bit in their masks, and nothing that they meet counts.
void set_rays(const Vec3 (&corner)[3], std::uint32_t hash, RayPacket<packet_rays>& rays) {
  const Vec3 e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
  const Vec3d area = cross(to_double(e1), to_double(e2));
  const bool has_area = dot(area, area) > 0;
  const Vec3 normal = has_area ? to_float(normalize(area)) : Vec3{0, 1, 0};
  clear<L>(rays);
  HitGeometry<L> geometry{};
  float towards[3][packet_rays];
  float reach = 0;
  for (const Vec3& c : corner)
    reach = std::max({reach, std::abs(c.x), std::abs(c.y), std::abs(c.z)});
  for (int l = 0; l < packet_rays; ++l) {
    const auto sample = static_cast<std::uint32_t>(l);
    const auto place = path_pair(hash, sample, 0u), way = path_pair(hash, sample, 1u);
    const float root = std::sqrt(place.x), u = root - root * place.y, v = root * place.y;
    const Vec3 at = corner[0] + e1 * u + e2 * v;
    const Vec3 up = l % 2 == 0 ? normal : normal * -1.0f;
    const Vector3<float> away = vector_of(up);
    store_vector(towards, l, from_local(make_axes(away), away, sample_cosine(way.x, way.y)));
    store_vector(geometry.position, l, vector_of(at));
    store_vector(geometry.normal, l, away);
    geometry.reach_m[l] = reach;
    rays.t_far_m[l] = INFINITY;
    rays.mask[l] = has_area ? all_seen : 0;
  }
  leave_surfaces<L>(geometry, towards, rays);
}

// Sum over a packet's rays.
double inverse_distances(const RayPacket<packet_rays>& rays) {
  if (rays.mask[0] == 0) return 0;
  double sum = 0;
  for (int l = 0; l < packet_rays; ++l)
    if (rays.geometry[l] != none) sum += 1.0 / std::max(1e-30, double{rays.t_far_m[l]});
  return sum;
}

}  // namespace

std::vector<std::vector<float>> clearances_m(const Tracing& tracing, const Scene& scene,
                                             const Placement& placement) {
  std::vector<std::vector<std::size_t>> instances(scene.meshes.size());
  const std::vector<bool> is_in_reach = instances_in_reach(scene, placement);
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    if (is_in_reach[i]) instances[static_cast<std::size_t>(scene.instances[i].mesh)].push_back(i);
  std::vector<std::vector<float>> clearance(scene.meshes.size());
  std::vector<RayPacket<packet_rays>> packets;  // [triangle of a launch][look]
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    const std::vector<std::size_t>& of_mesh = instances[m];
    if (of_mesh.empty()) continue;
    const std::size_t looks = std::min(most_looked_at, of_mesh.size());
    clearance[m].resize(mesh.triangles.size());
    for (std::size_t first = 0; first < mesh.triangles.size(); first += triangles_of_launch) {
      const std::size_t last = std::min(mesh.triangles.size(), first + triangles_of_launch);
      packets.resize((last - first) * looks);
      parallel_ranges<std::size_t>(0, packets.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
          const std::size_t t = first + p / looks, i = of_mesh[p % looks * of_mesh.size() / looks];
          Vec3 corner[3];
          for (std::size_t c = 0; c < 3; ++c)
            corner[c] = to_float(transform_point(placement.world_from_mesh[i],
                                                 to_double(mesh.positions[mesh.triangles[t][c]])) -
                                 placement.origin_m);
          const std::uint32_t hash =
              mix_bits_32(mix_bits_32(static_cast<std::uint32_t>(t) + hash_of_clearances) +
                          static_cast<std::uint32_t>(i));
          set_rays(corner, hash, packets[p]);
        }
      });
      tracing.closest(packets, tracing.tracer);
      for (std::size_t t = first; t < last; ++t) {
        double sum = 0;
        for (std::size_t k = 0; k < looks; ++k)
          sum += inverse_distances(packets[(t - first) * looks + k]);
        clearance[m][t] = static_cast<float>(static_cast<double>(looks * packet_rays) / sum);
      }
    }
  }
  return clearance;
}

}  // namespace omma
