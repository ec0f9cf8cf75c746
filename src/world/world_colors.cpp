// Pictures and colours of a world that change while its shapes stay, as of a screen or a lamp that
// flickers.
#include <cmath>

#include "backend/texture_table.h"
#include "model/new_version.h"
#include "omma/world.h"
#include "threads/parallel.h"
#include "world/world_state.h"

namespace omma {
namespace {

void check_index(const char* what, int index, std::size_t count) {
  if (static_cast<std::size_t>(index) >= count)
    throw Error(std::string(what) + ": expected an index into the " + std::to_string(count) +
                " of the scene, found " + std::to_string(index));
}

void check_unlit(const BuiltScene& built, const char* what) {
  if (built.lit_worlds.load() != nullptr)
    throw Error(std::string(what) +
                ": expected a world that was never lit, as light goes by the colours that it was "
                "made for, found one with light");
}

void check_picture(const Scene& scene, int image, const Image& picture) {
  Scene holder;
  holder.images = {picture};
  validate_scene(holder);
  const Image& own = scene.images[static_cast<std::size_t>(image)];
  if (picture.width != own.width || picture.height != own.height)
    throw Error("picture: expected " + std::to_string(own.width) + " x " +
                std::to_string(own.height) + " pixels, as image " + std::to_string(image) +
                " has, found " + std::to_string(picture.width) + " x " +
                std::to_string(picture.height));
}

void check_color(const char* name, Vec3 color) {
  for (const float x : {color.x, color.y, color.z})
    if (!(x >= 0) || !std::isfinite(x))
      throw Error(std::string(name) + ": expected three finite numbers from 0 on, found " +
                  std::to_string(x));
}

}  // namespace

void World::set_image(int image, Image picture) {
  BuiltScene& built = *state_->built;
  check_index("image", image, built.scene->images.size());
  check_picture(*built.scene, image, picture);
  const Moving alone(built, "set_image");
  check_unlit(built, "set_image");
  for (const auto& [key, levels] : built.shading->levels_of_image)
    if (std::get<0>(key) == image && std::get<AlphaMode>(key) != AlphaMode::opaque)
      throw Error("image: expected one whose alpha is not used, found image " +
                  std::to_string(image) + ", which a material cuts out or blends by its alpha");
  auto kept = std::make_unique<const Image>(std::move(picture));
  run_in_arena(*built.threads.arena,
               [&] { replace_image(*built.scene, *built.shading, image, *kept); });
  built.images[image] = std::move(kept);
}

void World::set_color(int material, Vec3 base_color, Vec3 emissive) {
  BuiltScene& built = *state_->built;
  check_index("material", material, built.scene->materials.size());
  check_color("base_color", base_color);
  check_color("emissive", emissive);
  const Moving alone(built, "set_color");
  check_unlit(built, "set_color");
  const auto m = static_cast<std::size_t>(material);
  MaterialView& view = built.shading->materials[m];
  view.base_color = {base_color.x, base_color.y, base_color.z, view.base_color.w};
  view.emissive = built.scene->materials[m].unlit ? Vec3{} : emissive;
  built.has_other_colors = true;
  built.versions.colored = new_version();
}

}  // namespace omma
