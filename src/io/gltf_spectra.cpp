// Spectra in extras: two arrays of numbers.
#include "io/gltf_spectra.h"

namespace omma {

using nlohmann::json;

const json& omma_extras(const json& object) {
  static const json none = json::object();
  const auto extras = object.find("extras");
  if (extras == object.end()) return none;
  const auto said = extras->find("omma");
  return said == extras->end() ? none : *said;
}

Spectrum read_spectrum(const json& spectrum) {
  if (!spectrum.is_object()) return {};
  return {spectrum["wavelength_nm"].get<std::vector<double>>(),
          spectrum["value"].get<std::vector<double>>()};
}

Spectrum read_spectrum(const json& parent, std::string_view name) {
  const auto found = parent.find(name);
  return found == parent.end() ? Spectrum{} : read_spectrum(*found);
}

json written_spectrum(const Spectrum& spectrum) {
  if (spectrum.empty()) return nullptr;
  return {{"wavelength_nm", spectrum.wavelength_nm}, {"value", spectrum.value}};
}

}  // namespace omma
