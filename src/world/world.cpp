// A scene built, and what of it can be moved; world_moves.cpp moves it.
#include "omma/world.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "light/check_light.h"
#include "model/new_version.h"
#include "model/scene_light.h"
#include "threads/parallel.h"
#include "world/camera_rays.h"  // IWYU pragma: keep, deleted here
#include "world/traced_poses.h"
#include "world/world_state.h"

namespace omma {
namespace {

// Radiance is at most 1e15, and sums of it stay in single precision.
constexpr double most_band_weight = 1e6;

std::vector<float> checked_bands(const std::vector<double>& band_from_rgb) {
  if (band_from_rgb.size() % 3 != 0 || band_from_rgb.size() > std::size_t{3} * most_bands)
    throw Error("band_from_rgb: expected 1 to " + std::to_string(most_bands) +
                " rows of three weights (band x RGB), or none, found " +
                std::to_string(band_from_rgb.size()) + " weights");
  std::vector<float> weights;
  for (const double weight : band_from_rgb) {
    if (!(std::fabs(weight) <= most_band_weight))
      throw Error("band_from_rgb: expected weights of at most " +
                  std::to_string(most_band_weight) + ", found " + std::to_string(weight));
    weights.push_back(static_cast<float>(weight));
  }
  return weights;
}

// What the physics reads: what was built, before a background, in the world's bands and light.
SceneView view_of(const World::State& state) {
  SceneView view = state.lit != nullptr ? state.lit->view : state.built->shading->view;
  view.background = state.background.view;
  view.frame_from_mesh = state.built->frames.data();
  view.changing = &state.built->versions;
  if (state.built->splats != nullptr) view.splats = &state.built->splats->view;
  if (!state.band_from_rgb.empty()) {
    view.bands = static_cast<int>(state.band_from_rgb.size() / 3);
    view.band_from_rgb = state.band_from_rgb.data();
    view.bands_version = new_version();
  }
  return view;
}

Things things_of(const Scene& scene) {
  std::vector<std::vector<int>> parts;
  std::unordered_map<int, std::size_t> thing_of_node;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const int node = scene.instances[i].node;
    std::size_t thing = parts.size();
    if (node >= 0) thing = thing_of_node.try_emplace(node, thing).first->second;
    if (thing == parts.size()) parts.emplace_back();
    parts[thing].push_back(static_cast<int>(i));
  }
  Things things;
  things.first.push_back(0);
  for (const std::vector<int>& part : parts) {
    things.instance.insert(things.instance.end(), part.begin(), part.end());
    things.first.push_back(static_cast<int>(things.instance.size()));
  }
  return things;
}

std::string place_of(const Scene& scene) {
  return scene.path.empty() ? "world" : scene.path;
}

// Edits that make one name of another (Levenshtein 1966), over the length of the longer.
double difference(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  const std::size_t longer = std::max(a.size(), b.size());
  return longer == 0 ? 0 : static_cast<double>(row.back()) / static_cast<double>(longer);
}

constexpr std::size_t names_told = 5, most_compared = 200;  // names, characters

// The names of things that are most like one, in quotes.
std::string similar_names(const BuiltScene& built, const std::string& name) {
  std::vector<std::pair<double, std::string>> names;
  for (std::size_t i = 0; i < built.things.count(); ++i) names.emplace_back(0, name_of(built, i));
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  for (auto& [unlike, other] : names)
    unlike = difference(name.substr(0, most_compared), other.substr(0, most_compared));
  std::stable_sort(names.begin(), names.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), names_told); ++i)
    text += (i == 0 ? "\"" : ", \"") + names[i].second + "\"";
  return text + (names.size() > names_told ? ", ..." : "");
}

// `state` has its settings and what was built of its scene.
void light_up(World::State& state) {
  if (!state.settings.lighting) return;
  const BuiltScene& built = *state.built;
  state.lit = make_lit_data(*state.settings.lighting, *built.scene, built.placement,
                            {built.frames.data(), built.first_origin_m, built.first_origin_now_m,
                             built.placement.moves.data()});
  follow_moves(built, state.lit);
  state.radiance_unit = state.lit->light->radiance_unit;
  if (!state.settings.lighting->sun_map) return;
  LitData& lit = *state.lit;
  if (!may_have_sun_map(lit.view))
    throw Error(
        "sun: expected \"exact\" in a world with surfaces that let light straight through (BLEND, "
        "transmission), whose shadows a map does not know; found \"map\"");
  lit.sun_map =
      make_sun_map({built.launches.closest, built.acceleration.tracer.get()}, *built.scene,
                   built.placement, state.settings.lighting->light.discs.front().direction);
  lit.view.sun_map = &lit.sun_map.view;
}

