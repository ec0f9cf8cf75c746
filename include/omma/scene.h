// A scene as plain arrays and integer handles: meshes, instances, materials, textures, images,
// cameras, Gaussian splats and a background. It is validated once, where it is made
// (`validate_scene`), and trusted from then on. World frame: glTF's, right-handed, +Y up, metres.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "omma/scene_kinds.h"
#include "omma/spectrum.h"
#include "omma/splats.h"
#include "omma/vec.h"

namespace omma {

// An image in memory, row 0 at the top, RGBA. Exactly one of the two arrays is filled.
struct Image {
  std::string name;
  int width = 0, height = 0;             // pixels
  std::vector<std::uint8_t> rgba_srgb8;  // [height][width][4], colour sRGB encoded, alpha linear
  std::vector<float> rgba_linear;        // [height][width][4], linear
  bool operator==(const Image&) const = default;
};

// How an image is read: glTF texture and sampler in one.
struct Texture {
  int image = -1;  // index into Scene::images
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  Filter filter = Filter::linear;
  bool operator==(const Texture&) const = default;
};

// A material's use of a texture: which one, read with which texture coordinates.
struct TextureUse {
  int texture = -1;      // index into Scene::textures, -1 for none
  int texcoord_set = 0;  // 0 or 1
  // KHR_texture_transform: uv' = offset + rotation * scale * uv.
  Vec2 offset{0, 0}, scale{1, 1};
  float rotation_rad = 0;
  bool operator==(const TextureUse&) const = default;
};

// More of a surface's reflectance than RGB says: an image whose channels are amounts of given
// spectra, e.g. a petal's ultraviolet guide. They add to what the base colour gives.
struct ExtraReflectance {
  TextureUse texture;                // linear, not sRGB
  std::array<Spectrum, 3> spectrum;  // reflectance where the channel red, green, blue is 1; or empty
  bool operator==(const ExtraReflectance&) const = default;
};

// How a surface reflects by wavelength and angle, as stacks of thin films and metals do: what the
// field amplitudes r of both polarisations become on the way, across the plane of incidence (s) and
// in it (p), as a = (|r_s|^2 + |r_p|^2) / 2, b = (|r_s|^2 - |r_p|^2) / 2 and c = Re(r_s r_p*), signs
// as in Fresnel's equations of physics/surface/fresnel.h: at normal incidence c = -a.
struct BoundaryTable {
  std::vector<double> wavelength_nm;  // [knot], ascending
  int cosines = 0;                    // of the angle of incidence, even from 0 to 1
  std::vector<float> mueller;         // [knot][cosine][a, b, c]

  bool empty() const { return wavelength_nm.empty(); }
  bool operator==(const BoundaryTable&) const = default;
};

struct Material {
  std::string name;
  Vec4 base_color{1, 1, 1, 1};  // linear RGBA factor
  TextureUse base_color_texture;
  Vec3 emissive{0, 0, 0};  // linear factor, emissive strength included
  TextureUse emissive_texture;
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;  // false: back faces are invisible (glTF 2.0, 3.9.3)
  bool unlit = false;         // KHR_materials_unlit

  // How it scatters light, as glTF 2.0 and its extensions say; for worlds that are lit. Rough
  // matter: who makes one by hand means that. glTF's own default, metallic 1, the loader sets.
  float metallic = 0, roughness = 1;
  TextureUse metallic_roughness_texture;  // metallic in blue, roughness in green; linear
  TextureUse normal_texture;              // linear
  float normal_scale = 1;
  float ior = 1.5f;                // KHR_materials_ior, 1 or more
  float specular = 1;              // KHR_materials_specular, 0 to 1
  TextureUse specular_texture;     // a factor of it, alpha
  Vec3 specular_color{1, 1, 1};    // KHR_materials_specular, 0 to 1
  TextureUse specular_color_texture;  // sRGB
  float transmission = 0;          // KHR_materials_transmission: straight through
  TextureUse transmission_texture;  // a factor of it, red; linear
  // KHR_materials_volume. Above 0: meshes bound a volume, into which what is transmitted bends (how
  // far above does not count); 0: they are thin sheets.
  float thickness_m = 0;
  Vec3 attenuation_color{1, 1, 1};  // linear, what is left of white after attenuation_distance_m
  float attenuation_distance_m = std::numeric_limits<float>::infinity();
  Spectrum absorption_per_m;  // of the volume, in place of these two
  float diffuse_transmission = 0;  // KHR_materials_diffuse_transmission
  Vec3 diffuse_transmission_color{1, 1, 1};
  TextureUse diffuse_transmission_factor_texture;  // a factor of it, alpha
  TextureUse diffuse_transmission_texture;         // of the colour, sRGB
  float clearcoat = 0, clearcoat_roughness = 0;  // KHR_materials_clearcoat
  TextureUse clearcoat_texture;                  // a factor of clearcoat, red; linear
  TextureUse clearcoat_roughness_texture;        // a factor of that, green; linear
  TextureUse clearcoat_normal_texture;  // linear; none: the mesh's normals, whatever normal_texture
  float clearcoat_normal_scale = 1;

