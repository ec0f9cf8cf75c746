// Checks of how surfaces scatter light, and of lamps.
#include "model/scene_light.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <vector>

#include "model/spectrum_check.h"
#include "model/text.h"
#include "omma/error.h"

namespace omma {
namespace {

// Rounding of what adds up to 1.
constexpr double slack = 1e-6;

constexpr int most_boundary_cosines = 10000;

void check_range(double value, double low, double high, const std::string& what) {
  if (!(value >= low && value <= high))
    throw Error(what + ": expected " + short_text(low) + " to " + short_text(high) + ", found " +
                short_text(value));
}

void check_fractions(Vec3 color, const std::string& what) {
  for (const float value : {color.x, color.y, color.z}) check_range(value, 0, 1, what);
}

double luminance(Vec4 color) {
  return 0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z;
}

// The largest sum of two spectra, each times a factor; one that is empty is flat at `flat`.
double largest_sum(const Spectrum& a, double a_factor, double a_flat, const Spectrum& b,
                   double b_factor, double b_flat) {
  double most = 0;
  const auto look = [&](double wavelength_nm) {
    most = std::max(most, (a.empty() ? a_flat : a_factor * held_spectrum(a, wavelength_nm)) +
                              (b.empty() ? b_flat : b_factor * held_spectrum(b, wavelength_nm)));
  };
  for (const double wavelength_nm : a.wavelength_nm) look(wavelength_nm);
  for (const double wavelength_nm : b.wavelength_nm) look(wavelength_nm);
  if (a.empty() && b.empty()) most = a_flat + b_flat;
  return most;
}

float largest_component(Vec3 color) {
  return std::max({color.x, color.y, color.z});
}

Vec3 largest_of_both(Vec3 a, Vec3 b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

// The brightest texel by each component, 1 for 8 bits and for none.
Vec3 brightest_texel(const Scene& scene, const TextureUse& use) {
  if (use.texture < 0) return {1, 1, 1};
  const Texture& texture = scene.textures[static_cast<std::size_t>(use.texture)];
  const std::vector<float>& texels =
      scene.images[static_cast<std::size_t>(texture.image)].rgba_linear;
  if (texels.empty()) return {1, 1, 1};
  Vec3 most{0, 0, 0};
  for (std::size_t i = 0; i + 3 < texels.size(); i += 4)
    most = largest_of_both(most, {texels[i], texels[i + 1], texels[i + 2]});
  return most;
}

// What the base colour of a material is at most where vertex colours are.
double largest_base_color(const Scene& scene, const Material& material, Vec3 vertex_color) {
  const Vec3 texel = brightest_texel(scene, material.base_color_texture);
  const Vec4 factor = material.base_color;
  return largest_component({factor.x * texel.x * vertex_color.x,
                            factor.y * texel.y * vertex_color.y,
                            factor.z * texel.z * vertex_color.z});
}

// What a surface of one colour, the factor, gives back at most.
double largest_return(const Material& m) {
  const Vec4 base = m.base_color;
  const double by_table = luminance(base) / static_cast<double>(m.spectral_luminance);
  const double white = std::max({base.x, base.y, base.z});
  const double transmitted = m.transmittance.empty() ? m.diffuse_transmission : 0;
  return largest_sum(m.reflectance, by_table, white * (1 - transmitted), m.transmittance, by_table,
                     transmitted * largest_component(m.diffuse_transmission_color));
}

void check_boundary(const BoundaryTable& table, const std::string& place) {
  if (table.empty() && table.cosines == 0 && table.mueller.empty()) return;
  check_spectrum({table.wavelength_nm, std::vector<double>(table.wavelength_nm.size())}, place);
  check_range(table.cosines, 2, most_boundary_cosines, place + "cosines");
  const std::size_t count =
      3 * table.wavelength_nm.size() * static_cast<std::size_t>(table.cosines);
  if (table.empty() || table.mueller.size() != count)
    throw Error(place + "mueller: expected " + std::to_string(count) + " numbers, found " +
                std::to_string(table.mueller.size()));
  for (std::size_t i = 0; i < count; i += 3) {
    const auto element = [&](std::size_t k) { return static_cast<double>(table.mueller[i + k]); };
    const double a = element(0), b = element(1), c = element(2);
    if (a >= 0 && a <= 1 + slack && b * b + c * c <= a * a + slack) continue;
    throw Error(place + "mueller: expected a from 0 to 1 and b^2 + c^2 of at most a^2, found " +
                short_text(a) + ", " + short_text(b) + " and " + short_text(c));
  }
}

void check_volume(const Material& m, const std::string& place) {
  if (!(m.thickness_m >= 0) || !std::isfinite(m.thickness_m))
    throw Error(place + "thickness_m: expected a number that is finite and not negative, found " +
                short_text(m.thickness_m));
  check_fractions(m.attenuation_color, place + "attenuation_color");
  if (!(m.attenuation_distance_m > 0))
    throw Error(place + "attenuation_distance_m: expected more than 0, found " +
                short_text(m.attenuation_distance_m));
  check_spectrum(m.absorption_per_m, place + "absorption_per_m: ");
  if (m.thickness_m > 0 && (m.metallic > 0 || m.clearcoat > 0))
    throw Error(place + "thickness_m: expected 0 of a metal or under a clear coat, found " +
                short_text(m.thickness_m));
}

}  // namespace

bool refracts(const Material& m) {
  return m.thickness_m > 0 && m.transmission > 0 && !m.unlit;
}

void check_scattering(const Material& m, const std::string& place) {
  check_range(m.metallic, 0, 1, place + "metallic");
  check_range(m.roughness, 0, 1, place + "roughness");
  if (!std::isfinite(m.normal_scale)) throw Error(place + "normal_scale: expected a finite number");
  check_range(m.ior, 1, 10, place + "ior");
  check_range(m.specular, 0, 1, place + "specular");
  check_fractions(m.specular_color, place + "specular_color");
  check_range(m.transmission, 0, 1, place + "transmission");
  check_volume(m, place);
  check_range(m.diffuse_transmission, 0, 1, place + "diffuse_transmission");
  check_fractions(m.diffuse_transmission_color, place + "diffuse_transmission_color");
  check_range(m.clearcoat, 0, 1, place + "clearcoat");
  check_range(m.clearcoat_roughness, 0, 1, place + "clearcoat_roughness");
  if (!std::isfinite(m.clearcoat_normal_scale))
    throw Error(place + "clearcoat_normal_scale: expected a finite number");
  check_spectrum(m.reflectance, place + "reflectance: ", 1);
  check_spectrum(m.transmittance, place + "transmittance: ", 1);
  if (!m.reflectance.empty() && !m.transmittance.empty()) {
    const double most = largest_sum(m.reflectance, 1, 0, m.transmittance, 1, 0);
    if (most > 1 + slack)
      throw Error(place + "reflectance and transmittance: expected at most 1 together, found " +
                  short_text(most));
  }
  if (!(m.spectral_luminance > 0) || !std::isfinite(m.spectral_luminance))
    throw Error(place + "spectral_luminance: expected more than 0, found " +
                short_text(m.spectral_luminance));
  check_spectrum(m.emission, place + "emission: ");
  check_boundary(m.boundary, place + "boundary: ");
  if (!m.boundary.empty() && m.metallic == 0)
    throw Error(place + "boundary: expected a metallic above 0, as it is how the metal reflects");
  bool any = false;
  for (const Spectrum& spectrum : m.extra.spectrum) {
    check_spectrum(spectrum, place + "extra_reflectance: ", 1);
    any |= !spectrum.empty();
  }
  if (any != (m.extra.texture.texture >= 0))
    throw Error(place + "extra_reflectance: expected a texture and spectra, found only " +
                (any ? "spectra" : "a texture"));
}

Vec3 brightest_emission(const Scene& scene, const Material& material) {
  const Vec3 texel = brightest_texel(scene, material.emissive_texture);
  const Vec3 factor = material.emissive;
  return {factor.x * texel.x, factor.y * texel.y, factor.z * texel.z};
}

void check_punctual_light(const PunctualLight& light, const std::string& place) {
  for (const float value : {light.color.x, light.color.y, light.color.z})
    if (!(value >= 0) || !std::isfinite(value))
      throw Error(place + "color: expected numbers that are finite and not negative, found " +
                  short_text(value));
  if (!(light.intensity >= 0) || !std::isfinite(light.intensity))
    throw Error(place + "intensity: expected a number that is finite and not negative, found " +
                short_text(light.intensity));
  if (!(light.range_m >= 0) || !std::isfinite(light.range_m))
    throw Error(place + "range_m: expected a number that is finite and not negative, found " +
                short_text(light.range_m));
  if (!(light.inner_cone_rad >= 0 && light.inner_cone_rad < light.outer_cone_rad &&
        light.outer_cone_rad <= pi / 2))
    throw Error(place + "cones: expected 0 <= inner < outer <= pi / 2 rad, found " +
                short_text(light.inner_cone_rad) + " and " + short_text(light.outer_cone_rad));
  check_spectrum(light.spectrum, place + "spectrum: ");
}

void check_lit_scene(const Scene& scene) {
  // The brightest vertex colours of those in use, the last of meshes without a material.
  constexpr Vec3 unused{-1, -1, -1};
  std::vector<Vec3> vertex_color(scene.materials.size() + 1, unused);
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
    Vec3& most = mesh.material < 0 ? vertex_color.back()
                                   : vertex_color[static_cast<std::size_t>(mesh.material)];
    if (mesh.colors.empty()) most = largest_of_both(most, {1, 1, 1});
    for (const Vec4 c : mesh.colors) most = largest_of_both(most, {c.x, c.y, c.z});
  }
  constexpr int most_named = 8;
  std::string found;
  int count = 0;
  const auto refuse = [&](const std::string& name, double most) {
    if (++count > most_named) return;
    found += (found.empty() ? "" : ", ") + name + " (" + short_text(most) + ")";
  };
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const Material& material = scene.materials[i];
    if (vertex_color[i] == unused) continue;
    double most = largest_base_color(scene, material, vertex_color[i]);
    if (most <= 1 + slack && material.base_color_texture.texture < 0)
      most = std::max(most, largest_return(material));
    if (most > 1 + slack)
      refuse(std::to_string(i) + (material.name.empty() ? "" : " \"" + material.name + "\""), most);
  }
  const double without = largest_component(vertex_color.back());
  if (without > 1 + slack) refuse("that of meshes without one", without);
  if (count == 0) return;
  if (count > most_named) found += " and " + std::to_string(count - most_named) + " more";
  throw Error((scene.path.empty() ? "scene" : scene.path) +
              ": materials: expected base colours, or reflectance and transmittance, of at most 1 "
              "in a world that is lit, found more in " +
              found);
}

}  // namespace omma
