// The heads of an OCES file, the eyes below them, and where those sit on the head.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <unordered_map>

#include "io/csv_text.h"
#include "io/eye_json.h"
#include "io/gltf_nodes.h"
#include "io/oces.h"
#include "io/oces_file.h"
#include "omma/error.h"

namespace omma {

using nlohmann::json;

namespace {

// A node of OCES: a head, or where an eye is.
struct OcesNode {
  bool head = false, eye = false, enabled = true;
  json eye_index;
  std::vector<json> mirror_planes;
};

struct Head {
  std::string name, place;
  bool enabled = true;
  std::size_t node = 0;
};

struct Tree {
  std::vector<GltfNode> nodes;
  std::vector<int> parent;
  std::vector<OcesNode> oces;
  std::vector<Head> heads;
};

const json empty_object = json::object();

// An object of the extension on a glTF object; null where there is none.
const json* extension_of(const json& object, const std::string& place) {
  const json* extensions = oces_member(object, "extensions");
  if (extensions == nullptr || !extensions->is_object()) return nullptr;
  const json* own = oces_member(*extensions, "OCES_eyes");
  if (own != nullptr && !own->is_object())
    throw Error(place + ": extensions.OCES_eyes: expected an object, found " +
                shown_text(own->dump(-1, ' ', true)));
  return own;
}

// From an open glTF file that has the extension.
OcesFile open(GltfContainer gltf, const std::string& path) {
  OcesFile file;
  file.gltf = std::move(gltf);
  const json& extension = file.extension();
  const std::string version = oces_text(extension, "version", path + ": OCES_eyes");
  if (!version.starts_with("0."))
    throw Error(path + ": OCES_eyes.version: expected 0.x.x, found " +
                (version.empty() ? "none" : shown_text(version)));
  const json& extras = oces_extras(extension);
  const auto list = [&](const char* name, auto read) {
    const json* values = oces_member(extras, name);
    if (values == nullptr) return;
    const std::string place = path + ": OCES_eyes.extras.omma." + name;
    if (!values->is_array()) throw Error(place + ": expected an array");
    for (std::size_t i = 0; i < values->size(); ++i)
      read((*values)[i], place + "[" + std::to_string(i) + "]");
  };
  list("acceptances", [&](const json& value, const std::string& place) {
    file.acceptances.push_back(read_acceptance(value, place));
    validate_acceptance(file.acceptances.back(), place);
  });
  list("receptor_types", [&](const json& value, const std::string& place) {
    file.receptor_types.push_back(read_receptor_type(value, place));
    validate_receptor_type(file.receptor_types.back(), place);
  });
  return file;
}

OcesNode read_node(const json& description, const std::string& place) {
  OcesNode node;
  const json* extension = extension_of(description, place);
  if (extension == nullptr) return node;
  const std::string inside = place + ": OCES_eyes";
  node.head = oces_flag(*extension, "head", false, inside);
  node.enabled = oces_flag(*extension, "enabled", true, inside);
  if (const json* eye = oces_member(*extension, "eye")) {
    if (node.head) throw Error(inside + ": expected a head or an eye, found both");
    node.eye = true;
    node.eye_index = *eye;
  }
  if (const json* planes = oces_member(*extension, "mirrorPlanes")) {
    if (!planes->is_array()) throw Error(inside + ".mirrorPlanes: expected an array");
    node.mirror_planes.assign(planes->begin(), planes->end());
  }
  return node;
}

Tree read_tree(const OcesFile& file) {
  Tree tree;
  tree.nodes = read_gltf_nodes(file.gltf.document, file.gltf.path);
  tree.parent = gltf_node_parents(tree.nodes);
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const GltfNode& node = tree.nodes[i];
    tree.oces.push_back(read_node(file.gltf.document["nodes"][i], node.place));
    if (tree.oces[i].head) tree.heads.push_back({node.name, node.place, tree.oces[i].enabled, i});
  }
  // From the roots down, so that long chains of nodes cost no more than short ones.
  std::vector<int> head_of(tree.nodes.size(), -1);
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < tree.nodes.size(); ++i)
    if (tree.parent[i] < 0) open.push_back(i);
  while (!open.empty()) {
    const std::size_t i = open.back();
    open.pop_back();
    const int above = tree.parent[i] < 0 ? -1 : head_of[static_cast<std::size_t>(tree.parent[i])];
    if (tree.oces[i].head && above >= 0)
      throw Error(tree.nodes[i].place + ": a head below another head, " +
                  tree.nodes[static_cast<std::size_t>(above)].place);
    if (tree.oces[i].eye && above < 0)
      throw Error(tree.nodes[i].place + ": an eye must be below a head, this one is not");
    head_of[i] = tree.oces[i].head ? static_cast<int>(i) : above;
    for (const int child : tree.nodes[i].children) open.push_back(static_cast<std::size_t>(child));
  }
  return tree;
}

