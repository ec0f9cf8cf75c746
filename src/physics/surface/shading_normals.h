// The normals that light is shaded by: those of the mesh's vertices between them, turned as maps of
// normals say; of what lies below a clear coat, and of the coat.
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/surface/surface.h"
#include "physics/surface/texture.h"

namespace omma {

// Normals go with the cofactors of a transform: across all that lies across them.
template <typename F>
OMMA_HD Vector3<F> transform_normal(const F (&m)[3][4], const Vector3<F>& own) {
  const auto row = [&](int s, int t) {
    return (m[s][1] * m[t][2] - m[s][2] * m[t][1]) * own.x +
           (m[s][2] * m[t][0] - m[s][0] * m[t][2]) * own.y +
           (m[s][0] * m[t][1] - m[s][1] * m[t][0]) * own.z;
  };
  return {row(1, 2), row(2, 0), row(0, 1)};
}

// A map of normals as one mesh reads it.
struct NormalMap {
  TextureRead read;
  float scale;
};

// The normal turned as a normal map says (glTF 2.0, 3.9.3): x along the image's rightwards, y
// along its upwards direction on the surface, which come from the triangle's own coordinates. From
// behind the relief is the same: the whole normal is reversed, and `n` is on the viewer's side.
template <typename F, typename I>
OMMA_HD_CALLED Vector3<F> map_normal(const SceneView& scene, const MeshView& mesh,
                                     const NormalMap& map, const F (&m)[3][4],
                                     const SurfacePoint<F, I>& p, const Vector3<F>& n) {
  Vector3<F> corner[3];
  Pair<F> uv[3];
  for (int k = 0; k < 3; ++k) {
    const I corner_index = p.triangle * 3 + k;
    const I vertex = gather(mesh.triangles, corner_index);
    const I at = mesh.vertex_of_corner != nullptr ? vertex : corner_index;
    uv[k] = gather_pair(map.read.uv, at);
    corner[k] = transform_direction(
        m, Vector3<F>{gather(mesh.positions, vertex * 3), gather(mesh.positions + 1, vertex * 3),
                      gather(mesh.positions + 2, vertex * 3)});
  }
  const F du1 = uv[1].first - uv[0].first, du2 = uv[2].first - uv[0].first;
  const F dv1 = uv[1].second - uv[0].second, dv2 = uv[2].second - uv[0].second;
  const F sign = du1 * dv2 - du2 * dv1 < 0.0f ? broadcast<F>(-1.0f) : broadcast<F>(1.0f);
  const Vector3<F> e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
  Vector3<F> right = (e1 * dv2 - e2 * dv1) * sign;
  const Vector3<F> up = opposite((e2 * du1 - e1 * du2) * sign);
  right = normalize(right - n * dot(right, n));
  const Vector3<F> across = cross(n, right);
  const F hand = dot(across, up) < 0.0f ? broadcast<F>(-1.0f) : broadcast<F>(1.0f);
  const Color<F> c =
      eval_texture_at(scene, mesh, map.read.texture, map.read.uv, map.read.density, p);
  const Vector3<F> column[3] = {
      {m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}};
  const F one = broadcast<F>(1.0f), size = dot(cross(column[0], column[1]), column[2]);
  const F mirrored = size < 0.0f ? -one : one;
  const F side = (dot(cross(e1, e2), n) * mirrored < 0.0f ? -one : one) * map.scale;
  const F x = (c.r * 2.0f - 1.0f) * side;
  const F y = (c.g * 2.0f - 1.0f) * side * hand;
  const F z = c.b * 2.0f - 1.0f;
  const Vector3<F> turned = normalize(right * x + across * y + n * z);
  return select(dot(turned, turned) > 0.5f, turned, n);
}

// The normal of some lanes of one mesh with normals of vertices, whose frame is `m`, on the side of
// the triangle to which `geometric` looks.
template <typename F, typename I>
OMMA_HD Vector3<F> eval_smooth_normal(const MeshView& mesh, const F (&m)[3][4],
                                      const SurfacePoint<F, I>& p, const Vector3<F>& geometric) {
  const F weight[3] = {1.0f - p.u - p.v, p.u, p.v};
  Vector3<F> own = {};
  I vertex[3];
  gather_3(mesh.triangles, p.triangle, vertex);
  for (int k = 0; k < 3; ++k) own = own + gather_vector<F>(mesh.normals, vertex[k]) * weight[k];
  const Vector3<F> turned = normalize(transform_normal(m, own));
  const Vector3<F> towards = select(dot(turned, geometric) < 0.0f, opposite(turned), turned);
  return select(dot(turned, turned) > 0.5f, towards, geometric);
}

// Normals that shade: of what lies below a clear coat, and of the coat, which has the mesh's own
// unless it has a map (KHR_materials_clearcoat).
template <typename F>
struct ShadingNormals {
  Vector3<F> below, coat;
};

template <typename F, typename I>
OMMA_HD ShadingNormals<F> eval_shading_normals(const SceneView& scene, const MeshView& mesh,
                                               const F (&m)[3][4], const SurfacePoint<F, I>& p,
                                               const Vector3<F>& geometric) {
  const ScatterView& scatter = scene.scatter[mesh.material];
  const Vector3<F> smooth =
      mesh.normals != nullptr ? eval_smooth_normal(mesh, m, p, geometric) : geometric;
  ShadingNormals<F> normals{smooth, smooth};
  if (mesh.normal_uv != nullptr)
    normals.below = map_normal(
        scene, mesh,
        {{scatter.normal_texture, mesh.normal_uv, mesh.normal_density}, scatter.normal_scale}, m, p,
        smooth);
  if (mesh.factors != nullptr && mesh.factors->coat_normal.texture >= 0)
    normals.coat = map_normal(scene, mesh, {mesh.factors->coat_normal, scatter.coat_normal_scale},
                              m, p, smooth);
  return normals;
}

}  // namespace omma
