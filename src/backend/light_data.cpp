// Flattens a validated Light for the physics: lamps, and what each kind of light sends. Light from
// afar: backend/sky_data; surfaces that shine: backend/emissive_data.
#include "backend/light_data.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>

#include "backend/emissive_data.h"
#include "backend/light_aims.h"
#include "backend/sky_data.h"
#include "light/bands.h"
#include "light/check_light.h"
#include "model/scene_light.h"
#include "omma/error.h"

namespace omma {
namespace {

// Relative luminance of linear sRGB (IEC 61966-2-1).
constexpr std::array<double, 3> luminance = {0.2126, 0.7152, 0.0722};

// Of a lamp, per sr or where directional per m^2, in the light's unit, [band].
std::vector<double> lamp_strength(const Light& light, const PunctualLight& lamp) {
  if (!lamp.spectrum.empty()) return band_mean_of_watts(light.bands, light.unit, lamp.spectrum);
  const auto per_lumen = primaries_per_lumen(light.bands, light.unit);
  std::vector<double> strength;
  for (const auto& rgb : per_lumen)
    strength.push_back(lamp.intensity * (rgb[0] * static_cast<double>(lamp.color.x) +
                                         rgb[1] * static_cast<double>(lamp.color.y) +
                                         rgb[2] * static_cast<double>(lamp.color.z)));
  return strength;
}

// Nothing shines brighter than light from afar may, or sums would leave single precision.
void check_most(double most, const Scene& scene, const std::string& what, const std::string& name) {
  if (most <= most_radiance) return;
  char found[32] = "infinity";
  if (std::isfinite(most)) std::snprintf(found, sizeof found, "%.3g", most);
  throw Error((scene.path.empty() ? "scene" : scene.path) + ": " + what +
              (name.empty() ? "" : " \"" + name + "\"") +
              ": expected light of at most 1e30 per nm in the world's unit, found " + found);
}

// [band][3].
std::vector<double> emission_matrix(const Light& light, const Material& material) {
  const Vec3 factor = material.emissive;
  if (material.unlit || !(factor.x > 0 || factor.y > 0 || factor.z > 0)) return {};
  std::vector<double> matrix;
  if (material.emission.empty()) {
    for (const auto& rgb : primaries_per_lumen(light.bands, light.unit))
      for (const double x : rgb) matrix.push_back(light.emission_cd_m2 * x);
  } else {
    for (const double x : band_mean_of_watts(light.bands, light.unit, material.emission))
      for (const double y : luminance) matrix.push_back(x * y);
  }
  return matrix;
}

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// Fills in what does not depend on the origin; gives what lamps send to a surface half the scene's
// size away, [band].
std::vector<double> make_lamps(LightData& data, const Light& light, const Scene& scene,
                               double distance_m) {
  std::vector<double> sent(light.bands.count(), 0.0);
  data.lamp_distance_m = distance_m;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const PunctualLight& lamp = scene.lights[i];
    std::vector<double> strength = lamp_strength(light, lamp);
    if (!(sum_of(strength) > 0)) continue;
    LampView view;
    view.type = lamp.type;
    if (lamp.range_m > 0) view.per_range_2 = static_cast<float>(1 / (lamp.range_m * lamp.range_m));
    if (lamp.type == PunctualLightType::spot) {
      // KHR_lights_punctual's own code has a thousandth here, by which spots of less than 2.6
      // degrees are dark on their axis too; single precision knows a cosine to 6e-8.
      constexpr double least = 1e-5;
      const double outer = std::cos(lamp.outer_cone_rad);
      const double scale = 1 / std::max(least, std::cos(lamp.inner_cone_rad) - outer);
      view.cone_scale = static_cast<float>(scale);
      view.cone_offset = static_cast<float>(-outer * scale);
    }
    data.lamps.push_back(view);
    data.lamp_of_scene.push_back(i);
    const bool is_far = lamp.type == PunctualLightType::directional;
    const double most = *std::max_element(strength.begin(), strength.end());
    check_most(is_far ? most : most * std::max(1.0, 1 / (distance_m * distance_m)), scene,
               "light " + std::to_string(i), lamp.name);
    for (std::size_t b = 0; b < sent.size(); ++b) {
      data.lamp_strength.push_back(static_cast<float>(strength[b]));
      if (!is_far) strength[b] /= distance_m * distance_m;
      sent[b] += strength[b];
    }
    data.lamp_weight.push_back(sum_of(strength));
  }
  for (std::size_t i = 0; i < data.lamps.size(); ++i)
    data.lamps[i].strength = data.lamp_strength.data() + i * sent.size();
  return sent;
}

// What each kind of light sends to a place, as KindView has it, in units of the usual radiance, as
// absolute numbers of large scenes would leave single precision: what lamps and surfaces send to a
// place at `distance_m` falls with distance as the root of their tree does.
void view_kinds(LightData& data, const std::array<std::vector<double>, 3>& sent,
                double distance_m) {
  const std::size_t bands = sent[0].size();
  for (std::size_t i = 0; i < data.lamps.size(); ++i) {
    double power = 0;
    for (std::size_t b = 0; b < bands; ++b)
      power += static_cast<double>(data.lamp_strength[i * bands + b]);
    data.lamps[i].power = static_cast<float>(power / data.radiance_unit);
  }
  KindView* const kinds[3] = {&data.view.from_afar, &data.view.from_lamps,
                              &data.view.from_surfaces};
  for (std::size_t k = 0; k < 3; ++k) {
    const double scale = (k == 0 ? 1 : distance_m * distance_m) / data.radiance_unit;
    for (const double x : sent[k]) data.sent[k].push_back(static_cast<float>(x * scale));
    *kinds[k] = {data.sent[k].data(), static_cast<float>(sum_of(sent[k]) * scale)};
  }
}

// The power of two nearest to irradiance / 4 pi, the mean over bands.
double choose_radiance_unit(const std::array<std::vector<double>, 3>& sent) {
  double all = 0;
  for (const std::vector<double>& of_kind : sent) all += sum_of(of_kind);
  const double mean = all / (4 * pi * static_cast<double>(sent[0].size()));
  if (!(mean > 1e-300)) return 1;
  return std::exp2(std::clamp(std::round(std::log2(mean)), -120.0, 120.0));
}

}  // namespace

