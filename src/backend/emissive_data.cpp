// Surfaces that shine as lights: what each triangle, or each part of one with a texture, sends, and
// trees over them.
#include "backend/emissive_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "physics/light/emissive.h"
#include "physics/surface/surface.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Of as many values for each of `count`.
std::vector<double> sums_of(const std::vector<double>& values, std::size_t count) {
  const auto each = static_cast<std::ptrdiff_t>(values.size() / count);
  std::vector<double> sums;
  for (auto at = values.begin(); at != values.end(); at += each)
    sums.push_back(std::accumulate(at, at + each, 0.0));
  return sums;
}

// The corners of a triangle in the mesh's own frame.
std::array<Vec3d, 3> corners_of(const MeshView& view, std::size_t triangle) {
  std::array<Vec3d, 3> corner;
  for (std::size_t k = 0; k < 3; ++k) {
    const float* p =
        view.positions + 3 * static_cast<std::size_t>(view.triangles[3 * triangle + k]);
    corner[k] = {p[0], p[1], p[2]};
  }
  return corner;
}

// So many ways the sides of a mesh's triangles are divided: where a texture shines, as one half of
// a panel may be dark, so that there are not many more lights than this.
std::int32_t divisions_for(const SceneView& scene, std::int32_t mesh, std::size_t triangles) {
  constexpr double most = 8, lights = 1 << 12;
  if (scene.materials[scene.meshes[mesh].material].emissive_texture < 0) return 1;
  const double each = lights / static_cast<double>(triangles);
  return static_cast<std::int32_t>(std::clamp(std::floor(std::sqrt(each)), 1.0, most));
}

// Area times emission, summed over bands, of the subtriangles of each triangle in the mesh's own
// frame. A texture is read as wide as a part of one, at its middle. That may miss what is bright,
// so none counts for less than a share of what it is without the texture: a large one where the
// texture is read once, and a small one of those that are read in many places, as rays that go to
// dark ones are lost.
std::vector<double> emitted_powers(const SceneView& scene, std::int32_t mesh, std::size_t triangles,
                                   std::int32_t divisions, const std::array<double, 3>& of_rgb) {
  const MeshView& view = scene.meshes[mesh];
  const std::int32_t parts = divisions * divisions, reads = divisions > 1 ? 8 : 1;
  const Vec3 factor = scene.materials[view.material].emissive;
  const auto total = [&](float r, float g, float b) {
    return of_rgb[0] * static_cast<double>(r) + of_rgb[1] * static_cast<double>(g) +
           of_rgb[2] * static_cast<double>(b);
  };
  const double least = (reads > 1 ? 0.001 : 0.05) * total(factor.x, factor.y, factor.z);
  std::vector<double> powers(triangles * static_cast<std::size_t>(parts));
  parallel_for(std::size_t{0}, powers.size(), [&](std::size_t i) {
    const auto number = static_cast<std::int32_t>(i);
    const std::array<Vec3d, 3> corner = corners_of(view, i / static_cast<std::size_t>(parts));
    const double area = length(cross(corner[1] - corner[0], corner[2] - corner[0])) / 2 / parts;
    const Subtriangle sub = subtriangle(number % parts, divisions);
    double sum = 0, most = 0;
    for (std::int32_t k = 0; k < reads * reads; ++k) {
      const Subtriangle in_sub = subtriangle(k, reads);
      const Color<float> c =
          emitted_rgb(scene, view,
                      SurfacePoint<float, std::int32_t>{
                          number / parts, sub.u + sub.scale * (in_sub.u + in_sub.scale / 3),
                          sub.v + sub.scale * (in_sub.v + in_sub.scale / 3),
                          static_cast<float>(std::sqrt(area) / reads)});
      const double read = total(c.r, c.g, c.b);
      sum += read, most = std::max(most, read);
    }
    powers[i] = area * std::max({sum / (reads * reads), 0.05 * most, least});
  });
  return powers;
}

// Places on a triangle, chosen evenly, vary by a twelfth of its corners' squared distances from its
// middle, summed.
LightTree make_triangle_tree(const MeshView& view, std::int32_t divisions,
                             const std::vector<double>& powers) {
  const auto parts = static_cast<std::size_t>(divisions * divisions);
  std::vector<TreeLight> lights(powers.size());
  parallel_for(std::size_t{0}, powers.size(), [&](std::size_t t) {
    std::array<Vec3d, 3> corner = corners_of(view, t / parts);
    const Subtriangle sub = subtriangle(static_cast<std::int32_t>(t % parts), divisions);
    const Vec3d e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
    if (parts > 1) {
      const double scale = sub.scale;
      corner[0] = corner[0] + e1 * double{sub.u} + e2 * double{sub.v};
      corner[1] = corner[0] + e1 * scale;
      corner[2] = corner[0] + e2 * scale;
    }
    const Vec3d middle = (corner[0] + corner[1] + corner[2]) * (1.0 / 3);
    TreeLight& light = lights[t] = tree_light(middle, powers[t]);
    for (const Vec3d& at : corner) {
      light.box = box_around(light.box, {at, at, false});
      light.variance_m2 += dot(at - middle, at - middle) / 12;
    }
  });
  return make_light_tree(lights);
}

