// A slow and simple second renderer to hold the engine against: every ray against every triangle,
// in double precision, with nothing shared but the scene description. It also says of each ray
// whether float arithmetic may rightly decide it otherwise (`doubtful`).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "omma/eye.h"
#include "omma/render.h"
#include "omma/scene.h"

namespace omma::test {

struct ReferenceTriangle {
  std::array<Vec3d, 3> corner;  // world frame, m
  const Mesh* mesh = nullptr;
  std::size_t index = 0;  // in the mesh
  bool mirrored = false;  // by its instance: the front is then the clockwise side
};

struct Reference {
  const Scene* scene = nullptr;
  Background background;
  std::vector<ReferenceTriangle> triangles;
};

// Keeps a pointer to the scene.
Reference make_reference(const Scene& scene);

struct ReferenceRay {
  Vec3d origin, direction;  // m; unit
  double near_m = 0;        // hits nearer than this do not count
};

// The ray along the axis of an ommatidium.
ReferenceRay axis_ray(const Mat4& world_from_head, const Eye& eye, std::size_t ommatidium);

struct Radiance {
  std::array<double, 3> channel{};
  bool doubtful = false;
};

Radiance reference_radiance(const Reference& reference, const ReferenceRay& ray);

Radiance background_radiance(const Background& background, Vec3d direction);

// S(theta) of a kernel, not normalised, straight from its definition.
double sensitivity(Kernel kernel, double theta_rad, double acceptance_rad);

// The response integral by the midpoint rule with theta_steps x phi_steps cells.
std::array<double, 3> reference_response(const Reference& reference, const Mat4& world_from_head,
                                         const Eye& eye, std::size_t ommatidium, Kernel kernel,
                                         int theta_steps, int phi_steps);

}  // namespace omma::test
