// Surfaces that shine as lights: what each triangle, or each part of one with a texture, sends, and
// trees over them.
#include "backend/emissive_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <utility>

#include "model/transform.h"
#include "omma/rig.h"
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

double area_of(const std::array<Vec3d, 3>& corner) {
  return length(cross(corner[1] - corner[0], corner[2] - corner[0])) / 2;
}

std::array<double, 2> middle_of(const Subtriangle& sub) {
  return {double{sub.u} + double{sub.scale} / 3, double{sub.v} + double{sub.scale} / 3};
}

// Emission, summed over bands, all over the triangles of a mesh: at the middles of `side`^2
// subtriangles of each, read as wide as these are, so that a texture's levels miss nothing between
// them.
struct EmissionReads {
  std::int32_t side = 1;
  std::vector<float> total;  // [triangle][side^2]
};

// So many that a texture of 512 x 512 on a rectangle has each texel read, in some 30 ms.
EmissionReads read_emission(const SceneView& scene, std::int32_t mesh, std::size_t triangles,
                            const std::array<double, 3>& of_rgb) {
  constexpr std::size_t most_reads = std::size_t(1) << 19, most_side = 512;
  const MeshView& view = scene.meshes[mesh];
  EmissionReads reads;
  if (scene.materials[view.material].emissive_texture >= 0)
    while (4 * triangles * static_cast<std::size_t>(reads.side * reads.side) <= most_reads &&
           static_cast<std::size_t>(reads.side) < most_side)
      reads.side *= 2;
  const std::int32_t each = reads.side * reads.side;
  reads.total.resize(triangles * static_cast<std::size_t>(each));
  parallel_for(std::size_t{0}, triangles, [&](std::size_t t) {
    const double width_m = std::sqrt(area_of(corners_of(view, t))) / reads.side;
    for (std::int32_t k = 0; k < each; ++k) {
      const auto [u, v] = middle_of(subtriangle(k, reads.side));
      const Color<float> c = emitted_rgb(
          scene, view,
          SurfacePoint<float, std::int32_t>{static_cast<std::int32_t>(t), static_cast<float>(u),
                                            static_cast<float>(v), static_cast<float>(width_m)});
      reads.total[t * static_cast<std::size_t>(each) + static_cast<std::size_t>(k)] =
          static_cast<float>(of_rgb[0] * double{c.r} + of_rgb[1] * double{c.g} +
                             of_rgb[2] * double{c.b});
    }
  });
  return reads;
}

// Root mean square of emission on each part of triangles divided by `divisions`: where places on a
// part are chosen evenly, the number of samples that leaves the least variance goes as that.
std::vector<double> emission_of_parts(const EmissionReads& reads, std::int32_t divisions) {
  const std::int32_t each = reads.side * reads.side, parts = divisions * divisions;
  const std::size_t triangles = reads.total.size() / static_cast<std::size_t>(each);
  std::vector<double> found(triangles * static_cast<std::size_t>(parts));
  const auto read = [&](std::size_t t, std::int32_t k) {
    return double{reads.total[t * static_cast<std::size_t>(each) + static_cast<std::size_t>(k)]};
  };
  const auto part = [&](std::size_t t, std::int32_t k) -> double& {
    return found[t * static_cast<std::size_t>(parts) + static_cast<std::size_t>(k)];
  };
  const auto within = [](std::int32_t number, std::int32_t own, std::int32_t of) {
    const auto [u, v] = middle_of(subtriangle(number, own));
    return subtriangle_at(static_cast<float>(u), static_cast<float>(v), of);
  };
  if (divisions > reads.side) {
    for (std::int32_t k = 0; k < parts; ++k) {
      const std::int32_t at = within(k, divisions, reads.side);
      for (std::size_t t = 0; t < triangles; ++t) part(t, k) = read(t, at);
    }
    return found;
  }
  for (std::int32_t k = 0; k < each; ++k) {
    const std::int32_t at = within(k, reads.side, divisions);
    for (std::size_t t = 0; t < triangles; ++t) part(t, at) += read(t, k) * read(t, k);
  }
  for (double& x : found) x = std::sqrt(x * parts / each);
  return found;
}

// Into how many parts the sides of a mesh's triangles are divided, and area times emission of each
// part, in the mesh's own frame.
struct DividedMesh {
  std::int32_t divisions = 1;
  std::vector<double> powers;  // [triangle][divisions^2]
};