std::unique_ptr<LightData> make_light_data(const Light& light, const Scene& scene,
                                           const Placement& placement, const SceneView& view) {
  auto data = std::make_unique<LightData>();
  data->view.bands = static_cast<std::int32_t>(light.bands.count());
  data->extinction_per_m.assign(light.extinction_per_m.begin(), light.extinction_per_m.end());
  if (!light.extinction_per_m.empty())
    data->view.extinction_per_m = data->extinction_per_m.data();
  data->view.bottomless = light.bottomless;
  data->clouds = light.cloud_shadow;
  const double distance_m = std::max(placement.half_size_m, 1e-6);
  const std::array<std::vector<double>, 3> sent = {
      make_far(*data, light), make_lamps(*data, light, scene, distance_m),
      make_emissive(*data, light, scene, placement, view, distance_m)};
  place_lamps(*data, scene, placement.origin_m);

  LightView& out = data->view;
  out.lamps = data->lamps.data();
  out.lamp_count = static_cast<std::int32_t>(data->lamps.size());
  out.emissive = data->emissive.data();
  out.emissive_tree = data->emissive_tree.view();
  out.emissive_of_instance = data->emissive_of_instance.data();
  out.emissive_count = static_cast<std::int32_t>(data->emissive.size());
  out.instance_count = static_cast<std::int32_t>(data->emissive_of_instance.size());
  data->radiance_unit = choose_radiance_unit(sent);
  view_kinds(*data, sent, distance_m);
  data->aims = make_aims(*data, scene, placement, view);
  out.aims = data->aims.data();
  out.aim_count = static_cast<std::int32_t>(data->aims.size());
  constexpr double least_beside_far = 1e-6;
  out.least_aimed = static_cast<float>(least_beside_far * sum_of(sent[0]) /
                                       (4 * pi * static_cast<double>(sent[0].size())));
  return data;
}

