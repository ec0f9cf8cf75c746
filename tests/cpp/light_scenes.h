// Scenes with lamps and shining surfaces, as the physics sees them.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "backend/light_data.h"
#include "backend/shading_data.h"
#include "light_maps.h"
#include "physics/light/near_light.h"
#include "test_scenes.h"

namespace omma::test {

// Owns all that `view` points to.
struct LitScene {
  Scene scene;
  Placement placement;
  std::unique_ptr<ShadingData> shading;
  std::vector<std::vector<float>> emission;  // [material]
  std::vector<ScatterView> scatter;
  std::vector<float> frames;
  std::unique_ptr<LightData> light;
  SceneView view;

  // Where instances are is read anew.
  void place(std::vector<Mat4> world_from_mesh) {
    placement.world_from_mesh = std::move(world_from_mesh);
    frames.clear();
    for (const Mat4& m : placement.world_from_mesh)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) frames.push_back(static_cast<float>(m.m[r][c]));
    view.frame_from_mesh = frames.data();
  }
};

inline std::unique_ptr<LitScene> lit_scene(Scene scene, const Light& light) {
  auto lit = std::make_unique<LitScene>();
  lit->scene = std::move(scene);
  lit->shading = make_shading_data(lit->scene);
  lit->view = lit->shading->view;
  lit->emission.resize(lit->scene.materials.size());
  lit->scatter.resize(lit->scene.materials.size() + 1);
  for (std::size_t m = 0; m < lit->scene.materials.size(); ++m) {
    lit->emission[m] = make_emission_matrix(light, lit->scene.materials[m]);
    if (!lit->emission[m].empty()) lit->scatter[m].emission = lit->emission[m].data();
  }
  lit->view.scatter = lit->scatter.data();
  lit->view.bands = static_cast<int>(light.bands.count());
  std::vector<Mat4> transforms;
  for (const Instance& instance : lit->scene.instances)
    transforms.push_back(instance.world_from_mesh);
  lit->placement.half_size_m = 1;
  lit->place(transforms);
  lit->light = make_light_data(light, lit->scene, lit->placement, lit->view);
  lit->view.light = &lit->light->view;
  return lit;
}

// A square of 1 m in its own frame, in the plane z = 0 with its middle at the origin, front
// towards +z, which shines with radiance 1 W m^-2 sr^-1 nm^-1 at all wavelengths.
inline Scene shining_square() {
  Scene scene;
  Material material;
  material.emissive = {1, 1, 1};
  material.emission = {{200, 800}, {1, 1}};
  scene.materials = {material};
  Mesh mesh;
  mesh.material = 0;
  mesh.positions = {{-0.5f, -0.5f, 0}, {0.5f, -0.5f, 0}, {0.5f, 0.5f, 0}, {-0.5f, 0.5f, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.texcoords[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  scene.meshes = {mesh};
  Instance instance;
  instance.mesh = 0;
  scene.instances = {instance};
  return scene;
}

inline Light watts_alone() {
  Light light;
  light.bands = narrow_bands(1);
  light.unit = LightUnit::watts;
  return light;
}

// A lamp or a surface, by a random number beyond those that choose light from afar.
inline LightSample light_at(const LitScene& lit, const LitPoint& at, Random& random) {
  const auto uniform = [&] {
    return std::min(static_cast<float>(random.uniform()), 0x1.fffffep-1f);
  };
  const LightKinds kinds = choose_kinds(*lit.view.light, at);
  const float which = uniform() * (1 - kinds.far), u0 = uniform(), u1 = uniform();
  LightSample sample;
  sample_near_light(lit.view, *lit.view.light, at, kinds, {which, u0, u1}, sample);
  return sample;
}

inline double radiance_of(const LitScene& lit, const LightSample& sample) {
  std::vector<float> out(static_cast<std::size_t>(lit.view.bands));
  eval_light_sample(lit.view, sample, 1, out.data(), 1, 0);
  return static_cast<double>(out[0]);
}

}  // namespace omma::test