// Divisions are by twos, to not many more than `most_lights`.
constexpr std::int32_t most_divisions = 32;
constexpr std::size_t most_lights = 1 << 13;

std::int32_t divisions_within(std::int32_t wanted, std::size_t triangles) {
  std::int32_t divisions = 1;
  while (2 * divisions <= std::min(wanted, most_divisions) &&
         4 * triangles * static_cast<std::size_t>(divisions * divisions) <= most_lights)
    divisions *= 2;
  return divisions;
}

// Of long triangles some parts may be far nearer to a place than others.
std::int32_t divisions_by_shape(const MeshView& view, std::size_t triangles) {
  double longest_2 = 0, areas = 0;
  for (std::size_t t = 0; t < triangles; ++t) {
    const std::array<Vec3d, 3> corner = corners_of(view, t);
    double of_this = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d side = corner[(k + 1) % 3] - corner[k];
      of_this = std::max(of_this, dot(side, side));
    }
    longest_2 += of_this;
    areas += area_of(corner);
  }
  constexpr double long_from = 8;  // 2 for two triangles of a square
  const double wanted = areas > 0 ? longest_2 / (2 * areas * long_from) : 1;
  return divisions_within(static_cast<std::int32_t>(std::min(wanted, 1e3)), triangles);
}

DividedMesh divide_mesh(const SceneView& scene, std::int32_t mesh, std::size_t triangles,
                        const std::array<double, 3>& of_rgb) {
  const MeshView& view = scene.meshes[mesh];
  const EmissionReads reads = read_emission(scene, mesh, triangles, of_rgb);
  std::vector<double> areas(triangles);
  for (std::size_t t = 0; t < triangles; ++t) areas[t] = area_of(corners_of(view, t));
  const double whole_area = std::accumulate(areas.begin(), areas.end(), 0.0);
  const auto powers_of = [&](std::int32_t divisions) {
    const auto parts = static_cast<std::size_t>(divisions * divisions);
    std::vector<double> powers = emission_of_parts(reads, divisions);
    for (std::size_t i = 0; i < powers.size(); ++i)
      powers[i] *= areas[i / parts] / static_cast<double>(parts);
    return powers;
  };
  const auto sum_of_powers = [&](std::int32_t divisions) {
    const std::vector<double> powers = powers_of(divisions);
    return std::accumulate(powers.begin(), powers.end(), 0.0);
  };

  // As few parts as let samples of the whole scatter hardly more than the finest do.
  DividedMesh divided{divisions_by_shape(view, triangles), {}};
  const std::int32_t finest = divisions_within(reads.side, triangles);
  if (finest > divided.divisions) {
    constexpr double hardly_more = 1.05;  // root mean square of what a sample brings
    const double least = sum_of_powers(finest);
    while (divided.divisions < finest && sum_of_powers(divided.divisions) > hardly_more * least)
      divided.divisions *= 2;
  }
  divided.powers = powers_of(divided.divisions);

  // What was missed by reading may shine all the same. Rays that go to dark parts are lost.
  const Vec3 factor = scene.materials[view.material].emissive;
  const double whole =
      of_rgb[0] * double{factor.x} + of_rgb[1] * double{factor.y} + of_rgb[2] * double{factor.z};
  const double mean =
      whole_area > 0
          ? std::accumulate(divided.powers.begin(), divided.powers.end(), 0.0) / whole_area
          : 0;
  const double least = reads.side < 4 ? 0.05 * whole : std::max(1e-3 * mean, 1e-6 * whole);
  const auto parts = static_cast<std::size_t>(divided.divisions * divided.divisions);
  for (std::size_t i = 0; i < divided.powers.size(); ++i)
    divided.powers[i] =
        std::max(divided.powers[i], least * areas[i / parts] / static_cast<double>(parts));
  return divided;
}