std::string list_of(const std::vector<Head>& heads) {
  std::string list;
  for (std::size_t h = 0; h < heads.size(); ++h) {
    if (h > 0) list.append(", ");
    list.append(std::to_string(h)).append(" ").append(shown_text(heads[h].name));
    if (!heads[h].enabled) list.append(" (disabled)");
  }
  return list;
}

const Head& choose(const std::vector<Head>& heads, const std::string& wanted,
                   const std::string& path) {
  if (heads.empty())
    throw Error(path + ": has no head: expected a node with \"head\": true in OCES_eyes");
  std::vector<const Head*> found;
  for (const Head& head : heads)
    if (wanted.empty() ? head.enabled : head.name == wanted) found.push_back(&head);
  std::size_t number = heads.size();
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
  const bool is_number = error == std::errc{} && end == wanted.data() + wanted.size();
  if (found.empty() && is_number && number < heads.size()) found.push_back(&heads[number]);
  if (found.size() > 1)
    throw Error(path + ": expected the name or number of one head, of " + list_of(heads));
  if (found.empty())
    throw Error(path + ": has no head " +
                (wanted.empty() ? "that is enabled" : shown_text(wanted)) +
                "; expected the name or number of one head, of " + list_of(heads));
  if (!found.front()->enabled)
    throw Error(found.front()->place + ": this head is disabled, and its eyes with it");
  return *found.front();
}

// Names that stand for a direction; document 0.4.0 and the schemas spell some in two ways.
Vec3d plane_normal(const json& plane, const std::string& place) {
  const json* value = oces_member(plane, "normal");
  if (value == nullptr) return {1, 0, 0};
  static const std::set<std::string> x = {"X", "FRONTAL", "LEFT", "RIGHT"},
                                     y = {"Y", "TRANSVERSE", "DORSOVENTRAL", "UP", "DOWN"},
                                     z = {"Z",         "SAGITTAL",      "ANTERIOR",
                                          "POSTERIOR", "ANTEPOSTERIOR", "ANTEROPOSTERIOR",
                                          "FORWARD",   "BACKWARD",      "FRONT",
                                          "BACK"};
  if (value->is_string()) {
    const std::string& name = value->get_ref<const std::string&>();
    if (x.contains(name)) return {1, 0, 0};
    if (y.contains(name)) return {0, 1, 0};
    if (z.contains(name)) return {0, 0, 1};
  } else if (value->is_array() && value->size() == 3) {
    const Vec3d normal{oces_number((*value)[0], place), oces_number((*value)[1], place),
                       oces_number((*value)[2], place)};
    const double size = length(normal);
    if (size > 0 && std::isfinite(size)) return normal * (1 / size);
  }
  throw Error(place +
              ".normal: expected three numbers that are not all 0 or a name such as X, "
              "LEFT, DORSOVENTRAL, FORWARD, found " +
              shown_text(value->dump(-1, ' ', true)));
}

Mat4 reflection(const OcesFile& file, const json& index, const std::string& user) {
  const json& plane = oces_element(file, "mirrorPlanes", index, user);
  const std::string place =
      file.gltf.path + ": OCES_eyes.mirrorPlanes[" + std::to_string(index.get<int>()) + "]";
  const Vec3d n = plane_normal(plane, place);
  Vec3d position{};
  if (const json* value = oces_member(plane, "position")) {
    if (!value->is_array() || value->size() != 3)
      throw Error(place + ".position: expected three numbers");
    position = {oces_number((*value)[0], place + ".position"),
                oces_number((*value)[1], place + ".position"),
                oces_number((*value)[2], place + ".position")};
  }
  const double c[3] = {n.x, n.y, n.z};
  const double distance = 2 * dot(n, position);
  Mat4 t;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) t.m[i][j] = (i == j ? 1 : 0) - 2 * c[i] * c[j];
    t.m[i][3] = distance * c[i];
  }
  return t;
}

