// All arrays of the views that the physics reads, each with its shape: what must be copied where
// other memory is to hold a world, an eye and what is asked of them (copy_arrays.h does that).
//
// A line for each array, in the order of the struct: visit(array, shape), the shape as the view's
// own comment has it. Arrays of views that hold arrays themselves are visit.views(array, shape,
// ...), whose elements are visited by visit_arrays(element, visit, ...). Arrays that are written
// are those that are not of const. tests/python/test_view_arrays.py sees that none is missing.
//
// Arrays are of the version that the visitor has, visit.version, or of one behind the shape
// (physics/views/version.h).
#pragma once

#include <cstdint>
#include <utility>

#include "omma/baked_cell.h"
#include "physics/block/weigh.h"
#include "physics/light/sun_map.h"
#include "physics/rays/head_motion.h"
#include "physics/search/bvh.h"
#include "physics/search/splats_view.h"
#include "physics/surface/boundary_table.h"
#include "physics/surface/specular_albedo.h"
#include "physics/views/frame_view.h"
#include "physics/views/gather_task.h"
#include "physics/views/light_view.h"
#include "physics/views/scene_view.h"
#include "physics/views/truth_view.h"

namespace omma {

// While it lives, what is visited is of a version.
template <typename Visit>
class OfVersion {
 public:
  OfVersion(Visit& visit, Version version)
      : visit_(visit), before_(std::exchange(visit.version, version)) {}
  OfVersion(const OfVersion&) = delete;
  OfVersion& operator=(const OfVersion&) = delete;
  ~OfVersion() { visit_.version = before_; }