void check_lighting(const WorldSettings& settings, const Scene& scene) {
  if (!settings.lighting) return;
  if (settings.background)
    throw Error("background: expected none in a lit world, which has the sky of its light");
  if (!settings.band_from_rgb.empty())
    throw Error("band_from_rgb: expected none in a lit world, which has the bands of its light");
  const Lighting& lighting = *settings.lighting;
  if (lighting.depth < 0 || lighting.depth > most_depth)
    throw Error("depth: expected 1 to " + std::to_string(most_depth) +
                " scatterings, or 0 for as many as it takes, found " +
                std::to_string(lighting.depth));
  validate_light(lighting.light, scene.materials.size() + 1);
  if (lighting.baked != nullptr) {
    expect_no_splats(scene);
    if (lighting.depth != 0)
      throw Error("depth: expected 0, as many scatterings as it takes, of light that is baked; found " +
                  std::to_string(lighting.depth));
    check_baked_light(*lighting.baked, scene, static_cast<int>(lighting.light.bands.count()));
  }
  if (lighting.sun_map && (lighting.baked == nullptr || lighting.light.discs.size() != 1))
    throw Error(lighting.baked == nullptr
                    ? "sun: expected \"exact\" where light is not baked, found \"map\""
                    : "sun: expected \"exact\" in a light of " +
                          std::to_string(lighting.light.discs.size()) +
                          " discs, as a map knows one sun, found \"map\"");
  check_lit_scene(scene);
}

void check_background(const Background& background) {
  Scene only_background;
  only_background.path = "the given background";
  only_background.background = background;
  validate_scene(only_background);
}

}  // namespace

void expect_no_splats(const Scene& scene) {
  if (!scene.splats.empty())
    throw Error(
        "baked light: expected a scene without Gaussian splats, found some; light is followed "
        "along paths there (lighting=\"path\")");
}

Rendering::Rendering(const World& world) : built_(*world.state().built) {
  int before = built_.renders;
  do {
    if (before < 0)
      throw Error(
          "expected a world at rest, found one in which another thread is moving something; render "
          "before or afterwards");
  } while (!built_.renders.compare_exchange_weak(before, before + 1));
}

Rendering::~Rendering() {
  --built_.renders;
}

BuiltScene::~BuiltScene() {
  delete camera_rays.load();
  for (LitWorld* lit = lit_worlds; lit != nullptr;) delete std::exchange(lit, lit->next);
}

World::World(std::shared_ptr<const Scene> scene, WorldSettings settings,
             const std::function<bool(double)>& progress) {
  if (scene == nullptr) throw Error("scene: expected a scene, found a null pointer");
  const Backend& backend = find_backend(settings.backend);
  check_threads(settings.threads);
  validate_scene(*scene);
  if (settings.background) check_background(*settings.background);
  check_lighting(settings, *scene);
  auto state = std::make_shared<State>();
  state->band_from_rgb = checked_bands(settings.band_from_rgb);
  state->settings = std::move(settings);
  state->built = std::make_shared<BuiltScene>(state->settings.threads);
  BuiltScene& built = *state->built;
  built.backend = &backend;
  built.devices = state->settings.devices;
  built.launches = backend.launches(built.devices);
  built.scene = std::move(scene);
  const auto build = [&](WorkState& work) {
    const auto start = Clock::now();
    built.shading = make_shading_data(*built.scene);
    built.shading->view.changing = &built.versions;
    built.things = things_of(*built.scene);
    if (built.scene->rig != nullptr) built.animated = animated_of(*built.scene, built.things);
    built.box_of_mesh = boxes_of_used_meshes(*built.scene);
    built.placement = placement_of(*built.scene);
    built.first_origin_m = built.placement.origin_m;
    built.versions.colored = new_version();
    built.times.scene_s = seconds_since(start);
    const auto before_building = Clock::now();
    if (!built.scene->splats.empty())
      built.splats =
          make_splat_data(*built.scene, built.placement.origin_m, built.first_origin_now_m, &work);
    take_acceleration(built, built_as_placed(built, work));
    built.times.acceleration_s = seconds_since(before_building);
    light_up(*state);
    const std::optional<Background>& own = state->settings.background;
    state->background = make_background_data(own ? *own : built.scene->background);
    state->view = view_of(*state);
  };
  run_watched(progress,
              [&](WorkState& work) { run_in_arena(*built.threads.arena, [&] { build(work); }); });
  state_ = std::move(state);
}

