// The schema that decides what is read of a glTF file. fuzz/seeds/scene/schema.gltf has every member
// of it; each is taken away and changed here, which must end in a scene or an omma::Error.
#include "io/gltf_schema.h"

#include <fstream>
#include <iterator>
#include <set>

#include "gltf_builder.h"
#include "io/gltf.h"
#include "io/oces.h"

namespace omma::test {
namespace {

json seed(const std::string& name) {
  std::ifstream file(std::string(OMMA_SEEDS) + name);
  return json::parse(file);
}

using Pointers = std::vector<json::json_pointer>;

// Where the members of a path such as "nodes[].mesh" are in a document.
void find_members(const json& object, const json::json_pointer& place, std::string path,
                  Pointers& found) {
  const std::size_t dot = path.find('.');
  std::string name = path.substr(0, dot);
  const bool list = name.ends_with("[]");
  if (list) name.resize(name.size() - 2);
  const auto member = object.find(name);
  if (member == object.end()) return;
  if (dot == std::string::npos) return found.push_back(place / name);
  path = path.substr(dot + 1);
  if (!list) return find_members(*member, place / name, path, found);
  for (std::size_t i = 0; i < member->size(); ++i)
    find_members((*member)[i], place / name / i, path, found);
}

// What a member may become: other types, other ranges, nothing. Of arrays also what is within.
std::vector<json> changes_of(const json& value) {
  std::vector<json> changes = {nullptr, true, -1, 0, 1, 2, 77, -2147483648LL, 2147483647,
                               4294967296LL, std::uint64_t(-1), 1e300, -1e300, 1e-300, 0.5, -0.5,
                               "", "x", "\x1b[31m", json::array(), json::object(),
                               json::array({1, 2, 3}), json::array({json::object()}),
                               json::array({nullptr, 1})};
  if (!value.is_array() || value.empty()) return changes;
  changes.push_back(value);
  changes.back().erase(0);
  changes.push_back(value);
  changes.back().push_back(value[0]);
  for (const json& element : {json(nullptr), json(-1), json(1e300), json("x"), json::array(), json(-2147483648LL)}) {
    changes.push_back(value);
    changes.back()[0] = element;
  }
  return changes;
}

// Loads a document as every scene; true where that went well once.
bool loads(const json& document, const std::string& place) {
  bool well = false;
  for (int scene = 0; scene < 3; ++scene) {
    try {
      SceneOptions options;
      options.scene_index = scene;
      parse_scene(document.dump(), "scene.gltf", options);
      well = true;
    } catch (const Error& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("scene.gltf: ")) << place << error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << place << ": " << error.what();
    }
  }
  return well;
}

TEST(GltfSchema, SeedHasEveryMember) {
  const json document = seed("/scene/schema.gltf");
  ASSERT_TRUE(loads(document, "as it is"));
  for (const std::string& path : gltf_schema_paths()) {
    Pointers found;
    find_members(document, json::json_pointer(), path, found);
    EXPECT_FALSE(found.empty()) << path << " is in no seed";
  }
}

TEST(GltfSchema, FuzzersKnowEveryName) {
  std::ifstream file(std::string(OMMA_SEEDS) + "/../gltf.dict");
  const std::string words{std::istreambuf_iterator<char>(file), {}};
  for (const std::string& path : gltf_schema_paths()) {
    const std::string name = path.substr(path.rfind('.') + 1);
    EXPECT_NE(words.find("\"\\\"" + name + "\\\":\""), std::string::npos) << name;
  }
}

TEST(GltfSchema, EveryMemberChanged) {
  const json document = seed("/scene/schema.gltf");
  for (const std::string& path : gltf_schema_paths()) {
    Pointers found;
    find_members(document, json::json_pointer(), path, found);
    std::set<std::string> seen;  // one of many that are alike is enough
    for (const json::json_pointer& pointer : found) {
      const json value = document[pointer];
      if (!seen.insert(value.dump()).second) continue;
      json changed = document;
      changed[pointer.parent_pointer()].erase(pointer.back());
      loads(changed, pointer.to_string() + " taken away");
      for (const json& other : changes_of(value)) {
        changed[pointer] = other;
        loads(changed, pointer.to_string() + " = " + other.dump());
      }
    }
  }
}

TEST(GltfSchema, OfTextureUses) {
  const std::string extensions = "/materials/0/extensions/KHR_materials_";
  for (const char* use :
       {"specular/specularTexture", "specular/specularColorTexture",
        "transmission/transmissionTexture", "clearcoat/clearcoatTexture",
        "clearcoat/clearcoatRoughnessTexture", "clearcoat/clearcoatNormalTexture",
        "diffuse_transmission/diffuseTransmissionTexture",
        "diffuse_transmission/diffuseTransmissionColorTexture"}) {
    const auto with = [&](const std::string& member, const json& value,
                          const std::vector<std::string>& parts) {
      json document = seed("/scene/schema.gltf");
      document[json::json_pointer(extensions + use + member)] = value;
      expect_error([&] { parse_scene(document.dump(), "scene.gltf", {}); }, parts);
    };
    const std::string transform = "/extensions/KHR_texture_transform";
    with("/texCoord", -2147483648LL, {"texCoord: expected an integer", "found -2147483648"});
    with(transform + "/offset", json::array(), {"offset: expected an array of 2 numbers"});
    with("", json::object(), {"index: is missing"});
  }
}

TEST(GltfSchema, WhatItDoesNotKnowCannotBeRead) {
  json document = seed("/scene/schema.gltf");
  document["nodes"][0]["unknown"] = 1;
  document["nodes"][0]["extensions"]["EXT_moves"] = {{"mesh", 0}};
  document["meshes"][0]["extensions"]["EXT_moves"] = {{"mesh", 0}};
  document["materials"][0]["extensions"]["KHR_materials_sheen"] = json::object();
  const auto unknown = check_gltf_schema(document, "scene.gltf");
  EXPECT_FALSE(document["nodes"][0].contains("unknown"));
  ASSERT_EQ(unknown.size(), 2u);
  EXPECT_EQ(unknown.at("EXT_moves").count, 2);
  EXPECT_EQ(unknown.at("EXT_moves").first_place, "meshes[0]");
  EXPECT_FALSE(unknown.at("EXT_moves").is_surface);
  EXPECT_TRUE(unknown.at("KHR_materials_sheen").is_surface);
  EXPECT_TRUE(check_gltf_schema(document, "scene.gltf").empty());
}

// Eyes check what they read of the extension themselves.
TEST(GltfSchema, EveryMemberOfEyesChanged) {
  for (const char* name : {"/eye/everything.gltf", "/eye/point.gltf", "/eye/sphere.gltf",
                           "/eye/surface.gltf"}) {
    const json document = seed(name);
    const json flat = document.flatten();
    for (const auto& item : flat.items()) {
      const json::json_pointer pointer(item.key());
      // The value, and what holds it.
      for (const json::json_pointer& at : {pointer, pointer.parent_pointer()}) {
        if (at.empty()) continue;
        std::vector<json> documents;
        json changed = document;
        if (changed[at.parent_pointer()].is_object())
          changed[at.parent_pointer()].erase(at.back());
        else
          changed[at.parent_pointer()].erase(std::stoul(at.back()));
        documents.push_back(changed);
        for (const json& other : changes_of(document[at])) {
          documents.push_back(document);
          documents.back()[at] = other;
        }
        for (const json& one : documents)
          try {
            parse_oces(one.dump(), "eye.gltf", "");
          } catch (const Error& error) {
            EXPECT_TRUE(std::string(error.what()).starts_with("eye.gltf")) << error.what();
          } catch (const std::exception& error) {
            ADD_FAILURE() << name << at.to_string() << ": " << error.what();
          }
      }
    }
  }
}

}  // namespace
}  // namespace omma::test
