// What shines, as the physics sees it: flat arrays behind pointers, the same on host and device.
// Made by backend/light_data. Directions and places are those of the traced frame, which is turned
// as the world is.
#pragma once

#include <cstdint>

#include "omma/scene_kinds.h"
#include "omma/vec.h"
#include "physics/lanes/lanes.h"
#include "physics/views/aim_view.h"
#include "physics/views/cloud_shadow_view.h"
#include "physics/views/light_tree_view.h"

namespace omma {

// omma::SkyMap, and cells between its nodes, from which directions are sampled: rows of cells are
// those above the horizon from the horizon up, then those below it from the horizon down.
struct SkyView {
  std::int32_t columns = 0, rows = 0;  // of nodes, rows of each half; 0 where the sky is dark
  std::int32_t channels = 0;
  const float* radiance = nullptr;      // I: [above, below][row][column][channel]
  const float* polarisation = nullptr;  // Q, U: [above, below][row][column][2][channel], or null
  // Whether the axes of neighbouring columns differ by so much that what lies between them is to be
  // turned first (eval_sky).
  bool turns_axes = false;
  float per_unit = 1;  // of both, in the unit of all else
  const float* band_from_channel = nullptr;  // [band][channel], or null: channels are the bands
  float columns_per_rad = 0, rows_per_rad = 0;
  const float* one_minus_sine = nullptr;  // [row], of the elevation of nodes
  // Cumulative probabilities, 0 to 1, in steps of 2^-24: of rows of cells, and of cells in each.
  const float* row_sum = nullptr;     // [row of cells + 1]
  const float* column_sum = nullptr;  // [row of cells][columns + 1]
  // The interval of j / count, for each of `count` intervals: where to begin to look for others.
  // One more lies behind each table.
  const std::uint16_t* row_guide = nullptr;     // [row of cells]
  const std::uint16_t* column_guide = nullptr;  // [row of cells][columns]
  const float* cell_density = nullptr;  // [row of cells][column], per solid angle
  float probability = 0;               // that light from afar is sampled from the sky
};

struct DiscView {
  Vec3 direction{0, 1, 0};  // unit
  // By the distance of a direction from the centre's as points of the unit sphere, squared: 2 minus
  // two cosines, which resolves discs that a cosine in single precision does not.
  float chord_2 = 0;                // of the rim
  float per_sine_2 = 0;             // 1 / sin^2 of the radius
  float density = 0;                // 1 / solid angle
  float probability = 0;            // that light from afar is sampled from it
  const float* radiance = nullptr;  // [band], at the centre
  const float* limb = nullptr;      // [band], u of omma::Disc; or null
};

// Discs larger than so many times an ommatidium's acceptance are found by its rays; smaller ones are
// asked for (eye_discs.h).
inline constexpr float most_over_acceptance = 16;

// Whether rays from the eye count the light of a disc. `acceptance_sr`: of their ommatidium, the
// integral of S; 0: they count all discs.
OMMA_HD bool counts_by_rays(const DiscView& disc, float acceptance_sr) {
  return !(most_over_acceptance * acceptance_sr * disc.density >= 1.0f);
}

struct LampView {
  PunctualLightType type = PunctualLightType::point;
  Vec3 position;                          // m
  Vec3 direction{0, 0, -1};               // unit, in which it shines
  float per_range_2 = 0;                  // 1 / range^2, m^-2; 0: without end
  float cone_scale = 0, cone_offset = 1;  // of the cosine from `direction`, of a spot
  const float* strength = nullptr;        // [band], per sr, or per m^2 where directional
  float power = 0;                        // their sum
};

// An instance whose surface shines. Its triangles are chosen by a tree in the mesh's frame, then
// places on them. Triangles whose texture shines are divided along their sides: the lights of the
// tree are their subtriangles, triangle * divisions^2 + subtriangle (emissive.h).
struct EmissiveView {
  std::int32_t instance = 0, mesh = 0;  // of the scene
  std::int32_t divisions = 1;           // of each side
  LightTreeView triangles;
};

// What a kind of light sends to a place from all around (scalar irradiance), where nothing is in
// the way: of lamps and surfaces, times what the root of their tree sends there (eval_light_node).
struct KindView {
  const float* sent = nullptr;  // [band]
  float all = 0;                // their sum; 0: there is no such light
};

struct LightView {
  std::int32_t bands = 0;
  SkyView sky;
  const float* extinction_per_m = nullptr;  // [band], of the air (path/air.h); null: it is clear
  bool bottomless = false;                  // omma::Light
  const DiscView* discs = nullptr;
  std::int32_t disc_count = 0;
  CloudShadowView clouds;  // cloud_shadow.h

  const LampView* lamps = nullptr;
  LightTreeView lamp_tree;
  // Where the origin of lamps' positions is in the traced frame, [3], m; null: at its own.
  const float* lamp_origin_m = nullptr;
  std::int32_t lamp_count = 0;

  const EmissiveView* emissive = nullptr;
  LightTreeView emissive_tree;                         // in the traced frame
  const std::int32_t* emissive_of_instance = nullptr;  // [instance of the scene], -1: none
  std::int32_t emissive_count = 0;

  const AimView* aims = nullptr;  // aims_in_view.h
  std::int32_t aim_count = 0;     // most_aims at most
  float least_aimed = 0;          // what adds less is left to rays, beside light from afar

  KindView from_afar, from_lamps, from_surfaces;
  std::int32_t instance_count = 0;  // of the scene
};

OMMA_HD bool has_near_light(const LightView& light) {
  return light.from_lamps.all > 0.0f || light.from_surfaces.all > 0.0f;
}

}  // namespace omma