World World::with_lighting(Lighting lighting) const {
  auto state = std::make_shared<State>();
  state->settings = state_->settings;
  state->settings.background.reset();
  state->settings.band_from_rgb.clear();
  state->settings.lighting = std::move(lighting);
  check_lighting(state->settings, *state_->built->scene);
  if (!state_->built->images.empty() || state_->built->has_other_colors)
    throw Error(
        "light: expected a world whose images and colours are its scene's, found one in which "
        "set_image or set_color has changed them");
  state->built = state_->built;
  const Rendering unmoved(*this);
  run_in_arena(*state->built->threads.arena, [&] { light_up(*state); });
  state->view = view_of(*state);
  World other;
  other.state_ = std::move(state);
  return other;
}

World World::with_background(const Background& background) const {
  check_background(background);
  if (state_->settings.lighting)
    throw Error("background: expected none in a lit world, which has the sky of its light");
  auto state = std::make_shared<State>();
  state->settings = state_->settings;
  state->settings.background = background;
  state->built = state_->built;
  state->band_from_rgb = state_->band_from_rgb;
  run_in_arena(*state->built->threads.arena,
               [&] { state->background = make_background_data(*state->settings.background); });
  state->view = view_of(*state);
  World other;
  other.state_ = std::move(state);
  return other;
}

std::vector<WorldInstance> World::instances() const {
  const Rendering unmoved(*this);
  const BuiltScene& built = *state_->built;
  std::vector<WorldInstance> instances;
  for (std::size_t thing = 0; thing < built.things.count(); ++thing)
    instances.push_back(
        {name_of(built, thing), built.placement.world_from_mesh[first_instance(built, thing)]});
  return instances;
}

int World::find_instance(const std::string& name) const {
  const BuiltScene& built = *state_->built;
  std::string indices;
  std::size_t count = 0, found = 0;
  constexpr std::size_t most_told = 20;
  for (std::size_t i = 0; i < built.things.count(); ++i) {
    if (name_of(built, i) != name) continue;
    if (count < most_told) indices += (count == 0 ? "" : ", ") + std::to_string(i);
    if (count++ == 0) found = i;
  }
  if (count == 1) return static_cast<int>(found);
  const std::string place = place_of(*built.scene);
  if (count > 1)
    throw Error(place + ": " + std::to_string(count) + " things are called \"" + name +
                "\": " + indices + (count > most_told ? ", ..." : ""));
  throw Error(place + ": there is nothing called \"" + name + "\" to move; " +
              (built.things.count() == 0 ? "the scene is empty"
                                         : "nearest to it are " + similar_names(built, name)));
}

const Scene& World::scene() const {
  return *state_->built->scene;
}
const WorldSettings& World::settings() const {
  return state_->settings;
}
const WorldBuildTimes& World::build_times() const {
  return state_->built->times;
}
int World::bands() const {
  return state_->view.bands;
}
int World::components() const {
  return state_->view.polarized ? 3 : 1;
}
int World::threads() const {
  return state_->built->threads.threads;
}
std::string World::backend() const {
  const Rendering unmoved(*this);
  return state_->built->acceleration.name;
}
std::vector<int> World::cards() const {
  const Rendering unmoved(*this);
  return state_->built->acceleration.cards;
}
std::string World::precision_warning(std::span<const Mat4> world_from_head) const {
  const Rendering unmoved(*this);
  const Placement& placement = state_->built->placement;
  return omma::precision_warning(world_from_head, placement.origin_m, placement.half_size_m);
}
std::string World::pose_slip(std::span<const Mat4> world_from_head) const {
  const Rendering unmoved(*this);
  const Placement& placement = state_->built->placement;
  return omma::pose_slip(world_from_head, placement.origin_m, placement.half_size_m,
                         scene().cameras);
}

}  // namespace omma
