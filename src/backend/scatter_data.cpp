// Reflectances and transmittances in bands, from RGB and from spectra.
#include "backend/scatter_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "backend/texture_table.h"
#include "light/bands.h"
#include "model/scene_light.h"
#include "model/spectrum_check.h"
#include "omma/receptor.h"
#include "physics/surface/boundary_table.h"

namespace omma {
namespace {

// Weights of a colour's linear red, green and blue, and of the constant 1.
using Weights = std::array<double, 4>;

// Luminance of linear sRGB.
constexpr std::array<double, 3> luminance_weights = {0.2126, 0.7152, 0.0722};

// Reflectance at a wavelength as a function of RGB, which says nothing below the visible: there the
// caller's rule holds.
Weights rgb_weights(double wavelength_nm, const Weights& ultraviolet) {
  if (wavelength_nm < visible_from_nm) return ultraviolet;
  const std::array<double, 3> part = primary_spectra(std::min(wavelength_nm, visible_to_nm));
  return {part[0], part[1], part[2], 0};
}

// The same for a material with a table: the table times the colour's luminance over `luminance`,
// that of the colour which the table belongs to. Beyond its ends its last value is held, but in the
// ultraviolet the caller's rule.
Weights table_weights(const Spectrum& table, double luminance, double wavelength_nm,
                      double width_nm, const Weights& ultraviolet) {
  const bool known =
      wavelength_nm >= table.wavelength_nm.front() && wavelength_nm <= table.wavelength_nm.back();
  if (!known && wavelength_nm < visible_from_nm) return ultraviolet;
  const double value =
      mean_spectrum(table, wavelength_nm, width_nm, Beyond::nearest_knot) / luminance;
  return {luminance_weights[0] * value, luminance_weights[1] * value, luminance_weights[2] * value,
          0};
}

// Means over the bands of a function that gives `columns` numbers for a wavelength and the width
// about it: [band][column].
template <std::size_t columns, typename At>
std::vector<float> band_matrix(const Bands& bands, const At& at) {
  std::vector<float> matrix(bands.count() * columns);
  for (std::size_t c = 0; c < columns; ++c) {
    const std::vector<double> means =
        band_mean_of_cells(bands, [&](double nm, double width_nm) { return at(nm, width_nm)[c]; });
    for (std::size_t b = 0; b < means.size(); ++b)
      matrix[columns * b + c] = static_cast<float>(means[b]);
  }
  return matrix;
}

Weights scaled(const Weights& weights, double factor) {
  return {weights[0] * factor, weights[1] * factor, weights[2] * factor, weights[3] * factor};
}

struct Maker {
  const Scene& scene;
  const Bands& bands;
  ShadingData& shading;
  ScatterData& data;

  const float* keep(std::vector<float> matrix) const {
    data.matrices.push_back(std::move(matrix));
    return data.matrices.back().data();
  }

