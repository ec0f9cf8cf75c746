// Ommatidial properties of OCES files: one value for all, numbers from an accessor, or a texture.
#include <algorithm>
#include <cmath>

#include "io/csv_text.h"
#include "io/gltf_schema.h"
#include "io/gltf_textures.h"
#include "io/oces_file.h"
#include "omma/error.h"

namespace omma {

using nlohmann::json;

namespace {

const json empty_object = json::object();

[[noreturn]] void fail(const std::string& place, const std::string& expected, const json& found) {
  throw Error(place + ": expected " + expected + ", found " +
              shown_text(found.dump(-1, ' ', true)));
}

void read_coarse(OcesProperty& property, const json& value) {
  property.coarse = true;
  if (value.is_number()) {
    property.values.push_back(oces_number(value, property.place));
    return;
  }
  if (!value.is_array() || value.empty())
    fail(property.place + ": value", "a number or an array of numbers", value);
  for (const json& element : value) {
    if (!element.is_array()) {
      property.values.push_back(oces_number(element, property.place));
      continue;
    }
    for (const json& number : element)
      property.values.push_back(oces_number(number, property.place));
  }
  property.components = property.values.size();
  if (property.components == 0) fail(property.place + ": value", "numbers", value);
}

void read_elements(OcesFile& file, OcesProperty& property, const json& description) {
  const json* stride_value = oces_member(description, "dataStride");
  std::uint64_t stride = 1;
  if (stride_value != nullptr) {
    stride = gltf_whole_number(*stride_value).value_or(0);
    if (stride < 1 || stride > 65536)
      fail(property.place + ": dataStride", "a whole number from 1 to 65536", *stride_value);
  }
  GltfAccessor accessor;
  property.values =
      read_oces_accessor(file, description["value"], accessor, property.place + ": value");
  if (accessor.count % stride != 0)
    throw Error(property.place + ": its accessor has " + std::to_string(accessor.count) +
                " elements, expected a multiple of dataStride (" + std::to_string(stride) + ")");
  property.components = accessor.components * stride;
}

// The bytes of a texture's image as they are stored, 0 to 1.
OcesImage read_image(OcesFile& file, int texture, const std::string& place) {
  OcesImage result;
  const Image image = read_gltf_texture(file.gltf, texture, place, result.sampling);
  result.width = image.width;
  result.height = image.height;
  const auto texels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  file.gltf.budget.spend(texels, 4 * sizeof(float));
  result.rgba.resize(texels * 4);
  for (std::size_t i = 0; i < result.rgba.size(); ++i) {
    if (!image.rgba_srgb8.empty()) {
      result.rgba[i] = static_cast<float>(image.rgba_srgb8[i]) / 255.0f;
    } else {
      // Numbers, not colours: back to what 16 bit stored (IEC 61966-2-1).
      const double linear = image.rgba_linear[i];
      const bool alpha = i % 4 == 3;
      result.rgba[i] =
          static_cast<float>(alpha                 ? linear
                             : linear <= 0.0031308 ? linear * 12.92
                                                   : 1.055 * std::pow(linear, 1 / 2.4) - 0.055);
    }
  }
  result.grey = true;
  for (std::size_t t = 0; t < texels && result.grey; ++t)
    result.grey = result.rgba[4 * t] == result.rgba[4 * t + 1] &&
                  result.rgba[4 * t] == result.rgba[4 * t + 2];
  return result;
}

// One number for all components, or one for each; how many there are, 1 for none.
std::size_t read_texture_numbers(const json& description, const char* name,
                                 std::array<double, 4>& numbers, const std::string& place) {
  const json* value = oces_member(description, name);
  if (value == nullptr) return 1;
  if (value->is_number()) {
    numbers.fill(oces_number(*value, place + ": " + name));
    return 1;
  }
  if (!value->is_array() || value->size() < 2 || value->size() > 4)
    fail(place + ": " + name, "a number or 2 to 4 numbers", *value);
  for (std::size_t i = 0; i < value->size(); ++i)
    numbers[i] = oces_number((*value)[i], place + ": " + name);
  return value->size();
}

void read_texture(OcesFile& file, OcesProperty& property, const json& description) {
  const int texture =
      oces_index(description["value"], gltf_list(file.gltf.document, "textures").size(), "textures",
                 property.place + ": value");
  auto found = file.images.find(texture);
  if (found == file.images.end())
    found = file.images.emplace(texture, read_image(file, texture, property.place)).first;
  property.image = &found->second;
  const std::size_t scales =
      read_texture_numbers(description, "textureScale", property.scale, property.place);
  const std::size_t centers =
      read_texture_numbers(description, "textureCenter", property.center, property.place);
  if (scales > 1 && centers > 1 && scales != centers)
    throw Error(property.place +
                ": expected as many numbers in textureScale as in textureCenter, "
                "found " +
                std::to_string(scales) + " and " + std::to_string(centers));
  // A PNG does not say whether its channels are one number or three; its texels do.
  property.components = std::max(scales, centers);
  if (property.components == 1 && !property.image->grey) property.components = 3;
}

// Texel indices and weight on one side of a coordinate.
struct Between {
  int low, high;
  double share;  // weight of the high one
};

int wrapped(int i, int size, Wrap wrap) {
  if (wrap == Wrap::clamp_to_edge) return std::clamp(i, 0, size - 1);
  if (wrap == Wrap::repeat) return ((i % size) + size) % size;
  const int j = ((i % (2 * size)) + 2 * size) % (2 * size);
  return j < size ? j : 2 * size - 1 - j;
}

Between between(double coordinate, int size, Wrap wrap, Filter filter) {
  // A coordinate may be anything; what is far out lies at a whole number of turns.
  coordinate = std::fmod(coordinate, 1024.0) * size;
  if (filter == Filter::nearest) {
    const int i = wrapped(static_cast<int>(std::floor(coordinate)), size, wrap);
    return {i, i, 0};
  }
  const double low = std::floor(coordinate - 0.5);
  return {wrapped(static_cast<int>(low), size, wrap),
          wrapped(static_cast<int>(low) + 1, size, wrap), coordinate - 0.5 - low};
}

}  // namespace

const json* oces_member(const json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

bool oces_flag(const json& object, const char* name, bool otherwise, const std::string& place) {
  const json* value = oces_member(object, name);
  if (value == nullptr) return otherwise;
  if (!value->is_boolean()) fail(place + ": " + name, "true or false", *value);
  return value->get<bool>();
}

std::string oces_text(const json& object, const char* name, const std::string& place) {
  const json* value = oces_member(object, name);
  if (value == nullptr) return "";
  if (!value->is_string()) fail(place + ": " + name, "a text", *value);
  return value->get<std::string>();
}

double oces_number(const json& value, const std::string& place) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) fail(place, "a number", value);
  return value.get<double>();
}

