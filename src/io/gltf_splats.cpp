// Gaussian splats of glTF, read and written as KHR_gaussian_splatting has them
// (github.com/KhronosGroup/glTF, extensions/2.0/Khronos/KHR_gaussian_splatting).
#include "io/gltf_splats.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "io/csv_text.h"
#include "io/gltf_accessor.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

constexpr const char* srgb_display = "srgb_rec709_display";
constexpr const char* linear_display = "lin_rec709_display";
// What a splat is flattened to where a scale is 0.
constexpr float least_scale_m = 1e-9f;
constexpr int degrees = 4;
// KHR_gaussian_splatting has three colours; further channels of ours are numbers beside them.
constexpr std::size_t colors = 3;

std::string semantic(const char* name) {
  return std::string(splats_extension) + ":" + name;
}
// Of degree l.
std::string harmonic(int l, int number) {
  return semantic("SH_DEGREE_") + std::to_string(l) + "_COEF_" + std::to_string(number);
}
std::string channel_harmonic(std::size_t channel, int l, int number) {
  return "_CHANNEL_" + std::to_string(channel) + "_SH_DEGREE_" + std::to_string(l) + "_COEF_" +
         std::to_string(number);
}

// The terms of all degrees that the primitive has; no degree is there in part.
int count_terms(const json& attributes, const std::string& place) {
  int terms = 0;
  bool ends = false;
  for (int l = 0; l < degrees; ++l) {
    int there = 0;
    for (int n = 0; n < 2 * l + 1; ++n) there += attributes.contains(harmonic(l, n));
    if (there > 0 && (ends || there < 2 * l + 1))
      throw Error(place + ": expected all harmonics of each degree up to the last, found " +
                  std::to_string(there) + " of degree " + std::to_string(l) +
                  (ends ? " without those of the degree before" : ""));
    ends = ends || there == 0;
    if (!ends) terms += there;
  }
  if (terms == 0) throw Error(place + ": " + harmonic(0, 0) + ": is missing");
  return terms;
}

struct Reader {
  GltfContainer& gltf;
  const json& attributes;
  const std::string& place;
  std::size_t count = 0;

  // Of all splats, `components` numbers each.
  std::vector<float> floats(const std::string& name, std::size_t components) {
    const auto found = attributes.find(name);
    if (found == attributes.end()) throw Error(place + ": " + name + ": is missing");
    const std::string inside = place + ", " + name;
    const GltfAccessor accessor = read_accessor(gltf, found->get<int>(), inside);
    if (accessor.matrix || accessor.components != components)
      throw Error(inside + ": " + accessor.place + " has " + std::to_string(accessor.components) +
                  " components, expected " + std::to_string(components));
    if (name == "POSITION") count = accessor.count;
    if (accessor.count != count)
      throw Error(inside + ": has " + std::to_string(accessor.count) + " elements, POSITION has " +
                  std::to_string(count));
    gltf.budget.spend(count, components * sizeof(float));
    std::vector<float> values(count * components);
    if (count > 0) read_floats(accessor, {}, components, values.data());
    return values;
  }
};

template <typename Vector>
std::vector<Vector> vectors(const std::vector<float>& values) {
  const auto* first = reinterpret_cast<const Vector*>(values.data());
  return {first, first + values.size() * sizeof(float) / sizeof(Vector)};
}

// Drafts of the extension had logarithms, of which those of trained splats are below 0.
void take_scales(std::vector<float> values, const std::string& place, GltfWarnings& warnings,
                 SplatCloud& cloud) {
  const bool is_draft = std::any_of(values.begin(), values.end(), [](float s) { return s < 0; });
  if (is_draft)
    warnings.add("scales of Gaussian splats below 0 are taken for logarithms, which drafts of " +
                     std::string(splats_extension) + " had",
                 place);
  for (float& s : values) s = std::max(is_draft ? std::exp(s) : s, least_scale_m);
  cloud.scales = vectors<Vec3>(values);
}

// Those of length 1 but for rounding stay as they are, so that what was saved is what is loaded.
void take_rotations(std::vector<float> values, SplatCloud& cloud) {
  constexpr float rounding = 1e-6f;
  cloud.rotations = vectors<Vec4>(values);
  for (Vec4& q : cloud.rotations) {
    const float length = std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w));
    if (length > 0 && std::fabs(length - 1) > rounding)
      q = {q.x / length, q.y / length, q.z / length, q.w / length};
  }
}

void take_harmonics(Reader& reader, SplatCloud& cloud) {
  cloud.terms = count_terms(reader.attributes, reader.place);
  const std::size_t channels = channels_of(cloud);
  const auto terms = static_cast<std::size_t>(cloud.terms);
  reader.gltf.budget.spend(reader.count, channels * terms * sizeof(float));
  cloud.harmonics.resize(channels * terms * reader.count);
  std::size_t term = 0;
  const auto take = [&](const std::string& name, std::size_t first, std::size_t count) {
    const std::vector<float> values = reader.floats(name, count);
    for (std::size_t i = 0; i < reader.count; ++i)
      for (std::size_t c = 0; c < count; ++c)
        cloud.harmonics[channels * (i * terms + term) + first + c] = values[count * i + c];
  };
  for (int l = 0; term < terms; ++l)
    for (int n = 0; n < 2 * l + 1; ++n, ++term) {
      take(harmonic(l, n), 0, colors);
      for (std::size_t c = colors; c < channels; ++c) take(channel_harmonic(c, l, n), c, 1);
    }
}