  std::int32_t texture(const TextureUse& use, ImageCodes codes) const {
    return find_texture(scene, shading, use.texture, {}, codes);
  }
};

void add_diffuse(const Maker& make, const Material& m, const Weights& ultraviolet,
                 ScatterView& view) {
  const auto weights = [&](const Spectrum& table, double wavelength_nm, double width_nm) {
    return table.empty()
               ? rgb_weights(wavelength_nm, ultraviolet)
               : table_weights(table, m.spectral_luminance, wavelength_nm, width_nm, ultraviolet);
  };
  // As glTF has it, what is transmitted is taken from what is reflected; spectra stand for
  // themselves.
  const bool shared = m.reflectance.empty() && m.transmittance.empty();
  // Where its factor differs from place to place, eval_spectra takes it.
  const bool varies = m.transmittance.empty() && m.diffuse_transmission_factor_texture.texture >= 0;
  const double reflected =
      shared && !varies ? 1 - static_cast<double>(m.diffuse_transmission) : 1;
  view.reflectance = make.keep(band_matrix<4>(make.bands, [&](double nm, double width_nm) {
    return scaled(weights(m.reflectance, nm, width_nm), reflected);
  }));
  if (m.transmittance.empty() && m.diffuse_transmission == 0) return;
  const double transmitted = m.transmittance.empty() && !varies ? m.diffuse_transmission : 1;
  if (varies) view.diffuse_transmission = m.diffuse_transmission;
  view.reflects_the_rest = varies && shared;
  view.transmittance = make.keep(band_matrix<4>(make.bands, [&](double nm, double width_nm) {
    return scaled(weights(m.transmittance, nm, width_nm), transmitted);
  }));
  view.transmits_base_color = !m.transmittance.empty();
  if (view.transmits_base_color) return;
  view.transmission_color = m.diffuse_transmission_color;
  view.transmission_texture = make.texture(m.diffuse_transmission_texture, ImageCodes::srgb);
}

void add_extra(const Maker& make, const ExtraReflectance& extra, ScatterView& view) {
  if (extra.texture.texture < 0) return;
  view.extra_texture = make.texture(extra.texture, ImageCodes::linear);
  std::vector<float> matrix(3 * make.bands.count());
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<double> means = band_mean(make.bands, extra.spectrum[c]);
    for (std::size_t b = 0; b < means.size(); ++b) matrix[3 * b + c] = static_cast<float>(means[b]);
  }
  view.extra = make.keep(std::move(matrix));
}

// What a volume absorbs. Below the visible, where RGB says nothing, as at 400 nm; a table's last
// values are held beyond its ends.
void add_volume(const Maker& make, const Material& m, ScatterView& view) {
  if (!refracts(m)) return;
  view.refracts = true;
  if (!m.absorption_per_m.empty()) {
    view.absorption_per_m = make.keep(band_matrix<1>(make.bands, [&](double nm, double width_nm) {
      return std::array<double, 1>{
          mean_spectrum(m.absorption_per_m, nm, width_nm, Beyond::nearest_knot)};
    }));
    return;
  }
  const Vec3 left = m.attenuation_color;
  if (left == Vec3{1, 1, 1} || std::isinf(m.attenuation_distance_m)) return;
  std::vector<float> of_bands = band_matrix<1>(make.bands, [&](double nm, double) {
    const Weights w = rgb_weights(std::max(nm, visible_from_nm), {});
    return std::array<double, 1>{w[0] * static_cast<double>(left.x) +
                                 w[1] * static_cast<double>(left.y) +
                                 w[2] * static_cast<double>(left.z)};
  });
  constexpr double black = 1e-26;  // by which all light is gone after the distance
  constexpr double most_per_m = std::numeric_limits<float>::max();
  for (float& x : of_bands)
    x = static_cast<float>(std::min(-std::log(std::clamp(static_cast<double>(x), black, 1.0)) /
                                        static_cast<double>(m.attenuation_distance_m),
                                    most_per_m));
  view.absorption_per_m = make.keep(std::move(of_bands));
}

// Means over the bands of a boundary's table: [band][element][cosine of the table].
std::vector<std::vector<double>> band_boundary(const Bands& bands, const BoundaryTable& table) {
  const auto cosines = static_cast<std::size_t>(table.cosines);
  std::vector<std::vector<double>> means(bands.count(), std::vector<double>(3 * cosines));
  Spectrum column{table.wavelength_nm, std::vector<double>(table.wavelength_nm.size())};
  for (std::size_t c = 0; c < cosines; ++c)
    for (std::size_t e = 0; e < 3; ++e) {
      for (std::size_t k = 0; k < column.value.size(); ++k)
        column.value[k] = static_cast<double>(table.mueller[3 * (cosines * k + c) + e]);
      const std::vector<double> of_bands =
          band_mean_of_cells(bands, [&](double nm, double width_nm) {
            return mean_spectrum(column, nm, width_nm, Beyond::nearest_knot);
          });
      for (std::size_t b = 0; b < of_bands.size(); ++b) means[b][cosines * e + c] = of_bands[b];
    }
  return means;
}

// Adds a table of boundary_table.h, and returns its number.
std::int32_t add_boundary(const Bands& bands, const BoundaryTable& table,
                          std::vector<float>& boundaries) {
  const std::size_t floats = 2 * static_cast<std::size_t>(boundary_pairs) * bands.count();
  const auto number = static_cast<std::int32_t>(boundaries.size() / floats);
  const int last = table.cosines - 1;
  constexpr int intervals = boundary_nodes - 1;
  for (const std::vector<double>& band : band_boundary(bands, table)) {
    double mean = 0;  // of a, straight between nodes, times twice the cosine
    for (int e = 0; e < 3; ++e) {
      const double* of_table = band.data() + static_cast<std::ptrdiff_t>(e) * table.cosines;
      const auto at_node = [&](int node) {
        const double place = static_cast<double>(node) * last / intervals;
        const int below = std::min(static_cast<int>(place), last - 1);
        const double part = place - below;
        return of_table[below] * (1 - part) + of_table[below + 1] * part;
      };
      for (int node = 0; node < boundary_nodes; ++node) {
        const double here = at_node(node), next = node < intervals ? at_node(node + 1) : here;
        boundaries.push_back(static_cast<float>(here));
        boundaries.push_back(static_cast<float>(next - here));
        if (e > 0 || node == intervals) continue;
        const double low = static_cast<double>(node) / intervals,
                     high = static_cast<double>(node + 1) / intervals;
        mean += (here * (2 * low + high) + next * (low + 2 * high)) / (3 * intervals);
      }
    }
    boundaries.push_back(static_cast<float>(mean));
    boundaries.push_back(0);
  }
  return number;
}

// The specular lobes; an unlit material has none.
void add_surface(const Maker& make, const Material& m, ScatterView& view) {
  view.specular = 0;
  if (m.unlit) return;
  view.metallic = m.metallic;
  view.roughness = m.roughness;
  view.roughness_texture = make.texture(m.metallic_roughness_texture, ImageCodes::linear);
  view.normal_texture = make.texture(m.normal_texture, ImageCodes::linear);
  view.normal_scale = m.normal_scale;
  view.ior = m.ior;
  view.specular = m.specular;
  view.transmission = m.transmission;
  if (!m.boundary.empty())
    view.boundary = add_boundary(make.bands, m.boundary, make.data.boundaries);
  view.clearcoat = m.clearcoat;
  view.clearcoat_roughness = m.clearcoat_roughness;
  view.coat_normal_scale = m.clearcoat_normal_scale;
  const Vec3 tint = m.specular_color;
  // In the ultraviolet as at 400 nm: RGB says nothing there, and nearly all specular reflection is
  // achromatic.
  const auto tint_weights = [&](double wavelength_nm, double) {
    const Weights w = rgb_weights(std::max(wavelength_nm, visible_from_nm), {});
    return std::array<double, 3>{w[0] * tint.x, w[1] * tint.y, w[2] * tint.z};
  };
  if (m.specular_color_texture.texture >= 0)
    view.tint_from_rgb = make.keep(band_matrix<3>(make.bands, tint_weights));
  else if (tint != Vec3{1, 1, 1})
    view.specular_tint = make.keep(band_matrix<1>(make.bands, [&](double nm, double width_nm) {
      const auto [red, green, blue] = tint_weights(nm, width_nm);
      return std::array<double, 1>{red + green + blue};
    }));
}

ScatterView scatter_view(const Maker& make, const Material& material, const Weights& ultraviolet) {
  ScatterView view;
  add_diffuse(make, material, ultraviolet, view);
  add_extra(make, material.extra, view);
  add_surface(make, material, view);
  add_volume(make, material, view);
  return view;
}

void lay_out(const Maker& make, const Mesh& mesh, const Material& m, const ScatterView& scatter,
             bool large, MeshView& view) {
  ShadingData& shading = make.shading;
  // Textures are mostly read with the same coordinates, which are then made once.
  std::vector<std::pair<const TextureUse*, const Vec2*>> made;
  if (view.base_uv != nullptr)
    made.emplace_back(&m.base_color_texture, reinterpret_cast<const Vec2*>(view.base_uv));
  const auto add = [&](const TextureUse& use, std::int32_t texture, const float*& uv,
                       const float*& density) {
    if (texture < 0) return;
    const auto same = std::find_if(made.begin(), made.end(), [&](const auto& one) {
      TextureUse other = *one.first;
      other.texture = use.texture;
      return other == use;
    });
    const Vec2* uvs =
        same == made.end() ? texture_coordinates(mesh, use, large, shading) : same->second;
    if (same == made.end()) made.emplace_back(&use, uvs);
    uv = &uvs->x;
    density = texel_densities(mesh, uvs, texture, large, shading);
  };
  add(m.metallic_roughness_texture, scatter.roughness_texture, view.roughness_uv,
      view.roughness_density);
  add(m.normal_texture, scatter.normal_texture, view.normal_uv, view.normal_density);
  add(m.diffuse_transmission_texture, scatter.transmission_texture, view.transmission_uv,
      view.transmission_density);
  add(m.extra.texture, scatter.extra_texture, view.extra_uv, view.extra_density);

  FactorTextures factors;
  bool any = false;
  const auto add_factor = [&](const TextureUse& use, TextureRead& read, ImageCodes codes,
                              AlphaMode alpha = {}) {
    read.texture = find_texture(make.scene, shading, use.texture, alpha, codes);
    add(use, read.texture, read.uv, read.density);
    any |= read.texture >= 0;
  };
  // Where alpha is blended, coarser levels hold its mean.
  constexpr AlphaMode mean_alpha = AlphaMode::blend;
  if (scatter.diffuse_transmission > 0)
    add_factor(m.diffuse_transmission_factor_texture, factors.diffuse_transmission,
               ImageCodes::linear, mean_alpha);
  if (!m.unlit) {
    add_factor(m.specular_texture, factors.specular, ImageCodes::linear, mean_alpha);
    add_factor(m.transmission_texture, factors.transmission, ImageCodes::linear);
    add_factor(m.clearcoat_texture, factors.coat, ImageCodes::linear);
    add_factor(m.clearcoat_roughness_texture, factors.coat_roughness, ImageCodes::linear);
    if (m.clearcoat > 0)
      add_factor(m.clearcoat_normal_texture, factors.coat_normal, ImageCodes::linear);
    add_factor(m.specular_color_texture, factors.specular_color, ImageCodes::srgb);
  }
  if (!any) return;
  make.data.factors.push_back(factors);
  view.factors = &make.data.factors.back();
}

// Whether a table says all between two wavelengths.
template <typename Table>
bool covers(const Table& table, double from_nm, double to_nm) {
  return !table.empty() && table.wavelength_nm.front() <= from_nm &&
         table.wavelength_nm.back() >= to_nm;
}

}  // namespace

