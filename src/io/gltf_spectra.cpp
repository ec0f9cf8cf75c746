// Spectra in extras: two arrays of numbers.
#include "io/gltf_spectra.h"

#include <algorithm>

#include "io/csv_text.h"
#include "omma/error.h"

namespace omma {

using nlohmann::json;

const json& omma_extras(const json& object, const std::string& place,
                        std::initializer_list<std::string_view> known) {
  static const json none = json::object();
  const auto extras = object.find("extras");
  if (extras == object.end()) return none;
  const auto said = extras->find("omma");
  if (said == extras->end()) return none;
  for (const auto& [name, value] : said->items()) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string names;
    for (const std::string_view one : known)
      names += (names.empty() ? "" : ", ") + std::string(one);
    throw Error(place + ": extras: omma: expected " + names + ", found " + shown_text(name));
  }
  return *said;
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