void check_invertible(const Mat4& t, const std::string& place) {
  bool good = std::fabs(determinant(t)) > 0 && std::isfinite(determinant(t));
  for (const auto& row : t.m)
    for (const double value : row) good = good && std::isfinite(value);
  if (!good)
    throw Error(place +
                ": its place on the head cannot be computed: the transforms of it "
                "and the nodes above are not invertible");
}

// An eye and its mirror images as they are on the head.
void place_eye(OcesFile& file, const Tree& tree, std::size_t node, const Mat4& head_from_node,
               std::vector<PlacedEye>& placed, std::vector<json>& extras) {
  const GltfNode& where = tree.nodes[node];
  const OcesNode& oces = tree.oces[node];
  const std::string user = where.place + ": eye";
  const json& description = oces_element(file, "eyes", oces.eye_index, user);
  std::string place =
      file.gltf.path + ": OCES_eyes.eyes[" + std::to_string(oces.eye_index.get<int>()) + "]";
  const std::string name = oces_text(description, "name", place);
  if (!name.empty()) place.append(" ").append(shown_text(name));
  if (!oces.enabled || !oces_flag(description, "enabled", true, place)) return;
  check_invertible(head_from_node, where.place);
  std::vector<json> planes = oces.mirror_planes;
  if (const json* own = oces_member(description, "mirrorPlanes")) {
    if (!own->is_array()) throw Error(place + ": mirrorPlanes: expected an array");
    std::set<json> there(planes.begin(), planes.end());
    for (const json& plane : *own)
      if (there.insert(plane).second) planes.push_back(plane);
  }
  const auto [read, is_new] = file.eyes.try_emplace(oces.eye_index.get<int>());
  if (is_new) read->second = read_oces_eye(file, description, place);
  Eye eye = read->second;
  const json& own = oces_extras(description);
  const bool named = !name.empty() && !own.contains("unnamed");
  const auto set_name = [&](const std::string& text) {
    if (!named) return;
    const auto is_name = [](const EyeColumn& c) { return c.name == oces_name::eye_name_column; };
    const auto found = std::find_if(eye.columns.begin(), eye.columns.end(), is_name);
    EyeColumn column{oces_name::eye_name_column, {}, std::vector<std::string>(eye.size(), text)};
    if (found == eye.columns.end())
      eye.columns.push_back(std::move(column));
    else
      *found = std::move(column);
  };
  // Half a turn about Y: OCES's +Z ahead to our -Z.
  Mat4 ours_from_oces;
  ours_from_oces.m[0][0] = ours_from_oces.m[2][2] = -1;
  file.gltf.budget.spend(planes.size() + 1, eye.size() * (200 + 8 * eye.columns.size()));
  set_name(name);
  placed.push_back({eye, ours_from_oces * head_from_node});
  extras.push_back(own);
  for (const json& plane : planes) {
    const Mat4 mirror = reflection(file, plane, where.place + ": mirrorPlanes");
    set_name(name + " (mirrored)");
    placed.push_back({eye, ours_from_oces * mirror * head_from_node});
    extras.push_back(empty_object);
  }
}