  // Spectra of the diffuse part, where known, at a base colour (factor x texture x vertex colour)
  // of this luminance (relative, of linear sRGB); proportional to it at others. Else RGB stands for
  // the primary spectra (omma/receptor.h).
  Spectrum reflectance;
  Spectrum transmittance;  // through the sheet; in place of diffuse_transmission and its colour
  float spectral_luminance = 1;
  ExtraReflectance extra;
  BoundaryTable boundary;  // of its metal, in place of the base colour; or empty
  // W m^-2 sr^-1 nm^-1 where the emissive factor times texture has luminance 1; empty: emissive is
  // cd m^-2 of the primary spectra.
  Spectrum emission;
  bool operator==(const Material&) const = default;
};

// KHR_lights_punctual: shines along the -Z of its node.
struct PunctualLight {
  std::string name;  // of the node, or else of the light
  PunctualLightType type = PunctualLightType::point;
  Vec3 color{1, 1, 1};   // linear
  double intensity = 1;  // cd, or lx where directional
  double range_m = 0;    // 0: without end
  double inner_cone_rad = 0, outer_cone_rad = pi / 4;  // spot, half angles
  Mat4 world_from_light;
  // W sr^-1 nm^-1, or W m^-2 nm^-1 where directional, in place of colour and intensity.
  Spectrum spectrum;
  bool operator==(const PunctualLight&) const = default;
};

// Triangles of one material, in their own frame.
struct Mesh {
  std::string name;
  std::vector<Vec3> positions;                          // [vertex], m
  std::vector<std::array<std::uint32_t, 3>> triangles;  // [triangle], counter-clockwise in front
  std::vector<Vec3> normals;                            // [vertex], none zero, or empty
  std::array<std::vector<Vec2>, 2> texcoords;           // [set][vertex], or empty
  std::vector<Vec4> colors;                             // [vertex], linear RGBA, or empty
  int material = -1;                                    // index into Scene::materials, -1: white
  bool operator==(const Mesh&) const = default;
};

// A mesh placed in the world. Several instances may share one mesh; the mesh is stored once.
struct Instance {
  std::string name;  // of the node
  int mesh = -1;     // index into Scene::meshes
  Mat4 world_from_mesh;
  // Index of the node in the file, -1 for none. A node with several primitives places several
  // meshes, all with its transform, and they move together.
  int node = -1;
  bool operator==(const Instance&) const = default;
};

// Triangles that mark a region (a mesh whose extras say "hitbox": true). Never drawn.
struct HitBox {
  std::string name;                                     // of the mesh
  std::vector<Vec3> positions;                          // [vertex], m, in its own frame
  std::vector<std::array<std::uint32_t, 3>> triangles;  // [triangle]
  Mat4 world_from_mesh;
  bool operator==(const HitBox&) const = default;
};

// A perspective camera whose extras say "panoramic" is panoramic, one whose extras say
// "compound-eye" is compound (CompoundRay's names; true as a bool or as a string in any case).
enum class CameraType : std::uint8_t { perspective, orthographic, panoramic, compound };

// A camera node. It looks along its -Z, +Y is up.
struct Camera {
  std::string name;       // of the node (of the camera where the node has none)
  std::string data_name;  // of the camera itself; find_camera takes either
  CameraType type = CameraType::perspective;
  double yfov_rad = 0, aspect_ratio = 0;  // perspective; aspect 0 where the file gives none
  double xmag_m = 0, ymag_m = 0;          // orthographic half extents
  double znear_m = 0, zfar_m = 0;         // zfar 0 where the file gives none
  Mat4 world_from_camera;                 // with the node's scale
  std::string extras_json;                // the camera's extras as JSON text, "" for none
  std::string compound_structure;         // extras["compound-structure"], an .eye file, "" for none
  std::string compound_projection;        // extras["compound-projection"], "" for none
  bool operator==(const Camera&) const = default;
};

// Radiance of a ray that meets no surface.
struct Background {
  BackgroundType type = BackgroundType::constant;
  Vec3 color{0, 0, 0};  // constant: linear radiance
  // image: equirectangular, forward (-Z) in the middle, +X to the right of it, +Y at the top.
  Image image;
  bool operator==(const Background&) const = default;
};

// How textures and vertex colours become the colour of a surface.
//   gltf: factor x texture (sRGB) x vertex colour (linear), as glTF 2.0 says.
//   compoundray: the vertex colour to the power 2.2 where there is one, else factor x (texture to
//   the power 2.2), both raised after interpolation; for comparison with published work.
enum class ColorRule : std::uint8_t { gltf, compoundray };

struct Rig;  // omma/rig.h

struct Scene {
  std::string path;  // the file it came from, "" for one made in memory
  ColorRule color_rule = ColorRule::gltf;
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<Image> images;
  std::vector<Camera> cameras;
  std::vector<HitBox> hit_boxes;
  std::vector<PunctualLight> lights;
  std::vector<SplatCloud> splats;
  Background background;
  std::shared_ptr<const Rig> rig;        // how things move and change their shape; null: nothing does
  std::vector<std::string> scene_names;  // of all scenes in the file
  int node_count = 0;                    // nodes reached from the loaded scene
  std::vector<std::string> warnings;     // what the loader passed over, a sentence each
};

// Whether two scenes hold the same, wherever they came from: path, warnings, scene names and the
// count of nodes play no part. Of `Instance::node` only which instances move together does.
bool operator==(const Scene& a, const Scene& b);

struct Bounds {
  Vec3d lower, upper;  // m, world frame
  bool empty = true;
};

// Checks every handle and number; throws omma::Error naming scene.path and the place.
void validate_scene(const Scene& scene);

// Corners of the box around all instances and the middles of splats.
Bounds scene_bounds(const Scene& scene);

// Corners of the box around a hit box, in the world.
Bounds hit_box_bounds(const HitBox& box);

// Whether a point (m, world) lies inside a closed hit box: whether a ray from it crosses the
// surface an odd number of times.
bool is_inside(const HitBox& box, Vec3d point);

// Triangles as seen: each instance counts those of its mesh.
std::uint64_t triangle_count(const Scene& scene);

// Gaussian splats of all clouds.
std::uint64_t splat_count(const Scene& scene);

// The camera whose node, or else which itself, has that name; throws omma::Error that lists the
// names and indices there are, or where several have it.
const Camera& find_camera(const Scene& scene, std::string_view name);

}  // namespace omma
