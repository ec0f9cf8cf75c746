// Compiles the physics headers as device code. Nothing runs this; it keeps what is written once
// good for both host and device.
#include "physics/acceptance.h"
#include "physics/footprint.h"
#include "physics/hash.h"
#include "physics/path.h"
#include "physics/random_direction.h"
#include "physics/sobol.h"
#include "physics/traverse.h"

namespace omma {

__global__ void device_check(SceneView scene, AcceptanceWarpView warp, PolarTablesView tables,
                             float* out) {
  const unsigned i = threadIdx.x;
  const std::uint64_t scramble = hash_combine(pose_hash(0, blockIdx.x), i);
  const double u0 =
      unit_interval(static_cast<std::uint64_t>(owen_scramble(sobol_0(i), scramble)) << 32);
  const double u1 =
      unit_interval(static_cast<std::uint64_t>(owen_scramble(sobol_1(i), scramble)) << 32);
  const Vec3 direction =
      to_float(sample_acceptance(warp, normal_quantile(u0), normal_quantile(u1)));
  const auto trace = [&](float t_near_m, SurfaceHit& hit, float& t_m) {
    hit = {0, i, 0.25f, 0.25f};
    t_m = t_near_m + 1;
    return accept_hit(scene, hit, direction.z > 0) && may_reject(scene.materials[0]);
  };
  const double width_rad = warp.sensitivity.width_rad;
  const double widest_rad = widest_footprint(warp.sensitivity.kernel, 1) * width_rad;
  const Radiance radiance =
      eval_path(scene, direction,
                static_cast<float>(footprint_width_rad(widest_rad, width_rad, 16)), 0, trace);
  for (int c = 0; c < channel_count; ++c) out[channel_count * i + c] = radiance.channel[c];
  const LocalDirection<float> random = sample_random_direction<float>(
      tables, static_cast<int>(i), scramble_hash(ommatidium_hash(scramble, i), 0u), i);
  out[channel_count * blockDim.x + i] =
      random.x + random.y + random.z +
      static_cast<float>(acceptance_pdf(warp, direction.z, direction.x) +
                         eval_polar_density(warp.sensitivity, direction.z, direction.x));
}

// The search, one ray a thread.
__global__ void device_check_search(SceneView scene, BvhView bvh, const PlacedMesh* placed,
                                    RayPacket<1>* rays, unsigned* hidden) {
  const unsigned i = threadIdx.x;
  const auto accept = [&](int, float, float u, float v, std::uint32_t triangle, std::uint32_t index,
                          bool from_behind) {
    return accept_hit(scene, {placed[index].mesh, triangle, u, v, 0}, from_behind);
  };
  const int valid = -1;
  hidden[i] = occluded(bvh, &valid, rays[i], accept);
  closest(bvh, &valid, rays[i], accept);
}

}  // namespace omma
