// Files in and out. Every function throws omma::Error that names the file and the place; writers
// write to a temporary name beside the target and rename, so that no half-written file is left.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "omma/eye.h"
#include "omma/scene.h"

namespace omma {

struct SceneOptions {
  int scene_index = -1;  // which scene of the file, -1 for its default
  // With ColorRule::compoundray materials are what CompoundRay makes of them: opaque, seen from
  // both sides, without emission, their textures repeated, filtered and not transformed.
  ColorRule color_rule = ColorRule::gltf;
  // Called from the calling thread several times a second with the finished share (0 to 1);
  // false ends the loading, which then throws omma::Cancelled.
  std::function<bool(double)> progress = nullptr;
};

// A glTF 2.0 file, .gltf or .glb. Cameras come in the order of the scene's nodes: roots by index,
// children as their parent lists them.
Scene load_scene(const std::string& path, const SceneOptions& options = {});

// An `.eye` file: one ommatidium a line, position xyz, axis xyz, acceptance angle (rad), focal
// offset; spaces, tabs or commas; comments from '#'. Lengths are in `metres_per_unit`.
Eye load_eye(const std::string& path, double metres_per_unit = 1e-3);
Eye parse_eye(const std::string& text, const std::string& path, double metres_per_unit = 1e-3);
void save_eye(const std::string& path, const Eye& eye, double metres_per_unit = 1e-3);

// PNG, JPEG (8 and 16 bit) or Radiance HDR, for backgrounds. 8-bit data stay sRGB encoded, the
// rest becomes linear float.
Image load_image(const std::string& path);

// From encoded bytes; `place` names them in errors.
Image decode_image(std::span<const std::uint8_t> bytes, const std::string& place);

// 8-bit RGB or RGBA, row 0 at the top.
void save_png(const std::string& path, std::span<const std::uint8_t> pixels, int width, int height,
              int components);

}  // namespace omma
