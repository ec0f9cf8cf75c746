// Compiles the physics as device code: the hot loop in one lane, with the search of our own
// hierarchy. Nothing runs this; it keeps what is written once good for both host and device.
#include "physics/block/block.h"
#include "physics/block/weigh.h"
#include "physics/light/light_sample.h"
#include "physics/light/sun_map.h"
#include "physics/search/traverse.h"
#include "physics/surface/footprint.h"
#include "physics/surface/scatter.h"

namespace omma {
namespace {

using OneLane = Lanes<1, 1>;

struct Search {
  const SceneView* scene;
  const BvhView* bvh;
  const PlacedMesh* placed_meshes;

  OMMA_HD bool accepts(std::uint32_t placed, std::uint32_t triangle, float u, float v,
                       bool from_behind) const {
    return accept_hit(*scene, {placed_meshes[placed].mesh, triangle, u, v}, from_behind);
  }
  OMMA_HD void closest(LaneMask<OneLane> lanes, RayPacket<1>& rays, const PassedSurfaces<1>* passed,
                       Spread = Spread::together) const {
    const auto accept = [&](int lane, float t_m, float u, float v, std::uint32_t triangle,
                            std::uint32_t placed, bool from_behind) {
      if (!accepts(placed, triangle, u, v, from_behind)) return false;
      const auto corners = [](unsigned, unsigned, unsigned) { return Triangle{}; };
      return passed == nullptr ||
             !has_passed(*passed, lane, {none, placed, triangle, t_m, u, v}, {}, corners);
    };
    omma::closest<OneLane>(*bvh, lanes, rays, accept);
  }
  OMMA_HD LaneMask<OneLane> occluded(LaneMask<OneLane> lanes, const RayPacket<1>& rays) const {
    return omma::occluded<OneLane>(
        *bvh, lanes, rays,
        [&](int, float, float u, float v, std::uint32_t triangle, std::uint32_t placed,
            bool from_behind) { return accepts(placed, triangle, u, v, from_behind); });
  }
  OMMA_HD const PlacedMesh* placed() const { return placed_meshes; }
};

}  // namespace

__global__ void device_check(FrameView frame, BlockTask task, BvhView bvh, const PlacedMesh* placed,
                             std::byte* memory) {
  Search search{frame.scene, &bvh, placed};
  Scratch scratch{memory};
  render_block<OneLane>(frame, task, search, lay_out(scratch, frame, 1));
}

__global__ void device_check_weights(SharedWeights shared, const float* radiance,
                                     float* responses) {
  weigh_rays<Lanes<weight_group, 1>>(shared, radiance, 3, 0, 1, responses);
}

__global__ void device_check_acceptance(AcceptanceWarpView warp, double* out) {
  const SensitivityView& s = warp.sensitivity;
  out[0] = acceptance_pdf(warp, 0.1, 0.2) + eval_polar_density(s, 0.1, 0.2) +
           footprint_width_rad(widest_footprint(s.kernel, 1) * s.width_rad, s.width_rad, 16);
}

// A direction in which a surface scatters, and what comes from there.
__global__ void device_check_scatter(const ScatterSurface<float>* surfaces, Vec2 u,
                                     Mueller3<float>* paths) {
  const ScatterPoint<float> point = make_scatter_point(surfaces[threadIdx.x]);
  float weight[lobe_count];
  lobe_weights(point, {0.5f, 0.5f, 0.5f, 0.5f}, weight);
  const LobeChoice<float> choice = choose_lobe(weight, u.x);
  const Vector3<float> w = sample_scatter(choice.lobe, point, u.x, u.y);
  const ScatterValue<float> value = eval_scatter(point, w);
  const Vector3<float> s = reflection_axis(point.direction, w, point.tangent);
  paths[threadIdx.x] = paths[threadIdx.x] * frame_turn(point.tangent, point.bitangent, s) *
                       (value.dielectric * (1.0f / pdf_scatter(choice.lobe, value)));
}

// A ray that leaves what another met, and what is in its way.
__global__ void device_check_leaving(SceneView scene, BvhView bvh, const PlacedMesh* placed,
                                     Packet<OneLane>* packets, unsigned* occluded_rays) {
  Packet<OneLane>& packet = packets[threadIdx.x];
  const auto all = LaneMask<OneLane>::all();
  const Search search{&scene, &bvh, placed};
  search.closest(all, packet.rays, nullptr);
  Hits<OneLane> hits;
  find_hits<OneLane>(placed, packet, hits);
  HitGeometry<OneLane> geometry;
  eval_geometry<OneLane>(scene, packet.rays, hits, geometry);
  const auto normal = load_vector<float>(geometry.normal, 0);
  leave_surface<OneLane>(geometry, 0, normal, packet.rays);
  packet.rays.t_far_m[0] = INFINITY;
  occluded_rays[threadIdx.x] = search.occluded(all, packet.rays).bits;
}

// How much of the sun is seen from where a ray met something.
__global__ void device_check_sun_map(SunMapView map, const HitGeometry<OneLane>* hits,
                                     float* visible) {
  float seen[1];
  eval_sun_map(map, hits[threadIdx.x], seen);
  visible[threadIdx.x] = seen[0];
}

// Towards something that shines, and what comes from there.
__global__ void device_check_light(SceneView scene, Vec3 position, float* out) {
  const LightSample sample = sample_light(scene, position, 0.1f, 0.2f, 0.3f);
  eval_light_sample(scene, sample, 3, out, 1, scene.bands);
  out[0] += escaped_light_pdf(scene, sample.direction, sample.place) +
            met_light_pdf(scene, sample.index, sample.triangle, position, sample.direction,
                          sample.distance_m);
}

}  // namespace omma
