// Mirror images of discs, one for each disc and each direction that smooth flat surfaces face; spheres
// about surfaces that shine.
#include "backend/light_aims.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "physics/surface/microfacet.h"

namespace omma {
namespace {

// Each is tested for each ommatidium in each frame.
constexpr std::size_t most_aims = 16;

// Of scenes full of small mirrors the first so many directions count; others are found by rays.
constexpr std::size_t most_mirrors = 64;

// A rougher surface spreads the sun over degrees, which ordinary rays find.
constexpr float most_mirror_roughness = 0.1f;
// Surfaces whose normals differ by more, rad, show the sun in more than one direction.
constexpr double flat_rad = 5e-4;

bool is_mirror(const Material& material) {
  if (material.unlit) return false;
  if (material.clearcoat > 0 && material.clearcoat_roughness <= most_mirror_roughness &&
      material.clearcoat_normal_texture.texture < 0)
    return true;
  return material.roughness <= most_mirror_roughness && material.normal_texture.texture < 0 &&
         (material.specular > 0 || material.metallic > 0);
}

// By how much a mirror's roughness spreads what it shows: some widths of its normals, twice.
double spread_rad(const Material& material) {
  const float rough = material.clearcoat > 0
                          ? std::min(material.clearcoat_roughness, material.roughness)
                          : material.roughness;
  const double alpha = std::pow(static_cast<double>(std::max(rough, least_roughness)), 2);
  return 2 * flat_rad + 4 * alpha;
}

// A vertex of an instance, in the world.
Vec3d place_of(const MeshView& mesh, const Mat4& world_from_mesh, std::uint32_t vertex) {
  const float* p = mesh.positions + 3 * static_cast<std::size_t>(vertex);
  return transform_point(world_from_mesh, Vec3d{p[0], p[1], p[2]});
}

// The direction that all triangles of an instance face, unit, or none.
std::optional<Vec3d> facing(const Scene& scene, const Placement& placement, const SceneView& view,
                            std::size_t instance) {
  const auto mesh = static_cast<std::size_t>(scene.instances[instance].mesh);
  const Mat4& world_from_mesh = placement.world_from_mesh[instance];
  std::optional<Vec3d> found;
  for (const auto& triangle : scene.meshes[mesh].triangles) {
    Vec3d corner[3];
    for (std::size_t k = 0; k < 3; ++k)
      corner[k] = place_of(view.meshes[mesh], world_from_mesh, triangle[k]);
    const Vec3d normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double size = length(normal);
    if (!(size > 0)) continue;
    const Vec3d unit = normal * (1 / size);
    if (!found) found = unit;
    const Vec3d off = cross(*found, unit);
    if (length(off) > flat_rad) return std::nullopt;
  }
  return found;
}

double solid_of(double radius_rad) {
  return 2 * pi * (1 - std::cos(radius_rad));
}

void add_mirror_images(const LightData& data, const Scene& scene, const Placement& placement,
                       const SceneView& view, std::vector<AimView>& aims) {
  if (data.discs.empty()) return;
  const auto bands = static_cast<std::size_t>(data.view.bands);
  struct Mirror {
    Vec3d facing;
    double spread_rad;
  };
  std::vector<Mirror> mirrors;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const auto mesh = static_cast<std::size_t>(scene.instances[i].mesh);
    const std::int32_t material = scene.meshes[mesh].material;
    if (material < 0 || !is_mirror(scene.materials[static_cast<std::size_t>(material)])) continue;
    const std::optional<Vec3d> normal = facing(scene, placement, view, i);
    if (!normal) continue;
    const double spread = spread_rad(scene.materials[static_cast<std::size_t>(material)]);
    const auto same = std::find_if(mirrors.begin(), mirrors.end(), [&](const Mirror& known) {
      return length(cross(known.facing, *normal)) < flat_rad;
    });
    if (same != mirrors.end())
      same->spread_rad = std::max(same->spread_rad, spread);
    else if (mirrors.size() < most_mirrors)
      mirrors.push_back({*normal, spread});
  }
  for (std::size_t d = 0; d < data.discs.size(); ++d) {
    const DiscView& disc = data.discs[d];
    const float* radiance = data.disc_radiance.data() + d * bands;
    const double brightest = static_cast<double>(*std::max_element(radiance, radiance + bands));
    const double radius_rad = 2 * std::asin(0.5 * std::sqrt(static_cast<double>(disc.chord_2)));
    for (const Mirror& mirror : mirrors) {
      const Vec3d from = to_double(disc.direction);
      const Vec3d image = from - mirror.facing * (2 * dot(from, mirror.facing));
      AimView aim;
      aim.centre = to_float(normalize(image));
      aim.radius = static_cast<float>(radius_rad + mirror.spread_rad);
      aim.is_direction = true;
      aim.brightest = static_cast<float>(brightest * solid_of(radius_rad) /
                                         solid_of(static_cast<double>(aim.radius)));
      aims.push_back(aim);
    }
  }
}

void add_shining(const LightData& data, const Scene& scene, const Placement& placement,
                 const SceneView& view, std::vector<AimView>& aims) {
  for (const EmissiveView& emissive : data.emissive) {
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(emissive.mesh)];
    const Mat4& world_from_mesh =
        placement.world_from_mesh[static_cast<std::size_t>(emissive.instance)];
    const auto vertices = static_cast<std::uint32_t>(mesh.positions.size());
    const auto place = [&](std::uint32_t vertex) {
      return place_of(view.meshes[emissive.mesh], world_from_mesh, vertex);
    };
    Vec3d middle{};
    for (std::uint32_t v = 0; v < vertices; ++v) middle = middle + place(v) * (1.0 / vertices);
    double radius_m = 0;
    for (std::uint32_t v = 0; v < vertices; ++v)
      radius_m = std::max(radius_m, length(place(v) - middle));
    const std::int32_t material = view.meshes[emissive.mesh].material;
    const Vec3 factor = view.materials[material].emissive;
    const float* matrix = view.scatter[material].emission;
    AimView aim;
    aim.centre = to_float(middle - placement.origin_m);
    aim.radius = static_cast<float>(radius_m);
    for (std::int32_t b = 0; b < data.view.bands; ++b)
      aim.brightest = std::max(aim.brightest, matrix[3 * b] * factor.x + matrix[3 * b + 1] * factor.y +
                                                  matrix[3 * b + 2] * factor.z);
    aims.push_back(aim);
  }
}

// How bright and how large, beside others of its kind.
float weight_of(const AimView& aim) {
  return aim.brightest * aim.radius * aim.radius;
}

}  // namespace

std::vector<AimView> make_aims(const LightData& data, const Scene& scene, const Placement& placement,
                               const SceneView& view) {
  std::vector<AimView> aims;
  add_mirror_images(data, scene, placement, view, aims);
  const auto first_shining = static_cast<std::ptrdiff_t>(std::min(aims.size(), most_aims / 2));
  const auto brighter = [](const AimView& a, const AimView& b) { return weight_of(a) > weight_of(b); };
  std::stable_sort(aims.begin(), aims.end(), brighter);
  aims.resize(static_cast<std::size_t>(first_shining));
  add_shining(data, scene, placement, view, aims);
  std::stable_sort(aims.begin() + first_shining, aims.end(), brighter);
  if (aims.size() > most_aims) aims.resize(most_aims);
  return aims;
}

}  // namespace omma