void keep_intensity_alone(LightData& data) {
  data.view.sky.polarisation = nullptr;
  data.sky_polarisation = {};
}

void scale_to_radiance_unit(LightData& data) {
  const auto per_unit = static_cast<float>(1 / data.radiance_unit);
  data.view.sky.per_unit = per_unit;
  for (float& x : data.disc_radiance) x *= per_unit;
  for (float& x : data.lamp_strength) x *= per_unit;
  for (AimView& aim : data.aims) aim.brightest *= per_unit;
  data.view.least_aimed *= per_unit;
}

void place_lamps(LightData& data, const Scene& scene, Vec3d origin_m) {
  std::vector<TreeLight> lights;
  for (std::size_t i = 0; i < data.lamps.size(); ++i) {
    const Mat4& world_from_light = scene.lights[data.lamp_of_scene[i]].world_from_light;
    data.lamps[i].position = to_float(transform_point(world_from_light, {}) - origin_m);
    data.lamps[i].direction = to_float(normalize(transform_vector(world_from_light, {0, 0, -1})));
    TreeLight light = tree_light(to_double(data.lamps[i].position), data.lamp_weight[i],
                                 data.lamps[i].type == PunctualLightType::directional);
    const PunctualLight& lamp = scene.lights[data.lamp_of_scene[i]];
    if (lamp.range_m > 0) light.range_m = lamp.range_m;
    if (lamp.type == PunctualLightType::spot) {
      light.axis = to_double(data.lamps[i].direction);
      light.reach_rad = lamp.outer_cone_rad;
    }
    lights.push_back(light);
  }
  data.lamp_tree = make_light_tree(lights, data.lamp_distance_m);
  data.view.lamp_tree = data.lamp_tree.view();
  if (data.clouds == nullptr) return;
  const CloudShadow& clouds = *data.clouds;
  CloudShadowView& view = data.view.clouds;
  view.optical_depth = clouds.optical_depth.data();
  view.columns = clouds.columns;
  view.rows = clouds.rows;
  view.per_m = static_cast<float>(1 / clouds.spacing_m);
  view.height_m = static_cast<float>(clouds.height_m - origin_m.y);
  // Within the map, as it repeats: far from the world's origin too places keep their centimetres.
  const auto first = [&](double origin, double at, int nodes) {
    return static_cast<float>(std::fmod((origin - at) / clouds.spacing_m, nodes));
  };
  view.first_column = first(origin_m.x, clouds.first_x_m, clouds.columns);
  view.first_row = first(origin_m.z, clouds.first_z_m, clouds.rows);
}

std::vector<float> make_emission_matrix(const Light& light, const Material& material) {
  const std::vector<double> matrix = emission_matrix(light, material);
  return {matrix.begin(), matrix.end()};
}

std::vector<float> make_splat_emission(const Light& light,
                                       const std::vector<std::array<double, 2>>& bands_nm) {
  if (bands_nm.empty()) {
    Material shining;
    shining.emissive = {1, 1, 1};
    return make_emission_matrix(light, shining);
  }
  std::vector<float> matrix;
  for (const std::vector<double>& band : white_per_lumen(light.bands, light.unit, bands_nm))
    for (const double x : band) matrix.push_back(static_cast<float>(light.emission_cd_m2 * x));
  return matrix;
}

void check_emission(const Light& light, const Scene& scene) {
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    const Material& material = scene.materials[m];
    const std::vector<double> matrix = emission_matrix(light, material);
    const Vec3 rgb = brightest_emission(scene, material);
    for (std::size_t k = 0; k < matrix.size(); k += 3)
      check_most(matrix[k] * static_cast<double>(rgb.x) +
                     matrix[k + 1] * static_cast<double>(rgb.y) +
                     matrix[k + 2] * static_cast<double>(rgb.z),
                 scene, "material " + std::to_string(m), material.name);
  }
}

}  // namespace omma