// Eye numbers, the order of ommatidia and that of columns, as they were when Omma wrote the file.
Eye restore_order(const OcesFile& file, Eye eye, const std::vector<json>& extras) {
  std::vector<std::int32_t> ids;
  for (const json& own : extras) {
    const json* id = oces_member(own, "eye_id");
    if (id == nullptr || !id->is_number_unsigned() || *id > 2147483647u) break;
    ids.push_back(id->get<std::int32_t>());
  }
  const std::set<std::int32_t> distinct(ids.begin(), ids.end());
  if (distinct.size() == extras.size())
    for (std::int32_t& id : eye.eye_id) id = ids[static_cast<std::size_t>(id)];

  const auto named = [&](const std::string& name) {
    return std::find_if(eye.columns.begin(), eye.columns.end(),
                        [&](const EyeColumn& column) { return column.name == name; });
  };
  if (const auto index = named(oces_name::index); index != eye.columns.end()) {
    std::vector<std::int64_t> from(eye.size(), -1);
    bool permutation = index->numbers.size() == eye.size();
    for (std::size_t i = 0; i < eye.size() && permutation; ++i) {
      const double to = index->numbers[i];
      permutation = to >= 0 && to < static_cast<double>(eye.size()) && to == std::floor(to) &&
                    from[static_cast<std::size_t>(to)] < 0;
      if (permutation) from[static_cast<std::size_t>(to)] = static_cast<std::int64_t>(i);
    }
    eye.columns.erase(index);
    if (permutation) eye = take_ommatidia(eye, from);
  }
  const json* order = oces_member(oces_extras(file.extension()), "columns");
  if (order == nullptr || !order->is_array()) return eye;
  std::unordered_map<std::string, std::size_t> rank;
  for (const json& name : *order)
    if (name.is_string()) rank.try_emplace(name.get<std::string>(), rank.size());
  const auto rank_of = [&](const EyeColumn& column) {
    const auto found = rank.find(column.name);
    return found == rank.end() ? rank.size() : found->second;  // the others follow as they are
  };
  std::stable_sort(eye.columns.begin(), eye.columns.end(),
                   [&](const EyeColumn& a, const EyeColumn& b) { return rank_of(a) < rank_of(b); });
  return eye;
}

}  // namespace

const json& OcesFile::extension() const {
  return gltf.document["extensions"]["OCES_eyes"];
}

Eye parse_oces(std::string bytes, const std::string& path, const std::string& wanted) {
  GltfContainer gltf = open_gltf(std::move(bytes), path, {});
  if (extension_of(gltf.document, path) == nullptr)
    throw Error(path + ": has no eyes: expected the glTF extension OCES_eyes, found none");
  OcesFile file = open(std::move(gltf), path);
  const Tree tree = read_tree(file);
  const Head& head = choose(tree.heads, wanted, path);
  std::vector<PlacedEye> placed;
  std::vector<json> extras;
  struct Visit {
    std::size_t node;
    Mat4 head_from_parent;
  };
  std::vector<Visit> open_nodes;
  const auto visit_children = [&](std::size_t node, const Mat4& head_from_node) {
    const std::vector<int>& children = tree.nodes[node].children;
    for (auto child = children.rbegin(); child != children.rend(); ++child)
      open_nodes.push_back({static_cast<std::size_t>(*child), head_from_node});
  };
  visit_children(head.node, {});
  while (!open_nodes.empty()) {
    const Visit visit = open_nodes.back();
    open_nodes.pop_back();
    const Mat4 head_from_node =
        visit.head_from_parent * gltf_node_transform(tree.nodes[visit.node]);
    if (tree.oces[visit.node].eye)
      place_eye(file, tree, visit.node, head_from_node, placed, extras);
    visit_children(visit.node, head_from_node);
  }
  if (placed.empty()) throw Error(head.place + ": this head has no eye that is enabled");
  // Put together every eye has the columns of all.
  std::set<std::string> columns;
  std::uint64_t ommatidia = 0;
  for (const PlacedEye& one : placed) {
    for (const EyeColumn& column : one.eye.columns) columns.insert(column.name);
    ommatidia += one.eye.size();
  }
  file.gltf.budget.spend(columns.size(), ommatidia * sizeof(double));
  Eye eye = merge_eyes(placed);
  eye.path = path;
  return restore_order(file, std::move(eye), extras);
}

std::vector<std::string> parse_oces_heads(std::string bytes, const std::string& path) {
  std::vector<std::string> names;
  GltfContainer gltf = open_gltf(std::move(bytes), path, {});
  if (extension_of(gltf.document, path) == nullptr) return names;
  const OcesFile file = open(std::move(gltf), path);
  for (const Head& head : read_tree(file).heads)
    if (head.enabled) names.push_back(head.name);
  return names;
}

}  // namespace omma
