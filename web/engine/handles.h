// What JavaScript holds: a scene, an eye, a world, a renderer. Each keeps alive what it needs of
// the others, so that a page may delete them in any order.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "omma/eye.h"
#include "omma/render.h"
#include "omma/scene.h"
#include "omma/world.h"

namespace omma::web {

struct SceneHandle {
  std::shared_ptr<const Scene> scene;
};

struct EyeHandle {
  std::shared_ptr<const Eye> eye;
};

struct WorldHandle {
  World world;
};

struct Picture {
  std::vector<std::int32_t> pixels;  // [row][column], index of an ommatidium, -1 for none
};

// The functions of each file; module.cpp lists them.
void bind_scene();
void bind_eye();
void bind_renderer();
void bind_projection();

}  // namespace omma::web
