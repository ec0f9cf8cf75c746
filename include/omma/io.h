// Files in and out. Every function throws omma::Error that names the file and the place; writers
// write to a temporary name beside the target and rename, so that no half-written file is left.
// Only regular files are read and written; links are followed.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "omma/eye.h"
#include "omma/scene.h"

namespace omma {

struct SceneOptions {
  int scene_index = -1;  // which scene of the file, -1 for its default
  // With ColorRule::compoundray materials are what CompoundRay makes of them: opaque, seen from
  // both sides, without emission, their textures repeated, filtered and not transformed.
  ColorRule color_rule = ColorRule::gltf;
  // Called from the calling thread several times a second with the finished fraction (0 to 1);
  // false ends the loading, which then throws omma::Cancelled.
  std::function<bool(double)> progress = nullptr;
};

// A glTF 2.0 file, .gltf or .glb. Cameras come in the order of the scene's nodes: roots by index,
// children as their parent lists them.
Scene load_scene(const std::string& path, const SceneOptions& options = {});

// A scene as a .glb file, whole in itself, that load_scene reads to an equal one
// (src/io/gltf_write.cpp says what it does not keep). `progress` as that of load_scene.
void save_scene(const std::string& path, const Scene& scene,
                const std::function<bool(double)>& progress = nullptr);

// An eye, by the ending of the file's name (docs/eyes.md):
//   .csv         named columns with units; keeps everything
//   .gltf, .glb  the Open Compound Eye Standard, the glTF extension OCES_eyes: the eyes of the one
//                head that is there; keeps everything
//   else         an `.eye` file: one ommatidium a line, position xyz, axis xyz, acceptance angle
//                (rad), focal offset; spaces, tabs or commas; comments from '#'. Lengths are in
//                `metres_per_unit`, which the other formats do without.
Eye load_eye(const std::string& path, double metres_per_unit = 1e-3);
Eye parse_eye(const std::string& text, const std::string& path, double metres_per_unit = 1e-3);

// The eyes of one head of an OCES file, by its node's name or its number among the heads; and the
// names of the heads that are enabled, none where a glTF file has no eyes.
Eye load_eye_of_head(const std::string& path, const std::string& head);
std::vector<std::string> eye_file_heads(const std::string& path);

// An `.eye` file cannot hold all of an eye. Unless `lossy`, an eye that would lose something is an
// omma::Error that names it; eye_file_losses says what a file of that name would lose.
void save_eye(const std::string& path, const Eye& eye, double metres_per_unit = 1e-3,
              bool lossy = false);
std::vector<std::string> eye_file_losses(const std::string& path, const Eye& eye);

// PNG, JPEG, WebP, Radiance HDR or OpenEXR, for backgrounds. 8-bit data stay sRGB encoded, the rest
// becomes linear float. `progress` as that of load_scene.
Image load_image(const std::string& path, const std::function<bool(double)>& progress = nullptr);

// From encoded bytes; `place` names them in errors.
Image decode_image(std::span<const std::uint8_t> bytes, const std::string& place);

// How PNG files are packed: small, or quick, of pictures of patches of one colour each, without the
// filters that make photographs smaller.
enum class PngPacking { small, quick };

// 8-bit RGB or RGBA, row 0 at the top, into a file; and its bytes alone, where `path` only names it
// in errors. `progress` as that of load_scene; where it ends the writing nothing is left of the
// file.
std::string png_bytes(const std::string& path, std::span<const std::uint8_t> pixels, int width,
                      int height, int components, PngPacking packing,
                      const std::function<bool(double)>& progress = nullptr);
void save_png(const std::string& path, std::span<const std::uint8_t> pixels, int width, int height,
              int components, const std::function<bool(double)>& progress = nullptr);

// Any other bytes, in the same way: the file is then either what it was or complete.
void write_file_atomically(const std::string& path, std::span<const char> bytes);

}  // namespace omma