// Meshes that shine, as their instances are placed.
std::vector<TreeLight> placed_emissive(const LightData& data, const float* frame_from_mesh) {
  std::vector<TreeLight> lights;
  for (std::size_t e = 0; e < data.emissive.size(); ++e) {
    const float* from =
        frame_from_mesh + 12 * static_cast<std::ptrdiff_t>(data.emissive[e].instance);
    Mat4 placed;
    double squares = 0;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) {
        placed.m[r][c] = static_cast<double>(from[4 * r + c]);
        if (c < 3) squares += placed.m[r][c] * placed.m[r][c];
      }
    const TreeLight& own = data.triangle_tree.at(data.emissive[e].mesh).all;
    // Areas grow with the mean square of the scales of the axes.
    lights.push_back({placed_box(own.box, placed), transform_point(placed, own.centre_m),
                      own.variance_m2 * squares / 3, data.emissive_weight[e]});
  }
  return lights;
}

}  // namespace

std::vector<double> make_emissive(LightData& data, const Light& light, const Scene& scene,
                                  const Placement& placement, const SceneView& view,
                                  double distance_m) {
  std::vector<double> sent(light.bands.count(), 0.0);
  std::map<std::int32_t, double> power_of_mesh;
  data.emissive_of_instance.assign(scene.instances.size(), -1);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const std::int32_t mesh = scene.instances[i].mesh;
    const std::size_t triangles = scene.meshes[static_cast<std::size_t>(mesh)].triangles.size();
    const std::int32_t material = view.meshes[mesh].material;
    const float* matrix = view.scatter[material].emission;
    if (triangles == 0 || matrix == nullptr) continue;
    const std::int32_t divisions = divisions_for(view, mesh, triangles);
    std::array<double, 3> of_rgb{};
    for (std::size_t k = 0; k < 3 * sent.size(); ++k)
      of_rgb[k % 3] += static_cast<double>(matrix[k]);
    const auto [known, is_new] = power_of_mesh.try_emplace(mesh, 0.0);
    if (is_new) {
      const std::vector<double> powers = emitted_powers(view, mesh, triangles, divisions, of_rgb);
      known->second = std::accumulate(powers.begin(), powers.end(), 0.0);
      if (known->second > 0) {
        data.triangle_tree[mesh] = make_triangle_tree(view.meshes[mesh], divisions, powers);
        data.triangle_powers[mesh] = sums_of(powers, triangles);
      }
    }
    if (!(known->second > 0)) continue;
    data.emissive_of_instance[i] = static_cast<std::int32_t>(data.emissive.size());
    data.emissive.push_back(
        {static_cast<std::int32_t>(i), mesh, divisions, data.triangle_tree[mesh].view()});
    // Areas grow about as the square of the mean scale. A surface of area A and radiance L sends
    // pi A L, or A L / 4 to each direction in the mean.
    const double det = std::fabs(determinant(placement.world_from_mesh[i]));
    const double sides = view.materials[material].double_sided ? 2 : 1;
    const double seen =
        sides * known->second * std::pow(det, 2.0 / 3) / (4 * distance_m * distance_m);
    data.emissive_weight.push_back(seen);
    const Vec3 factor = view.materials[material].emissive;
    const double all = of_rgb[0] * static_cast<double>(factor.x) +
                       of_rgb[1] * static_cast<double>(factor.y) +
                       of_rgb[2] * static_cast<double>(factor.z);
    for (std::size_t b = 0; b < sent.size(); ++b) {
      const float* row = matrix + 3 * b;
      sent[b] += seen *
                 static_cast<double>(row[0] * factor.x + row[1] * factor.y + row[2] * factor.z) /
                 all;
    }
  }
  data.emissive_tree = make_light_tree(placed_emissive(data, view.frame_from_mesh));
  return sent;
}

void place_emissive(LightData& data, const float* frame_from_mesh) {
  if (data.emissive.size() > 1)
    place_lights(data.emissive_tree, placed_emissive(data, frame_from_mesh));
}

}  // namespace omma
