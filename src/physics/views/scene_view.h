// The scene as the physics sees it: flat arrays behind pointers, the same on host and device. Made
// from a Scene by backend/shading_data, which has baked texture transforms into the coordinates.
#pragma once

#include <cstdint>

#include "omma/scene_kinds.h"
#include "omma/vec.h"
#include "physics/views/version.h"

namespace omma {

struct CellError;  // omma/baked_cell.h

struct TextureView {
  // Levels follow one another, each half as wide and high as the one before, rounded up. Floats,
  // or 16 bits: components 65535 for 1, two to a word, the even ones low; where `codes` is set these
  // begin with level 1, and level 0 is its 8 bits, that stand for the values of a table.
  const float* linear = nullptr;           // [level][height][width][4], linear RGBA; else null
  const std::int32_t* linear16 = nullptr;  // [level][height][width][2], linear RG and BA
  const std::uint8_t* codes = nullptr;     // [height][width][4], sRGB and alpha, or null
  const std::int32_t* value_of_code = nullptr;  // [256], 0 to 65535, of colours, or null
  std::int32_t width = 1, height = 1;      // of level 0
  std::int32_t last_level = 0;
  const std::int32_t* first_texel = nullptr;  // [level], where there is more than one
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  Filter filter = Filter::linear;
  Version version = 0;
};

struct MaterialView {
  Vec4 base_color{1, 1, 1, 1};
  Vec3 emissive{0, 0, 0};
  std::int32_t base_texture = -1, emissive_texture = -1;  // index into SceneView::textures
  float alpha_cutoff = 0.5f;
  AlphaMode alpha_mode = AlphaMode::opaque;
  bool double_sided = true;
  bool is_glass = false;  // whether light goes straight through, where there is light
};

// How a material scatters light in the world's bands; null pointers where there is nothing.
struct ScatterView {
  float metallic = 0, roughness = 1, normal_scale = 1;
  float ior = 1.5f, specular = 1, transmission = 0;
  float clearcoat = 0, clearcoat_roughness = 0, coat_normal_scale = 1;
  // Where a texture has factors of it: the fraction that goes through diffusely, which `transmittance`
  // leaves out then, and whether `reflectance` is of what does not.
  float diffuse_transmission = 0;
  bool reflects_the_rest = false;
  Vec3 transmission_color{1, 1, 1};  // of diffuse transmission
  // Index into SceneView::textures, -1 for none.
  std::int32_t roughness_texture = -1, normal_texture = -1, transmission_texture = -1,
               extra_texture = -1;
  // Of linear R, G, B of the base colour (`reflectance`) or of the transmission's colour
  // (`transmittance`; null: nothing is transmitted), and of 1: [band][4].
  const float* reflectance = nullptr;
  const float* transmittance = nullptr;
  bool transmits_base_color = false;       // the transmission's colour is the base colour
  const float* extra = nullptr;            // of the extra texture's R, G, B: [band][3]
  const float* emission = nullptr;         // of linear RGB: [band][3]
  const float* specular_tint = nullptr;    // [band], at normal incidence; null: 1
  const float* tint_from_rgb = nullptr;    // in its place, of a texture's R, G, B: [band][3]
  std::int32_t albedo_table = 0;  // of its ior, among SceneView::specular_albedo
  std::int32_t boundary = -1;     // of its metal, among SceneView::boundaries; -1: its colour
  bool refracts = false;          // whether its meshes bound a volume, into which rays bend
  const float* absorption_per_m = nullptr;  // [band], of the volume; null: nothing is absorbed
};

// A texture as one mesh reads it.
struct TextureRead {
  std::int32_t texture = -1;       // index into SceneView::textures, -1 for none
  const float* uv = nullptr;       // as MeshView::base_uv
  const float* density = nullptr;  // as MeshView::base_density
};

// Textures that few materials have, and the channel that is a factor.
struct FactorTextures {
  TextureRead specular;        // alpha
  TextureRead transmission;    // straight through; red
  TextureRead coat;            // red
  TextureRead coat_roughness;  // green
  TextureRead coat_normal;     // red, green and blue
  TextureRead specular_color;  // all, through ScatterView::tint_from_rgb
  TextureRead diffuse_transmission;  // alpha
};

struct MeshView {
  // Values of corners, [triangle][3], or in large scenes of vertices: those of `vertex_of_corner`.
  const float* base_uv = nullptr;                  // [.][u, v]; null where there is no texture
  const float* emissive_uv = nullptr;              // [.][u, v], or null
  const float* colors = nullptr;                   // [.][linear r, g, b, a], or null
  const std::int32_t* vertex_of_corner = nullptr;  // [triangle][3], or null
  // Texels of level 0 per metre of the mesh, along the direction in which they are least dense.
  const float* base_density = nullptr;      // [triangle], where the texture has levels
  const float* emissive_density = nullptr;  // [triangle], the same
  // What is known of a cut-out before its image is asked (physics/surface/opacity.h), or null.
  const std::int32_t* opacity = nullptr;    // [triangle]
  std::int32_t material = 0;                // index into SceneView::materials
  const float* positions = nullptr;         // [vertex][3], m, in the mesh's frame
  const std::int32_t* triangles = nullptr;  // [triangle][3], vertices
  // For light, as base_uv and base_density; null where there is no texture, or no light.
  const float* roughness_uv = nullptr;
  const float* normal_uv = nullptr;
  const float* transmission_uv = nullptr;
  const float* extra_uv = nullptr;
  const float* roughness_density = nullptr;
  const float* normal_density = nullptr;
  const float* transmission_density = nullptr;
  const float* extra_density = nullptr;
  const FactorTextures* factors = nullptr;  // null: none
  const float* normals = nullptr;  // [vertex][3], in the mesh's frame; null: those of triangles
  std::int32_t triangle_count = 0, vertex_count = 0;
  Version shape_version = 0;  // of positions and normals
};

struct LightView;   // light_view.h
struct SplatsView;  // splats_view.h
struct SunMapView;  // sun_map.h

// The first cell of each triangle of a mesh, within its instance's.
struct MeshCells {
  const std::int32_t* first = nullptr;  // [triangle + 1], or null: each triangle is a cell
  std::int32_t triangle_count = 0;
};

// omma::BakedLight.
struct BakedView {
  const std::uint16_t* values = nullptr;     // [cell][front, back][band], and the last line's rest
  const CellError* errors = nullptr;         // [cell][front, back], or null
  const std::int32_t* first_cell = nullptr;  // [instance of the scene], or -1
  const MeshCells* mesh_cells = nullptr;     // [mesh]
  const char* moves = nullptr;  // [instance of the scene], not 0 where it has moved since
  const std::uint16_t* probe_values = nullptr;  // [z][y][x][direction][band]
  float probe_origin_m[3] = {0, 0, 0}, probe_spacing_m[3] = {1, 1, 1};  // traced frame
  std::int32_t probes[3] = {2, 2, 2};
  const float* first_origin_m = nullptr;  // [3], of the frame of probes in the traced one
  float unit = 1;  // radiance of a value of 1
  std::int64_t value_count = 0;  // with the last line's rest
  std::int32_t cell_count = 0, instance_count = 0, mesh_count = 0;
  Version version = 0;  // of all but `moves` and `first_origin_m`
};

struct BackgroundView {
  BackgroundType type = BackgroundType::constant;
  Vec3 color{0, 0, 0};
  TextureView image;
  float image_density = 0;  // least dense pixels of the image, per rad
};

inline constexpr std::int32_t power_22_size = 4097;

// Of what changes while a world stands.
struct ChangingVersions {
  Version placed = 0;   // where things are
  Version colored = 0;  // what colours materials have
};

struct SceneView {
  const MeshView* meshes = nullptr;
  const MaterialView* materials = nullptr;
  const TextureView* textures = nullptr;
  BackgroundView background;
  // [power_22_size] t^2.2 at t = i / (power_22_size - 1) with ColorRule::compoundray, else null.
  const float* power_22 = nullptr;
  const std::int32_t* opacity_states = nullptr;  // [word], where there are opacity maps
  const float* frame_from_mesh = nullptr;  // [instance of the scene][3][4], traced frame, row major
  bool has_blend = false;  // whether any surface lets light through in part
  const SplatsView* splats = nullptr;     // null where there are none
  const float* splat_emission = nullptr;  // where the world is lit: [band][channel of splats]
  // What linear RGB is in each band: [bands][3], or null where the bands are RGB itself.
  int bands = 3;
  const float* band_from_rgb = nullptr;
  // Where the world is lit: by what, and how its surfaces scatter light; else null.
  const LightView* light = nullptr;
  const ScatterView* scatter = nullptr;  // [material], as `materials`
  const float* specular_albedo = nullptr;  // tables of specular_albedo.h, one for each ior
  const float* coat_albedo = nullptr;      // that of clear coats, or null where there are none
  const float* metal_albedo = nullptr;     // that of white metals, or null where there are none
  const float* boundaries = nullptr;       // tables of boundary_table.h, or null: there are none
  bool has_glass = false;  // whether light goes straight through any material
  bool has_volumes = false;  // whether any material refracts
  bool shines = false;     // whether any material does by itself
  int depth = 0;           // most scatterings on a path; 0: as many as it takes
  bool polarized = false;  // whether light is a Stokes vector on its way
  // Light that was found before; null: all light is followed along paths. Where it is set, `light`
  // samples only what it leaves out.
  const BakedView* baked = nullptr;
  // All that shines, for surfaces whose baked light is not read; null: all are read.
  const LightView* all_lights = nullptr;
  // How much of the sun, then the one disc, surfaces see; null: shadow rays find out.
  const SunMapView* sun_map = nullptr;

  std::int32_t mesh_count = 0, material_count = 0, texture_count = 0, instance_count = 0;
  std::int32_t albedo_table_count = 0;  // of specular_albedo
  std::int32_t boundary_count = 0;
  std::int64_t opacity_word_count = 0;

  // Of all arrays here and in views within, but those that have versions of their own.
  Version version = 0;
  Version bands_version = 0;                   // of band_from_rgb
  const ChangingVersions* changing = nullptr;  // where the world keeps them; null: nothing changes
};

// Where a ray met a surface.
struct SurfaceHit {
  std::int32_t mesh = -1;  // index into SceneView::meshes
  std::uint32_t triangle = 0;
  float u = 0, v = 0;     // barycentric weights of the second and third vertex
  float footprint_m = 0;  // width of the ray's footprint there, in metres of the mesh
};

}  // namespace omma