std::unique_ptr<ScatterData> make_scatter_data(const Scene& scene, const Light& light,
                                               ShadingData& shading) {
  auto data = std::make_unique<ScatterData>();
  const Maker make{scene, light.bands, shading, *data};
  const auto ultraviolet = [&](std::size_t material) {
    return material < light.ultraviolet.size() ? light.ultraviolet[material] : Weights{};
  };
  for (std::size_t i = 0; i < scene.materials.size(); ++i)
    data->materials.push_back(scatter_view(make, scene.materials[i], ultraviolet(i)));
  Material usual;  // of glTF: a white, rough metal
  usual.metallic = 1;
  data->materials.push_back(scatter_view(make, usual, ultraviolet(scene.materials.size())));

  const bool large = is_large(scene);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    MeshView& view = shading.meshes[i];
    if (!mesh.normals.empty()) view.normals = &mesh.normals.data()->x;
    if (mesh.material < 0) continue;
    const auto material = static_cast<std::size_t>(mesh.material);
    lay_out(make, mesh, scene.materials[material], data->materials[material], large, view);
  }
  shading.view.textures = shading.textures.data();
  shading.view.texture_count = static_cast<std::int32_t>(shading.textures.size());
  return data;
}

std::vector<int> materials_without_ultraviolet(const Scene& scene, const Bands& bands) {
  std::vector<double> sampled_nm;
  const std::size_t samples = bands.wavelength_nm.size();
  for (std::size_t s = 0; s < samples; ++s) {
    bool used = false;
    for (std::size_t b = 0; b < bands.count(); ++b) used |= bands.weight[b * samples + s] > 0;
    if (used && bands.wavelength_nm[s] < visible_from_nm)
      sampled_nm.push_back(bands.wavelength_nm[s]);
  }
  if (sampled_nm.empty()) return {};
  const auto is_known = [&](const auto& table) {
    return covers(table, sampled_nm.front(), sampled_nm.back());
  };
  std::set<int> in_use, found;
  for (const Instance& instance : scene.instances)
    in_use.insert(scene.meshes[static_cast<std::size_t>(instance.mesh)].material);
  for (const int index : in_use) {
    const Material material =
        index < 0 ? Material{} : scene.materials[static_cast<std::size_t>(index)];
    const bool transmits = !material.transmittance.empty() || material.diffuse_transmission > 0;
    const bool all_metal =
        material.metallic == 1 && material.metallic_roughness_texture.texture < 0;
    const bool absorbs = refracts(material) && (!material.absorption_per_m.empty() ||
                                                material.attenuation_color != Vec3{1, 1, 1});
    const bool base_known = is_known(material.reflectance) &&
                            (!transmits || is_known(material.transmittance)) &&
                            (!absorbs || is_known(material.absorption_per_m));
    const bool known = material.boundary.empty()
                           ? base_known
                           : is_known(material.boundary) && (all_metal || base_known);
    if (!known) found.insert(index);
  }
  return {found.begin(), found.end()};
}

}  // namespace omma
