// KHR_lights_punctual, in and out, with a spectrum in the light's extras.
#include "io/gltf_lights.h"

#include <array>
#include <utility>

#include "io/csv_text.h"
#include "io/gltf_spectra.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

constexpr std::array<std::pair<const char*, PunctualLightType>, 3> types = {
    {{"directional", PunctualLightType::directional},
     {"point", PunctualLightType::point},
     {"spot", PunctualLightType::spot}}};

PunctualLightType read_type(const std::string& word, const std::string& place) {
  for (const auto& [name, type] : types)
    if (word == name) return type;
  throw Error(place + ": type: expected directional, point or spot, found " + shown_text(word));
}

void read_cones(const json& light, PunctualLight& made) {
  static const json none = json::object();
  const auto spot = light.find("spot");
  const json& cones = spot == light.end() ? none : *spot;
  made.inner_cone_rad = cones.value("innerConeAngle", 0.0);
  made.outer_cone_rad = cones.value("outerConeAngle", pi / 4);
  // The extension wants an inner cone that is smaller. Exporters write equal ones for a sharp edge:
  // then it is a thousandth wide.
  if (made.inner_cone_rad == made.outer_cone_rad) made.inner_cone_rad *= 0.999;
}

}  // namespace

void read_light(GltfContainer& gltf, const GltfNode& node, const Mat4& world_from_node,
                Scene& scene) {
  const json& extension = gltf_extension(gltf.document, lights_extension);
  const std::size_t count = extension.empty() ? 0 : extension["lights"].size();
  if (static_cast<std::size_t>(node.light) >= count)
    throw Error(node.place + ": refers to light " + std::to_string(node.light) + ", there are " +
                std::to_string(count));
  const json& light = extension["lights"][static_cast<std::size_t>(node.light)];
  const std::string inside = gltf.path + ": light " + std::to_string(node.light) + gltf_name(light);
  PunctualLight made;
  made.name = node.name.empty() ? light.value("name", "") : node.name;
  made.type = read_type(light["type"].get<std::string>(), inside);
  if (light.contains("color")) made.color = gltf_vec3(light["color"]);
  made.intensity = light.value("intensity", 1.0);
  made.range_m = light.value("range", 0.0);
  if (made.type == PunctualLightType::spot) read_cones(light, made);
  made.world_from_light = world_from_node;
  made.spectrum = read_spectrum(omma_extras(light), "spectrum");
  gltf.budget.spend(1, sizeof(PunctualLight) + made.name.size() +
                           2 * sizeof(double) * made.spectrum.wavelength_nm.size());
  scene.lights.push_back(std::move(made));
}

json written_light(const PunctualLight& light) {
  json made = {{"color", {light.color.x, light.color.y, light.color.z}},
               {"intensity", light.intensity}};
  for (const auto& [name, type] : types)
    if (light.type == type) made["type"] = name;
  if (light.range_m > 0) made["range"] = light.range_m;
  if (light.type == PunctualLightType::spot)
    made["spot"] = {{"innerConeAngle", light.inner_cone_rad},
                    {"outerConeAngle", light.outer_cone_rad}};
  if (!light.spectrum.empty())
    made["extras"]["omma"]["spectrum"] = written_spectrum(light.spectrum);
  return made;
}

}  // namespace omma