// Places on a triangle, chosen evenly, vary by a twelfth of its corners' squared distances from its
// middle, summed. `in_front`: light goes to the side of the normal alone.
LightTree make_triangle_tree(const MeshView& view, const DividedMesh& divided, bool in_front) {
  const auto parts = static_cast<std::size_t>(divided.divisions * divided.divisions);
  std::vector<TreeLight> lights(divided.powers.size());
  parallel_for(std::size_t{0}, lights.size(), [&](std::size_t t) {
    std::array<Vec3d, 3> corner = corners_of(view, t / parts);
    const Vec3d e1 = corner[1] - corner[0], e2 = corner[2] - corner[0], normal = cross(e1, e2);
    if (parts > 1) {
      const Subtriangle sub = subtriangle(static_cast<std::int32_t>(t % parts), divided.divisions);
      corner[0] = corner[0] + e1 * double{sub.u} + e2 * double{sub.v};
      corner[1] = corner[0] + e1 * double{sub.scale};
      corner[2] = corner[0] + e2 * double{sub.scale};
    }
    const Vec3d middle = (corner[0] + corner[1] + corner[2]) * (1.0 / 3);
    TreeLight& light = lights[t] = tree_light(middle, divided.powers[t]);
    for (const Vec3d& at : corner) {
      light.box = box_around(light.box, {at, at, false});
      light.variance_m2 += dot(at - middle, at - middle) / 12;
    }
    if (in_front && dot(normal, normal) > 0) {
      light.axis = normalize(normal);
      light.reach_rad = pi / 2;
    }
  });
  return make_light_tree(lights);
}

// Whether skins or morph targets move its triangles.
bool is_deformed(const Scene& scene, std::int32_t mesh) {
  return scene.rig != nullptr &&
         std::any_of(scene.rig->deformations.begin(), scene.rig->deformations.end(),
                     [&](const Deformation& deformation) { return deformation.mesh == mesh; });
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
    TreeLight light{placed_box(own.box, placed), transform_point(placed, own.centre_m),
                    own.variance_m2 * squares / 3, data.emissive_weight[e]};
    // A plane stays one however it is placed; the sides of a wider cone may be moved apart.
    if (own.reach_rad < pi / 2 + 1e-5) {
      const Mat4 back = inverse(placed);
      const auto along = [&](int c) {
        return back.m[0][c] * own.axis.x + back.m[1][c] * own.axis.y + back.m[2][c] * own.axis.z;
      };
      light.axis = normalize({along(0), along(1), along(2)});
      light.reach_rad = own.reach_rad;
    }
    lights.push_back(light);
  }
  return lights;
}

}  // namespace

std::vector<double> make_emissive(LightData& data, const Light& light, const Scene& scene,
                                  const Placement& placement, const SceneView& view,
                                  double distance_m) {
  std::vector<double> sent(light.bands.count(), 0.0);
  std::map<std::int32_t, double> power_of_mesh;
  std::map<std::int32_t, std::int32_t> divisions_of_mesh;
  data.emissive_of_instance.assign(scene.instances.size(), -1);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const std::int32_t mesh = scene.instances[i].mesh;
    const std::size_t triangles = scene.meshes[static_cast<std::size_t>(mesh)].triangles.size();
    const std::int32_t material = view.meshes[mesh].material;
    const float* matrix = view.scatter[material].emission;
    if (triangles == 0 || matrix == nullptr) continue;
    std::array<double, 3> of_rgb{};
    for (std::size_t k = 0; k < 3 * sent.size(); ++k)
      of_rgb[k % 3] += static_cast<double>(matrix[k]);
    const auto [known, is_new] = power_of_mesh.try_emplace(mesh, 0.0);
    if (is_new) {
      const DividedMesh divided = divide_mesh(view, mesh, triangles, of_rgb);
      known->second = std::accumulate(divided.powers.begin(), divided.powers.end(), 0.0);
      divisions_of_mesh[mesh] = divided.divisions;
      if (known->second > 0) {
        const bool in_front = !view.materials[material].double_sided && !is_deformed(scene, mesh);
        data.triangle_tree[mesh] = make_triangle_tree(view.meshes[mesh], divided, in_front);
        data.triangle_powers[mesh] = sums_of(divided.powers, triangles);
      }
    }
    if (!(known->second > 0)) continue;
    data.emissive_of_instance[i] = static_cast<std::int32_t>(data.emissive.size());
    data.emissive.push_back({static_cast<std::int32_t>(i), mesh, divisions_of_mesh[mesh],
                             data.triangle_tree[mesh].view()});
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
  if (!data.emissive.empty())
    place_lights(data.emissive_tree, placed_emissive(data, frame_from_mesh));
}

}  // namespace omma
