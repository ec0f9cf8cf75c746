// A small lit world of which most packets have lanes that do different things.
#pragma once

#include "light_maps.h"
#include "omma/world.h"
#include "test_scenes.h"

namespace omma::test {

// A glossy, a rough and a moved square before a bright sky: most packets have lanes that meet them,
// lanes that meet nothing, and lanes whose gloss goes on.
inline Scene squares() {
  Scene scene;
  Material rough, glossy;
  rough.base_color = {0.5f, 0.4f, 0.3f, 1};
  rough.double_sided = true;
  rough.roughness = 1;
  glossy.double_sided = true;
  glossy.roughness = 0.1f;
  scene.materials = {rough, glossy};
  for (int i = 0; i < 2; ++i) {
    Mesh mesh;
    mesh.material = i;
    mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    scene.meshes.push_back(mesh);
  }
  const Vec3d middle[] = {{-1.5, 0.3, -3}, {1.5, -0.2, -3}, {0.4, 2.5, -3}};
  for (int i = 0; i < 3; ++i) {
    Instance instance;
    instance.mesh = i % 2;
    instance.world_from_mesh = translation(middle[i]);
    scene.instances.push_back(instance);
  }
  return scene;
}

inline Lighting lighting_of(int components) {
  Lighting lighting;
  lighting.light.bands = narrow_bands(3);
  lighting.light.sky = made_sky(4, 2, components, 3, [](int half, int, int, int component, int) {
    return (component == 0 ? 1.0 : 0.3) * (half == 0 ? 1.0 : 0.2);
  });
  lighting.polarized = components == 3;
  return lighting;
}

}  // namespace omma::test