int oces_index(const json& value, std::size_t count, const char* what, const std::string& place) {
  if (gltf_whole_number(value).value_or(count) >= count)
    fail(place, std::string("an index into ") + what + " (" + std::to_string(count) + " there)",
         value);
  return value.get<int>();
}

const json& oces_element(const OcesFile& file, const char* list, const json& index,
                         const std::string& place) {
  const json* elements = oces_member(file.extension(), list);
  const std::size_t count = elements == nullptr || !elements->is_array() ? 0 : elements->size();
  const int i = oces_index(index, count, list, place);
  const json& element = (*elements)[static_cast<std::size_t>(i)];
  if (!element.is_object())
    fail(file.gltf.path + ": OCES_eyes." + list + "[" + std::to_string(i) + "]", "an object",
         element);
  return element;
}

const json& oces_extras(const json& object) {
  const json* extras = oces_member(object, "extras");
  if (extras == nullptr || !extras->is_object()) return empty_object;
  const json* own = oces_member(*extras, "omma");
  return own == nullptr || !own->is_object() ? empty_object : *own;
}

std::vector<double> read_oces_accessor(OcesFile& file, const json& index, GltfAccessor& accessor,
                                       const std::string& place) {
  const std::size_t there = gltf_list(file.gltf.document, "accessors").size();
  accessor = read_accessor(file.gltf, oces_index(index, there, "accessors", place), place);
  if (accessor.count == 0) throw Error(accessor.place + ": has no elements, used by " + place);
  file.gltf.budget.spend(accessor.count, accessor.components * sizeof(double));
  std::vector<double> values(accessor.count * accessor.components);
  read_doubles(accessor, values);
  return values;
}

OcesProperty read_oces_property(OcesFile& file, const json& index, bool allows_accessor,
                                bool allows_texture, const std::string& place) {
  const json& description = oces_element(file, "ommatidialProperties", index, place);
  OcesProperty property;
  property.place = place + " (ommatidialProperties[" + std::to_string(index.get<int>()) + "])";
  const std::string type = oces_text(description, "type", property.place);
  const std::string allowed = std::string(allows_accessor ? "ACCESSOR, " : "") +
                              (allows_texture ? "TEXTURE or " : "") + "COARSE";
  if (!description.contains("value")) throw Error(property.place + ": value: is missing");
  if (type == "COARSE")
    read_coarse(property, description["value"]);
  else if (type == "ACCESSOR" && allows_accessor)
    read_elements(file, property, description);
  else if (type == "TEXTURE" && allows_texture)
    read_texture(file, property, description);
  else
    throw Error(property.place + ": type: expected " + allowed + ", found " + shown_text(type));
  if (property.coarse)  // many eyes may name one property
    file.gltf.budget.spend(property.values.size(), sizeof(double));
  return property;
}

std::size_t oces_element_count(const OcesProperty& property) {
  return property.coarse || property.image ? 1 : property.values.size() / property.components;
}

void oces_value(const OcesProperty& property, const OcesSite& site, double* out) {
  if (property.coarse) {
    std::copy(property.values.begin(), property.values.end(), out);
    return;
  }
  if (property.image == nullptr) {
    for (std::size_t c = 0; c < property.components; ++c) {
      out[c] = 0;
      for (std::size_t k = 0; k < 3; ++k)
        if (site.weight[k] != 0)
          out[c] += site.weight[k] * property.values[site.vertex[k] * property.components + c];
    }
    return;
  }
  const OcesImage& image = *property.image;
  const Between x = between(site.u, image.width, image.sampling.wrap_u, image.sampling.filter);
  const Between y = between(site.v, image.height, image.sampling.wrap_v, image.sampling.filter);
  const auto texel = [&](int column, int row, std::size_t c) {
    const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                    static_cast<std::size_t>(column);
    return static_cast<double>(image.rgba[4 * at + c]);
  };
  for (std::size_t c = 0; c < property.components; ++c) {
    const double top = texel(x.low, y.low, c) * (1 - x.share) + texel(x.high, y.low, c) * x.share;
    const double bottom =
        texel(x.low, y.high, c) * (1 - x.share) + texel(x.high, y.high, c) * x.share;
    const double value = top * (1 - y.share) + bottom * y.share;
    out[c] = (value - property.center[c]) * property.scale[c];
  }
}

double oces_scalar(const OcesProperty& property, const OcesSite& site) {
  if (property.components != 1)
    throw Error(property.place + ": expected one number for an ommatidium, found " +
                std::to_string(property.components));
  double value = 0;
  oces_value(property, site, &value);
  return value;
}

}  // namespace omma
