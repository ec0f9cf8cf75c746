// A Light and what shines in a Scene turned into the flat arrays that the physics reads. Shared by
// all backends.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include <oneapi/tbb/cache_aligned_allocator.h>

#include "backend/light_tree_data.h"
#include "model/scene_place.h"
#include "omma/light.h"
#include "omma/scene.h"
#include "physics/views/light_view.h"
#include "physics/views/scene_view.h"

namespace omma {

// A table whose rows, where they are of 16 floats, are lines of a processor's cache: they are fetched
// as such (fetch_sky_nodes).
using RowTable = std::vector<float, tbb::cache_aligned_allocator<float>>;

// Owns what its `view` points to. Not to be copied: the views are addresses.
struct LightData {
  LightData() = default;
  LightData(const LightData&) = delete;
  LightData& operator=(const LightData&) = delete;

  std::shared_ptr<const CloudShadow> clouds;  // its optical depths are read where they are
  std::shared_ptr<const SkyMap> sky;  // its radiance is read where it is, but for a polarised one's:
  RowTable sky_intensity, sky_polarisation;  // I, and Q with U, as SkyView has them
  std::vector<float> band_from_channel, one_minus_sine, row_sum, column_sum, cell_density;
  std::vector<std::uint16_t> row_guide, column_guide;
  std::vector<float> extinction_per_m;  // [band]
  std::vector<DiscView> discs;
  std::vector<float> disc_radiance, disc_limb;  // [disc][band]
  std::vector<LampView> lamps;
  std::vector<std::size_t> lamp_of_scene;  // [lamp], index into Scene::lights
  std::vector<float> lamp_strength;        // [lamp][band]
  std::vector<double> lamp_weight;         // [lamp], see TreeLight
  double lamp_distance_m = 1;              // at which they are
  LightTree lamp_tree;
  std::vector<EmissiveView> emissive;
  std::vector<double> emissive_weight;                          // [emissive]
  std::map<std::int32_t, std::vector<double>> triangle_powers;  // of meshes that shine
  std::map<std::int32_t, LightTree> triangle_tree;              // in their own frames
  LightTree emissive_tree;
  std::vector<std::int32_t> emissive_of_instance;
  std::array<std::vector<float>, 3> sent;  // [kind][band], KindView's: from afar, lamps, surfaces
  std::vector<AimView> aims;
  LightView view;
  // The unit of radiance along rays, a power of two near the usual radiance: squares of absolute
  // radiances, 10^18 and more, then stay in single precision.
  double radiance_unit = 1;
};

// Of a validated light and scene, in the light's unit. `view` is of the scene's shading data, with
// `scatter` set, as emission in bands is asked of it.
std::unique_ptr<LightData> make_light_data(const Light& light, const Scene& scene,
                                           const Placement& placement, const SceneView& view);

// Drops Q and U of the sky.
void keep_intensity_alone(LightData& data);

// Divides all radiance by `radiance_unit`, but for that of surfaces, which is the caller's; what
// lights are chosen by, KindView and LampView::power, is in this unit from the beginning. To be
// called once.
void scale_to_radiance_unit(LightData& data);

// Lamps and shadows of clouds in a frame with this origin, which LightView::lamp_origin_m places in
// the traced one.
void place_lamps(LightData& data, const Scene& scene, Vec3d origin_m);

// What linear RGB of a material's emissive factor times texture is in each band, [band][3], in the
// light's unit (ScatterView::emission); empty where it does not shine.
std::vector<float> make_emission_matrix(const Light& light, const Material& material);

// What a linear 1 of each channel of splats is in each band, [band][channel], in the light's unit:
// as white emission is, of the channel's wavelengths (SplatCloud::bands_nm), or red, green and blue.
std::vector<float> make_splat_emission(const Light& light,
                                       const std::vector<std::array<double, 2>>& bands_nm);

// Throws omma::Error where a material shines more brightly than anything may.
void check_emission(const Light& light, const Scene& scene);

}  // namespace omma