 private:
  Visit& visit_;
  Version before_;
};

// Of all levels.
inline std::int64_t texels_of(const TextureView& view) {
  std::int64_t texels = 0;
  for (std::int32_t level = 0; level <= view.last_level; ++level)
    texels += std::int64_t{((view.width - 1) >> level) + 1} * (((view.height - 1) >> level) + 1);
  return texels;
}

template <typename Visit>
void visit_arrays(TextureView& view, Visit& visit) {
  const OfVersion own(visit, view.version);
  const std::int64_t texels = texels_of(view);
  const std::int64_t coded =
      view.codes != nullptr ? std::int64_t{view.width} * view.height : std::int64_t{0};
  visit(view.linear, {texels, 4});
  visit(view.linear16, {texels - coded, 2});
  visit(view.codes, {view.height, view.width, 4});
  visit(view.value_of_code, {256});
  visit(view.first_texel, {view.last_level + 1});
}

// --- What worlds are made of.

template <typename Visit>
void visit_arrays(ScatterView& view, Visit& visit, std::int32_t bands) {
  visit(view.reflectance, {bands, 4});
  visit(view.transmittance, {bands, 4});
  visit(view.extra, {bands, 3});
  visit(view.emission, {bands, 3});
  visit(view.specular_tint, {bands});
  visit(view.tint_from_rgb, {bands, 3});
  visit(view.absorption_per_m, {bands});
}

// `corners`: of triangles, or vertices, as MeshView has it.
template <typename Visit>
void visit_arrays(TextureRead& view, Visit& visit, std::int64_t corners, std::int32_t triangles) {
  visit(view.uv, {corners, 2});
  visit(view.density, {triangles});
}

template <typename Visit>
void visit_arrays(FactorTextures& view, Visit& visit, std::int64_t corners,
                  std::int32_t triangles) {
  visit_arrays(view.specular, visit, corners, triangles);
  visit_arrays(view.transmission, visit, corners, triangles);
  visit_arrays(view.coat, visit, corners, triangles);
  visit_arrays(view.coat_roughness, visit, corners, triangles);
  visit_arrays(view.coat_normal, visit, corners, triangles);
  visit_arrays(view.specular_color, visit, corners, triangles);
  visit_arrays(view.diffuse_transmission, visit, corners, triangles);
}

template <typename Visit>
void visit_arrays(MeshView& view, Visit& visit) {
  const std::int32_t triangles = view.triangle_count;
  const std::int64_t corners = view.vertex_of_corner != nullptr ? std::int64_t{view.vertex_count}
                                                                : 3 * std::int64_t{triangles};
  visit(view.base_uv, {corners, 2});
  visit(view.emissive_uv, {corners, 2});
  visit(view.colors, {corners, 4});
  visit(view.vertex_of_corner, {triangles, 3});
  visit(view.base_density, {triangles});
  visit(view.emissive_density, {triangles});
  visit(view.opacity, {triangles});
  visit(view.positions, {view.vertex_count, 3}, view.shape_version);
  visit(view.triangles, {triangles, 3});
  visit(view.roughness_uv, {corners, 2});
  visit(view.normal_uv, {corners, 2});
  visit(view.transmission_uv, {corners, 2});
  visit(view.extra_uv, {corners, 2});
  visit(view.roughness_density, {triangles});
  visit(view.normal_density, {triangles});
  visit(view.transmission_density, {triangles});
  visit(view.extra_density, {triangles});
  visit.views(view.factors, {1}, corners, triangles);
  visit(view.normals, {view.vertex_count, 3}, view.shape_version);
}

template <typename Visit>
void visit_arrays(MeshCells& view, Visit& visit) {
  visit(view.first, {view.triangle_count + 1});
}

static_assert(sizeof(CellError) == 4);  // which BakedView only names

template <typename Visit>
void visit_arrays(BakedView& view, Visit& visit, std::int32_t bands, Version placed) {
  const OfVersion own(visit, view.version);
  visit(view.values, {view.value_count});
  visit(view.errors, {view.cell_count, 2});
  visit(view.first_cell, {view.instance_count});
  visit.views(view.mesh_cells, {view.mesh_count});
  visit(view.moves, {view.instance_count}, placed);
  visit(view.probe_values, {view.probes[2], view.probes[1], view.probes[0], 6, bands});
  visit(view.first_origin_m, {3}, placed);
}

template <typename Visit>
void visit_arrays(BackgroundView& view, Visit& visit) {
  visit_arrays(view.image, visit);
}

template <typename Visit>
void visit_arrays(SunMapView& view, Visit& visit) {
  visit(view.pages, {view.page_rows, view.page_columns});
  visit(view.words, {view.tile_count, sun_tile_words});
}

template <typename Visit>
void visit_arrays(SplatCloudView& view, Visit& visit) {
  visit(view.harmonics, {view.splat_count, view.terms, view.channels});
}

template <typename Visit>
void visit_arrays(SplatsView& view, Visit& visit, Version placed) {
  const OfVersion own(visit, view.version);
  visit(view.nodes, {view.node_count});
  visit(view.splats, {view.splat_count});
  visit.views(view.clouds, {view.cloud_count});
  visit(view.first_origin_m, {3}, placed);
}

// --- What shines.

template <typename Visit>
void visit_arrays(SkyView& view, Visit& visit, std::int32_t bands) {
  const std::int32_t cell_rows = 2 * (view.rows - 1);
  visit(view.radiance, {2, view.rows, view.columns, view.channels});
  visit(view.polarisation, {2, view.rows, view.columns, 2, view.channels});
  visit(view.band_from_channel, {bands, view.channels});
  visit(view.one_minus_sine, {view.rows});
  visit(view.row_sum, {cell_rows + 1});
  visit(view.column_sum, {cell_rows, view.columns + 1});
  // Entries are read in pairs.
  visit(view.row_guide, {cell_rows + 1});
  visit(view.column_guide, {std::int64_t{cell_rows} * view.columns + 1});
  visit(view.cell_density, {cell_rows, view.columns});
}

template <typename Visit>
void visit_arrays(DiscView& view, Visit& visit, std::int32_t bands) {
  visit(view.radiance, {bands});
  visit(view.limb, {bands});
}

template <typename Visit>
void visit_arrays(LampView& view, Visit& visit, std::int32_t bands) {
  visit(view.strength, {bands});
}

template <typename Visit>
void visit_arrays(LightTreeView& view, Visit& visit, Version placed) {
  visit(view.nodes, {2 * view.leaves - 1}, placed);
  visit(view.light_of_rank, {view.count}, placed);
  visit(view.rank_of_light, {view.count}, placed);
  visit(view.sum, {view.count + 1}, placed);
}

template <typename Visit>
void visit_arrays(EmissiveView& view, Visit& visit) {
  visit_arrays(view.triangles, visit, visit.version);
}

template <typename Visit>
void visit_arrays(CloudShadowView& view, Visit& visit) {
  visit(view.optical_depth, {view.rows, view.columns});
}

template <typename Visit>
void visit_arrays(KindView& view, Visit& visit, std::int32_t bands) {
  visit(view.sent, {bands});
}

template <typename Visit>
void visit_arrays(LightView& view, Visit& visit, Version placed) {
  visit_arrays(view.sky, visit, view.bands);
  visit(view.extinction_per_m, {view.bands});
  visit.views(view.discs, {view.disc_count}, view.bands);
  visit_arrays(view.clouds, visit);
  visit.views(view.lamps, {view.lamp_count}, view.bands);
  visit_arrays(view.lamp_tree, visit, visit.version);
  visit(view.lamp_origin_m, {3}, placed);
  visit.views(view.emissive, {view.emissive_count});
  visit_arrays(view.emissive_tree, visit, placed);
  visit(view.emissive_of_instance, {view.instance_count});
  visit(view.aims, {view.aim_count});
  visit_arrays(view.from_afar, visit, view.bands);
  visit_arrays(view.from_lamps, visit, view.bands);
  visit_arrays(view.from_surfaces, visit, view.bands);
}

template <typename Visit>
void visit_arrays(SceneView& view, Visit& visit) {
  const OfVersion made(visit, view.version);
  const ChangingVersions now =
      view.changing != nullptr ? *view.changing : ChangingVersions{view.version, view.version};
  visit(view.changing, {1}, Version{0});
  visit.views(view.meshes, {view.mesh_count});
  visit(view.materials, {view.material_count}, now.colored);
  visit.views(view.textures, {view.texture_count});
  visit_arrays(view.background, visit);
  visit(view.power_22, {power_22_size});
  visit(view.opacity_states, {view.opacity_word_count});
  visit(view.frame_from_mesh, {view.instance_count, 3, 4}, now.placed);
  if (view.splats != nullptr) visit(view.splat_emission, {view.bands, view.splats->channels});
  visit.views(view.splats, {1}, now.placed);
  visit(view.band_from_rgb, {view.bands, 3}, view.bands_version);
  visit.views(view.light, {1}, now.placed);
  visit.views(view.all_lights, {1}, now.placed);
  visit.views(view.scatter, {view.material_count}, view.bands);
  visit(view.specular_albedo, {view.albedo_table_count, albedo_floats});
  visit(view.coat_albedo, {albedo_floats});
  visit(view.metal_albedo, {albedo_floats});
  visit(view.boundaries, {view.boundary_count, view.bands, boundary_pairs, 2});
  visit.views(view.baked, {1}, view.bands, now.placed);
  visit.views(view.sun_map, {1});
}

template <typename Visit>
void visit_arrays(BvhView& view, Visit& visit) {
  const OfVersion placed(visit, view.placed_version);
  visit(view.top_nodes, {view.top_node_count});
  visit(view.trees, {view.tree_count});
  visit(view.nodes, {view.node_count}, view.triangles_version);
  visit(view.quads, {view.quad_count}, view.triangles_version);
  visit(view.placed, {view.placed_count});
  visit(view.frames, {view.frame_count});
}

// --- Eyes.

template <typename Visit>
void visit_arrays(EyeView& view, Visit& visit) {
  const OfVersion own(visit, view.version);
  const std::int32_t ommatidia = view.ommatidium_count + zeros_behind;
  for (const float*& component : view.origin) visit(component, {ommatidia});
  for (const float*& component : view.axis) visit(component, {ommatidia});
  for (const float*& component : view.up) visit(component, {ommatidia});
  visit(view.focal_offset_m, {ommatidia});
  visit(view.aperture_radius_m, {ommatidia});
  visit(view.scale, {ommatidia});
  visit(view.warp, {ommatidia});
  visit(view.ommatidium, {ommatidia});
  visit(view.number, {ommatidia});
}

template <typename Visit>
void visit_arrays(SensitivityView& view, Visit& visit) {
  visit(view.profile, {view.knots, 2});
  visit(view.right_rad, {view.columns});
  visit(view.up_rad, {view.rows});
  visit(view.table, {view.rows > 0 ? view.rows : 1, view.columns});
}

template <typename Visit>
void visit_arrays(AcceptanceWarpView& view, Visit& visit) {
  visit_arrays(view.sensitivity, visit);
  visit(view.theta, {view.rows, view.intervals + 1});
  visit(view.dtheta, {view.rows, view.intervals + 1});
  visit(view.azimuth, {AcceptanceWarpView::azimuths + 1, 2});
}

template <typename Visit>
void visit_arrays(PolarTablesView& view, Visit& visit) {
  visit(view.polar, {view.rows, view.intervals + 1, 2});
  visit(view.azimuth, {view.azimuth_parts, AcceptanceWarpView::azimuths + 1, 2});
  visit(view.azimuth_begin, {view.warps});
  visit(view.first_row, {view.warps});
}

template <typename Visit>
void visit_arrays(DirectionsView& view, Visit& visit) {
  const OfVersion own(visit, view.version);
  visit(view.local, {view.warp_count, view.patterns, 3, view.pattern_samples});
  visit(view.turns, {turn_count + 1});
  visit(view.fixed_turn, {view.warp_count});
  visit(view.footprint_rad, {view.warp_count});
  visit.views(view.warps, {view.warp_count});
  visit_arrays(view.polar, visit);
}

template <typename Visit>
void visit_arrays(SharedWeights& view, Visit& visit) {
  const OfVersion own(visit, view.version);
  visit(view.first, {view.ommatidium_count + 1});
  visit(view.ray, {view.entry_count});
  visit(view.weight, {view.entry_count});
}

// --- What is asked for.

template <typename Visit>
void visit_arrays(WeighTask& view, Visit& visit, const SharedWeights& shared, int outputs) {
  visit(view.radiance, {shared.ray_count, outputs});
  visit(view.responses, {shared.ommatidium_count, outputs});
}

template <typename Visit>
void visit_arrays(TruthView& view, Visit& visit) {
  visit(view.share_of_instance, {view.instance_count});
  visit(view.object_of_instance, {view.instance_count});
}

template <typename Visit>
void visit_arrays(FrameView& view, Visit& visit) {
  // Of views that are elsewhere when they have been visited.
  const std::int32_t bands = view.scene->bands, components = view.scene->polarized ? 3 : 1;
  const std::int32_t ommatidia = view.eye->ommatidium_count;
  const Version of_eye = view.eye->version;
  visit.views(view.scene, {1});
  visit.views(view.eye, {1});
  visit.views(view.directions, {view.rounds});
  visit(view.output_from_band, {view.outputs, components, bands});
  visit(view.nearest, {ommatidia, listened_to}, of_eye);
  visit.views(view.truth, {1});
}

template <typename Visit>
void visit_arrays(HeadMotion& view, Visit& visit) {
  visit(view.delay, {view.delays + 1});
  visit(view.node, {view.nodes, 3, 4});
}

// `frame`: that of the task, before it was copied.
template <typename Visit>
void visit_arrays(TruthTask& view, Visit& visit, const FrameView& frame) {
  const std::int32_t ommatidia = frame.eye->ommatidium_count;
  visit(view.objects, {frame.truth->object_count, 3, 3});
  visit(view.distance_m, {ommatidia});
  visit(view.nearest_m, {ommatidia});
  visit(view.inverse_distance_per_m, {ommatidia});
  visit(view.met, {ommatidia});
  visit(view.normal, {ommatidia, 3});
  visit(view.shares, {ommatidia, frame.truth->shares});
  visit(view.position_m, {ommatidia, 3});
  visit(view.source_distance_m, {ommatidia});
  visit(view.flow_rotation, {ommatidia, 2});
  visit(view.flow_translation, {ommatidia, 2});
  visit(view.flow_objects, {ommatidia, 2});
}

template <typename Visit>
void visit_arrays(BlockTask& view, Visit& visit, const FrameView& frame) {
  const std::int32_t ommatidia = frame.eye->ommatidium_count;
  visit.views(view.motion, {1});
  visit(view.responses, {ommatidia, frame.outputs});
  visit(view.standard_error, {ommatidia, frame.outputs});
  visit(view.rays, {ommatidia});
  visit(view.ray_radiance, {ommatidia, frame.directions->samples, frame.outputs});
  visit(view.beside_rays, {ommatidia, 1 + axis_moments, frame.outputs});
  visit.views(view.truth, {1}, frame);
}

template <typename Visit>
void visit_arrays(GatherTask& view, Visit& visit, int bands) {
  visit(view.receivers, {view.count});
  visit.views(view.shining, {1});
  visit(view.mean, {view.count, bands});
}

}  // namespace omma