// Of the extension's extras, where Omma has put what the extension cannot say.
void take_extras(const json& extras, const std::string& place, SplatCloud& cloud) {
  if (extras.contains("direction") && extras["direction"] == "ray")
    cloud.direction = SplatDirection::ray;
  if (extras.contains("bands_nm")) {
    const auto ends = extras["bands_nm"].get<std::vector<double>>();
    if (ends.size() % 2 != 0 || ends.size() < 2 * colors || ends.size() > 2 * most_splat_channels)
      throw Error(place + ": bands_nm: expected two numbers for each of 3 to " +
                  std::to_string(most_splat_channels) + " channels, found " +
                  std::to_string(ends.size()));
    for (std::size_t i = 0; i < ends.size(); i += 2)
      cloud.bands_nm.push_back({ends[i], ends[i + 1]});
    cloud.white.assign(ends.size() / 2, 1.0f);
  }
  if (extras.contains("white")) cloud.white = extras["white"].get<std::vector<float>>();
}

}  // namespace

bool has_splats(const json& primitive) {
  return !gltf_extension(primitive, splats_extension).empty();
}

SplatCloud read_gltf_splats(GltfContainer& gltf, const json& primitive, const std::string& place,
                            GltfWarnings& warnings) {
  const json& extension = gltf_extension(primitive, splats_extension);
  const int mode = primitive.value("mode", 4);
  if (mode != 0)
    throw Error(place + ": mode: expected 0, points, with " + splats_extension + ", found " +
                std::to_string(mode));
  const std::string kernel = extension["kernel"].get<std::string>();
  if (kernel != "ellipse")
    warnings.add("the kernel " + shown_text(kernel) +
                     " of Gaussian splats is not known; an ellipse is taken, as the extension says",
                 place);
  SplatCloud cloud;
  const std::string space = extension["colorSpace"].get<std::string>();
  if (space != srgb_display && space != linear_display)
    throw Error(place + ": colorSpace: expected " + srgb_display + " or " + linear_display +
                ", found " + shown_text(space));
  cloud.color_space = space == linear_display ? SplatColor::linear : SplatColor::srgb;
  if (extension.contains("extras")) take_extras(extension["extras"], place, cloud);

  Reader reader{gltf, primitive["attributes"], place};
  cloud.positions = vectors<Vec3>(reader.floats("POSITION", 3));
  take_scales(reader.floats(semantic("SCALE"), 3), place, warnings, cloud);
  take_rotations(reader.floats(semantic("ROTATION"), 4), cloud);
  cloud.opacities = reader.floats(semantic("OPACITY"), 1);
  take_harmonics(reader, cloud);
  return cloud;
}

json written_splats(GltfWriter& writer, const SplatCloud& cloud) {
  writer.use_extension(splats_extension);
  json attributes;
  const int positions = writer.floats(cloud.positions);
  // glTF asks for the bounds of positions (3.7.2.1).
  Vec3 lower = cloud.positions.front(), upper = lower;
  for (const Vec3 p : cloud.positions) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  writer.document["accessors"][static_cast<std::size_t>(positions)]["min"] = numbers(lower);
  writer.document["accessors"][static_cast<std::size_t>(positions)]["max"] = numbers(upper);
  attributes["POSITION"] = positions;
  attributes[semantic("SCALE")] = writer.floats(cloud.scales);
  attributes[semantic("ROTATION")] = writer.floats(cloud.rotations);
  attributes[semantic("OPACITY")] = writer.floats(cloud.opacities);
  const std::size_t channels = channels_of(cloud);
  const auto terms = static_cast<std::size_t>(cloud.terms);
  std::size_t term = 0;
  for (int l = 0; term < terms; ++l)
    for (int n = 0; n < 2 * l + 1; ++n, ++term) {
      const auto number = [&](std::size_t i, std::size_t c) {
        return cloud.harmonics[channels * (i * terms + term) + c];
      };
      std::vector<Vec3> values(cloud.positions.size());
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = {number(i, 0), number(i, 1), number(i, 2)};
      attributes[harmonic(l, n)] = writer.floats(values);
      for (std::size_t c = colors; c < channels; ++c) {
        std::vector<float> one(cloud.positions.size());
        for (std::size_t i = 0; i < one.size(); ++i) one[i] = number(i, c);
        attributes[channel_harmonic(c, l, n)] = writer.floats(one);
      }
    }
  json extension = {
      {"kernel", "ellipse"},
      {"colorSpace", cloud.color_space == SplatColor::linear ? linear_display : srgb_display}};
  if (cloud.direction == SplatDirection::ray) extension["extras"]["direction"] = "ray";
  if (!cloud.bands_nm.empty()) {
    json ends = json::array();
    for (const auto& [from_nm, to_nm] : cloud.bands_nm) ends.insert(ends.end(), {from_nm, to_nm});
    extension["extras"]["bands_nm"] = std::move(ends);
  }
  if (cloud.white != std::vector<float>(channels, 1.0f)) extension["extras"]["white"] = cloud.white;
  return {{"mode", 0},
          {"attributes", std::move(attributes)},
          {"extensions", {{splats_extension, std::move(extension)}}}};
}

}  // namespace omma
