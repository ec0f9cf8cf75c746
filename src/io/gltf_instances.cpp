// Reads translations, rotations and scales of instances, an accessor each; one that is missing is
// the identity.
#include "io/gltf_instances.h"

#include <string>

#include "io/gltf_accessor.h"
#include "io/gltf_animation.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

constexpr const char* extension_name = "EXT_mesh_gpu_instancing";

struct Attribute {
  const char* name;
  std::size_t components;
  std::vector<double> GltfNode::*part;
};
constexpr Attribute known[] = {{"TRANSLATION", 3, &GltfNode::translation},
                               {"ROTATION", 4, &GltfNode::rotation},
                               {"SCALE", 3, &GltfNode::scale}};

GltfAccessor read_attribute(GltfContainer& gltf, int index, const Attribute& attribute,
                            const std::string& place) {
  GltfAccessor accessor = read_accessor_of(gltf, index, place);
  if (accessor.components != attribute.components || accessor.matrix)
    throw Error(place + ": expected " + std::to_string(attribute.components) +
                " components, found " + std::to_string(accessor.components));
  if (attribute.components == 4 && accessor.component_type != 5126 && !accessor.normalized)
    throw Error(place + ": expected floats or integers that are normalised, found component type " +
                std::to_string(accessor.component_type));
  return accessor;
}

// One node for each instance, with the parts of its transform that the file gives.
std::vector<GltfNode> read_places(GltfContainer& gltf, const json& attributes,
                                  const GltfNode& node) {
  std::vector<GltfNode> places;
  bool is_first = true;
  for (const Attribute& attribute : known) {
    const auto found = attributes.find(attribute.name);
    if (found == attributes.end()) continue;
    const std::string place =
        node.place + ": " + extension_name + ".attributes." + attribute.name;
    const GltfAccessor accessor = read_attribute(gltf, found->get<int>(), attribute, place);
    if (is_first) {
      gltf.budget.spend(accessor.count, sizeof(GltfNode) + 10 * sizeof(double) +
                                            node.name.size() + node.place.size());
      places.resize(accessor.count);
      is_first = false;
    }
    if (accessor.count != places.size())
      throw Error(place + ": has " + std::to_string(accessor.count) + " elements, another has " +
                  std::to_string(places.size()));
    std::vector<double> values(accessor.count * accessor.components);
    read_doubles(accessor, values);
    auto next = values.begin();
    for (GltfNode& one : places) {
      const auto end = next + static_cast<std::ptrdiff_t>(accessor.components);
      (one.*attribute.part).assign(next, end);
      next = end;
    }
  }
  if (is_first)
    throw Error(node.place + ": " + extension_name +
                ".attributes: expected TRANSLATION, ROTATION or SCALE");
  return places;
}

}  // namespace

void place_gltf_instances(GltfContainer& gltf, std::vector<GltfNode>& nodes,
                          std::vector<int>& parent, GltfWarnings& warnings) {
  const std::size_t in_file = nodes.size();
  for (std::size_t n = 0; n < in_file; ++n) {
    const json& description = gltf_list(gltf.document, "nodes")[n];
    const json& extension = gltf_extension(description, extension_name);
    if (extension.empty() || nodes[n].mesh < 0) continue;
    if (nodes[n].skin >= 0)
      throw Error(nodes[n].place + ": expected a skin or " + extension_name + ", found both");
    for (const auto& attribute : extension["attributes"].items())
      if (attribute.key().find("COLOR") != std::string::npos)
        warnings.add("colours of single instances are not read", nodes[n].place);
    std::vector<GltfNode> places = read_places(gltf, extension["attributes"], nodes[n]);
    std::vector<int> children;
    for (GltfNode& one : places) {
      one.place = nodes[n].place + ", instance " + std::to_string(children.size());
      one.name = nodes[n].name;
      one.mesh = nodes[n].mesh;
      one.weights = nodes[n].weights;
      children.push_back(static_cast<int>(nodes.size()));
      parent.push_back(static_cast<int>(n));
      nodes.push_back(std::move(one));
    }
    nodes[n].mesh = -1;
    nodes[n].children.insert(nodes[n].children.begin(), children.begin(), children.end());
  }
}

}  // namespace omma
