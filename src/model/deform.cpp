// Blending and linear blend skinning (glTF 2.0, sections 3.7.2.2 and 3.7.3).
#include "model/deform.h"

#include <algorithm>
#include <cmath>

#include "threads/parallel.h"

namespace omma {
namespace {

constexpr std::size_t vertices_per_task = 2048;  // some tenth of a millisecond

// The first three rows of a transform.
struct Bone {
  float m[3][4];
};

std::vector<Bone> bones_of(const Rig& rig, const Deformation& deformation, const RigPose& pose) {
  std::vector<Bone> bones;
  const Skin& skin = rig.skins[static_cast<std::size_t>(deformation.skin)];
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    const Mat4 t = deformation.mesh_from_world *
                   pose.world_from_node[static_cast<std::size_t>(skin.joints[j])] *
                   skin.joint_from_mesh[j];
    Bone& bone = bones.emplace_back();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) bone.m[r][c] = static_cast<float>(t.m[r][c]);
  }
  return bones;
}

// Normalised; as it was where it has no direction.
Vec3 unit_or(Vec3 n, Vec3 otherwise) {
  const float squares = dot(n, n);
  if (squares > 1e-20f && squares < 1e20f) return n * (1 / std::sqrt(squares));
  const float largest = std::max({std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)});
  if (!(largest > 0) || !std::isfinite(largest)) return otherwise;
  n = n * (1 / largest);
  return n * (1 / std::sqrt(dot(n, n)));
}

Vec3 bent(const Bone& bone, Vec3 p) {
  const auto row = [&](int r) {
    return bone.m[r][0] * p.x + bone.m[r][1] * p.y + bone.m[r][2] * p.z + bone.m[r][3];
  };
  return {row(0), row(1), row(2)};
}

// By the matrix of cofactors, so that it stays across the surface however that is stretched, and on
// the side from which corners are seen counter-clockwise.
Vec3 bent_normal(const Bone& bone, Vec3 n) {
  const auto cofactor = [&](int r, int c) {
    const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return bone.m[r1][c1] * bone.m[r2][c2] - bone.m[r1][c2] * bone.m[r2][c1];
  };
  const auto row = [&](int r) {
    return cofactor(r, 0) * n.x + cofactor(r, 1) * n.y + cofactor(r, 2) * n.z;
  };
  return {row(0), row(1), row(2)};
}

void blend(const Deformation& deformation, const std::vector<double>& weights, Shape& shape) {
  for (std::size_t t = 0; t < deformation.targets.size() && t < weights.size(); ++t) {
    const auto weight = static_cast<float>(weights[t]);
    if (weight == 0) continue;
    const MorphTarget& target = deformation.targets[t];
    const auto add = [&](std::vector<Vec3>& to, const std::vector<Vec3>& difference) {
      parallel_ranges(std::size_t{0}, difference.size(), vertices_per_task,
                      [&](std::size_t begin, std::size_t end) {
                        for (std::size_t i = begin; i < end; ++i)
                          to[i] = to[i] + difference[i] * weight;
                      });
    };
    add(shape.positions, target.positions);
    if (!shape.normals.empty()) add(shape.normals, target.normals);
  }
  for (std::size_t i = 0; i < shape.normals.size(); ++i)
    shape.normals[i] = unit_or(shape.normals[i], deformation.normals[i]);
}

void bend(const Deformation& deformation, const std::vector<Bone>& bones, Shape& shape) {
  const auto influences = static_cast<std::size_t>(deformation.influences);
  parallel_ranges(std::size_t{0}, shape.positions.size(), vertices_per_task,
                  [&](std::size_t begin, std::size_t end) {
                    for (std::size_t i = begin; i < end; ++i) {
                      Bone sum{};
                      for (std::size_t k = i * influences; k < (i + 1) * influences; ++k) {
                        const float weight = deformation.weights[k];
                        if (weight == 0) continue;
                        const Bone& bone = bones[deformation.joints[k]];
                        for (int r = 0; r < 3; ++r)
                          for (int c = 0; c < 4; ++c) sum.m[r][c] += weight * bone.m[r][c];
                      }
                      shape.positions[i] = bent(sum, shape.positions[i]);
                      if (shape.normals.empty()) continue;
                      Vec3& normal = shape.normals[i];
                      normal = unit_or(bent_normal(sum, normal), normal);
                    }
                  });
}

}  // namespace

Shape eval_shape(const Rig& rig, const Deformation& deformation, const RigPose& pose) {
  Shape shape;
  shape.positions = deformation.positions;
  shape.normals = deformation.normals;
  if (!deformation.targets.empty())
    blend(deformation, pose.weights[static_cast<std::size_t>(deformation.node)], shape);
  if (deformation.skin >= 0) bend(deformation, bones_of(rig, deformation, pose), shape);
  return shape;
}

std::vector<Vec3> normals_of(const std::vector<Vec3>& positions,
                             const std::vector<std::array<std::uint32_t, 3>>& triangles,
                             const std::vector<Vec3>& otherwise) {
  std::vector<Vec3> normals(positions.size(), Vec3{0, 0, 0});
  for (const auto& triangle : triangles) {
    const Vec3 a = positions[triangle[0]], b = positions[triangle[1]] - a,
               c = positions[triangle[2]] - a;
    const Vec3 across{b.y * c.z - b.z * c.y, b.z * c.x - b.x * c.z, b.x * c.y - b.y * c.x};
    for (const std::uint32_t vertex : triangle) normals[vertex] = normals[vertex] + across;
  }
  for (std::size_t i = 0; i < normals.size(); ++i)
    normals[i] = unit_or(normals[i], otherwise[i]);
  return normals;
}

}  // namespace omma
