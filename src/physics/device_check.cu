// Compiles the physics as device code: the hot loop in one lane, with a search that meets a triangle
// everywhere. Nothing runs this; it keeps what is written once good for both host and device.
#include "physics/block.h"
#include "physics/footprint.h"
#include "physics/weigh.h"

namespace omma {
namespace {

struct OneTriangle {
  const SceneView* scene;
  PlacedMesh mesh{0, 1};

  OMMA_HD void closest(const std::int32_t* valid, RayPacket<1>& rays,
                       const PassedSurfaces<1>* passed) {
    if (valid[0] == 0) return;
    const SurfaceHit hit{0, 0, 0.25f, 0.25f};
    if (!may_reject(scene->materials[0]) || accept_hit(*scene, hit, rays.direction[2][0] > 0))
      rays.geometry[0] = 0;
    const auto corners = [](unsigned, unsigned, unsigned) { return Triangle{}; };
    if (passed != nullptr && has_passed(*passed, 0, {none, 0, 0, 1, 0.25f, 0.25f}, {}, corners))
      rays.geometry[0] = none;
    rays.t_far_m[0] = rays.t_near_m[0] + 1;
  }
  OMMA_HD const PlacedMesh* placed() const {
    return &mesh;
  }
};

}  // namespace

using OneLane = Lanes<1, 1>;

__global__ void device_check(FrameView frame, BlockTask task, std::byte* memory) {
  OneTriangle search{frame.scene};
  Room room{memory};
  render_block<OneLane>(frame, task, search, lay_out(room, frame.scene->bands, frame, 1));
}

__global__ void device_check_weights(SharedWeights shared, const float* radiance, float* responses) {
  weigh_rays<Lanes<weight_group, 1>>(shared, radiance, 3, 0, 1, responses);
}

__global__ void device_check_acceptance(AcceptanceWarpView warp, double* out) {
  const SensitivityView& s = warp.sensitivity;
  out[0] = acceptance_pdf(warp, 0.1, 0.2) + eval_polar_density(s, 0.1, 0.2) +
           footprint_width_rad(widest_footprint(s.kernel, 1) * s.width_rad, s.width_rad, 16);
}

}  // namespace omma
