// Channels and samplers, checked and as plain arrays.
#include "io/gltf_animation.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "io/csv_text.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

struct Part {
  const char* path;
  AnimatedPart part;
  std::size_t components;
};
constexpr Part parts[] = {{"translation", AnimatedPart::translation, 3},
                          {"rotation", AnimatedPart::rotation, 4},
                          {"scale", AnimatedPart::scale, 3},
                          {"weights", AnimatedPart::weights, 1}};

Interpolation interpolation_of(const json& sampler, const std::string& place) {
  const std::string word = sampler.value("interpolation", "LINEAR");
  if (word == "LINEAR") return Interpolation::linear;
  if (word == "STEP") return Interpolation::step;
  if (word == "CUBICSPLINE") return Interpolation::cubic_spline;
  throw Error(place + ".interpolation: expected LINEAR, STEP or CUBICSPLINE, found " +
              shown_text(word));
}

std::vector<double> read_times(GltfContainer& gltf, int index, const std::string& place) {
  const GltfAccessor accessor = read_accessor_of(gltf, index, place);
  if (accessor.components != 1 || accessor.component_type != 5126)
    throw Error(place + ": expected floats, one a key, found " +
                std::to_string(accessor.components) + " components of type " +
                std::to_string(accessor.component_type));
  if (accessor.count == 0) throw Error(place + ": expected at least one key, found none");
  gltf.budget.spend(accessor.count, sizeof(double));
  std::vector<double> times(accessor.count);
  read_doubles(accessor, times);
  for (std::size_t i = 1; i < times.size(); ++i)
    if (!(times[i] > times[i - 1]))
      throw Error(place + ": expected times that grow, found " + std::to_string(times[i]) +
                  " s at key " + std::to_string(i) + " after " + std::to_string(times[i - 1]) +
                  " s");
  return times;
}

// Keys of rotations are unit quaternions in the file, to its precision; those of splines are made so
// where they are evaluated.
void normalize_keys(std::vector<double>& values, const std::string& place) {
  for (std::size_t i = 0; i < values.size(); i += 4) {
    double squares = 0;
    for (std::size_t k = i; k < i + 4; ++k) squares += values[k] * values[k];
    const double size = std::sqrt(squares);
    if (!(size > 1e-6))
      throw Error(place + ": the rotation of key " + std::to_string(i / 4) +
                  " is not a unit quaternion");
    for (std::size_t k = i; k < i + 4; ++k) values[k] /= size;
  }
}

void read_sampler(GltfContainer& gltf, const json& sampler, const std::string& place,
                  const Part& part, std::size_t targets, AnimationChannel& channel) {
  channel.interpolation = interpolation_of(sampler, place);
  channel.times_s = read_times(gltf, sampler["input"].get<int>(), place + ".input");
  const std::string output = place + ".output";
  const GltfAccessor accessor = read_accessor_of(gltf, sampler["output"].get<int>(), output);
  if (accessor.components != part.components || accessor.matrix)
    throw Error(output + ": expected " + std::to_string(part.components) + " components for " +
                part.path + ", found " + std::to_string(accessor.components));
  const bool is_cubic = channel.interpolation == Interpolation::cubic_spline;
  const std::size_t each = (is_cubic ? 3 : 1) * targets;
  if (accessor.count != channel.times_s.size() * each)
    throw Error(output + ": expected " + std::to_string(channel.times_s.size() * each) +
                " elements for " + std::to_string(channel.times_s.size()) + " keys of " +
                part.path + ", found " + std::to_string(accessor.count));
  gltf.budget.spend(accessor.count, accessor.components * sizeof(double));
  channel.values.resize(accessor.count * accessor.components);
  read_doubles(accessor, channel.values);
  if (channel.part == AnimatedPart::rotation && !is_cubic)
    normalize_keys(channel.values, output);
}

}  // namespace

GltfAccessor read_accessor_of(GltfContainer& gltf, int index, const std::string& user) {
  try {
    return read_accessor(gltf, index, user);
  } catch (const Error& problem) {
    const std::string text = problem.what(), file = gltf.path + ": ";
    if (text.starts_with(user)) throw;
    throw Error(user + ": " + (text.starts_with(file) ? text.substr(file.size()) : text));
  }
}

std::vector<Animation> read_gltf_animations(GltfContainer& gltf,
                                            const std::vector<GltfNode>& nodes,
                                            const std::vector<std::size_t>& targets,
                                            GltfWarnings& warnings) {
  std::vector<Animation> animations;
  for (const json& source : gltf_list(gltf.document, "animations")) {
    const std::string place = gltf.path + ": animations[" + std::to_string(animations.size()) + "]";
    Animation& animation = animations.emplace_back();
    animation.name = source.value("name", "");
    std::set<std::pair<int, AnimatedPart>> seen;
    std::size_t index = 0;
    for (const json& one : source["channels"]) {
      const std::string channel_place = place + ".channels[" + std::to_string(index++) + "]";
      const json& target = one["target"];
      const std::string path = target["path"].get<std::string>();
      const auto part = std::find_if(std::begin(parts), std::end(parts),
                                     [&](const Part& known) { return known.path == path; });
      if (part == std::end(parts) || !target.contains("node")) {
        warnings.add("animations of other things than nodes are ignored", channel_place);
        continue;
      }
      AnimationChannel channel;
      channel.node = target["node"].get<int>();
      channel.part = part->part;
      const auto node = static_cast<std::size_t>(channel.node);
      if (node >= nodes.size())
        throw Error(channel_place + ".target.node: refers to node " + std::to_string(node) +
                    ", there are " + std::to_string(nodes.size()));
      if (channel.part != AnimatedPart::weights && !nodes[node].matrix.empty())
        throw Error(channel_place + ".target.node: node " + std::to_string(node) +
                    " has a matrix, which cannot be animated");
      if (channel.part == AnimatedPart::weights && targets[node] == 0)
        throw Error(channel_place + ".target.node: node " + std::to_string(node) +
                    " has no mesh with morph targets, whose weights these could be");
      if (!seen.insert({channel.node, channel.part}).second)
        throw Error(channel_place + ": moves the " + path + " of node " + std::to_string(node) +
                    ", as another channel of this animation does");
      const json& samplers = source["samplers"];
      const auto sampler = one["sampler"].get<std::size_t>();
      if (sampler >= samplers.size())
        throw Error(channel_place + ".sampler: refers to sampler " + std::to_string(sampler) +
                    ", there are " + std::to_string(samplers.size()));
      read_sampler(gltf, samplers[sampler],
                   place + ".samplers[" + std::to_string(sampler) + "]", *part,
                   channel.part == AnimatedPart::weights ? targets[node] : 1, channel);
      animation.duration_s = std::max(animation.duration_s, channel.times_s.back());
      animation.channels.push_back(std::move(channel));
    }
  }
  return animations;
}

}  // namespace omma
