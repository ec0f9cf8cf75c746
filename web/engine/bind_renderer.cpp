// Worlds and renderers for JavaScript.
#include <emscripten/bind.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "handles.h"
#include "omma/receptor.h"
#include "omma/receptor_views.h"
#include "omma/render.h"
#include "values.h"

namespace omma::web {
namespace {

WorldHandle make_world(const SceneHandle& scene) {
  return checked([&] { return WorldHandle{World(scene.scene, {.backend = "portable"})}; });
}

[[noreturn]] void fail(const char* name, const std::string& expected, const val& found) {
  throw Error(std::string(name) + ": expected " + expected + ", found " + text_of(found));
}

void read_option(const char* name, bool& value, const val& given) {
  if (!has_type(given, "boolean")) fail(name, "true or false", given);
  value = given.as<bool>();
}

template <typename Number>
void read_option(const char* name, Number& value, const val& given) {
  // JavaScript's numbers are whole up to here.
  constexpr double most =
      std::min(9007199254740991.0, static_cast<double>(std::numeric_limits<Number>::max()));
  const double found = has_type(given, "number") ? given.as<double>() : -1;
  if (!(found >= 0 && found <= most && found == std::floor(found)))
    fail(name, "a whole number in its range", given);
  value = static_cast<Number>(found);
}

void read_option(const char* name, auto& value, const val& given, const auto& names) {
  std::string known;
  for (const auto& named : names) {
    if (has_type(given, "string") && given.as<std::string>() == named.name) {
      value = named.value;
      return;
    }
    known += (known.empty() ? "" : ", ") + std::string(named.name);
  }
  fail(name, "one of " + known, given);
}

struct Options {
  RenderSettings settings;
  bool receptors = false, error = false;
};

// `options`: those of RenderSettings (for_each_option), rays, receptors and error; what is left out
// is as there.
Options read_options(const val& options) {
  Options found;
  Fixed fixed;
  std::vector<std::string> known;
  const auto read = [&](const char* name, auto& value, const auto&... names) {
    known.emplace_back(name);
    const val given = options[name];
    if (!given.isUndefined()) read_option(name, value, given, names...);
  };
  read("rays", fixed.samples);
  read("receptors", found.receptors);
  read("error", found.error);
  for_each_option(found.settings, read);
  found.settings.sampling = fixed;
  const val names = val::global("Object").call<val>("keys", options);
  for (int i = 0; i < names["length"].as<int>(); ++i) {
    const auto name = names[i].as<std::string>();
    std::string all;
    for (const std::string& one : known) {
      if (one == name) all = "";
      if (one == name) break;
      all += (all.empty() ? "" : ", ") + one;
    }
    if (!all.empty()) throw Error("options: expected " + all + ", found " + name);
  }
  return found;
}

// The index of a value in a list, to which it is added where it is not there.
template <typename T>
std::size_t index_in(std::vector<T>& list, const T& value) {
  const auto found = std::find(list.begin(), list.end(), value);
  const auto index = static_cast<std::size_t>(found - list.begin());
  if (found == list.end()) list.push_back(value);
  return index;
}

// What is rendered of an eye's receptors, and where it goes. Types differ by where they look, too:
// a fly's eye has a thousand, of few sensitivities and names.
struct Receptors {
  std::vector<std::array<double, rgb_bands>> sensitivities;  // weights of red, green and blue
  std::vector<std::string> names;
  std::vector<std::size_t> sensitivity_of_type, name_of_type;  // [type], indices of those
  std::vector<std::int32_t> view_of_receptor;                  // [receptor]
};

Receptors receptors_of(const Eye& eye) {
  if (eye.receptor_types.empty())
    throw Error("receptors: expected an eye with receptors, found none");
  Receptors receptors;
  for (const ReceptorType& type : eye.receptor_types) {
    receptors.sensitivity_of_type.push_back(
        index_in(receptors.sensitivities, receptor_weights(type)));
    receptors.name_of_type.push_back(index_in(receptors.names, type.name));
  }
  return receptors;
}

class RendererHandle {
 public:
  RendererHandle(const WorldHandle& world, const EyeHandle& eye, const Options& options)
      : eye_(eye.eye), error_(options.error) {
    if (options.receptors) {
      receptors_ = receptors_of(*eye_);
      for (const auto& row : receptors_->sensitivities)
        weights_.insert(weights_.end(), row.begin(), row.end());
      ReceptorViews views = receptor_views(*eye_);
      receptors_->view_of_receptor = std::move(views.view_of_receptor);
      renderer_ = std::make_shared<Renderer>(world.world, std::move(views.eye), options.settings);
    } else {
      renderer_ = std::make_shared<Renderer>(world.world, *eye_, options.settings);
    }
  }

  val info() const {
    return checked([&] {
      val info = val::object();
      const std::vector<std::string> labels =
          receptors_ ? receptors_->names : std::vector<std::string>{"red", "green", "blue"};
      info.set("bands", labels.size());
      info.set("labels", list_of(labels));
      info.set("rays_per_frame",
               static_cast<double>(renderer_->rays_per_frame()) * (error_ ? error_scrambles : 1));
      info.set("threads", renderer_->threads());
      return info;
    });
  }

  val render(const val& world_from_head, double frame) {
    return checked([&] {
      if (!(frame >= 0 && frame <= 9007199254740991.0 && frame == std::floor(frame)))
        throw Error("frame: expected a whole number from 0 on, found " + std::to_string(frame));
      RenderCall call;
      call.first_pose = static_cast<std::uint64_t>(frame);
      call.output_from_band = weights_;
      responses_.resize(renderer_->eye().size() * outputs());
      if (error_) {
        errors_.resize(responses_.size());
        call.standard_error = errors_;
      }
      const Mat4 pose = matrix_of(world_from_head, "world_from_head");
      renderer_->render(std::span<const Mat4>(&pose, 1), responses_, call);
      return array_of(by_ommatidium(responses_));
    });
  }

  val error() const { return errors_.empty() ? val::null() : array_of(by_ommatidium(errors_)); }

 private:
  std::size_t outputs() const { return receptors_ ? receptors_->sensitivities.size() : rgb_bands; }

  // [ommatidium][name] of what views see, NaN where an ommatidium has no receptor of that name; or
  // as they are without receptors.
  std::vector<float> by_ommatidium(const std::vector<float>& seen) const {
    if (!receptors_) return seen;
    const std::size_t names = receptors_->names.size();
    std::vector<float> values(eye_->size() * names, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t i = 0; i < eye_->size(); ++i) {
      const auto first = static_cast<std::size_t>(eye_->first_receptor[i]);
      const auto end = static_cast<std::size_t>(eye_->first_receptor[i + 1]);
      for (std::size_t r = first; r < end; ++r) {
        const auto type = static_cast<std::size_t>(eye_->receptor_type[r]);
        const auto view = static_cast<std::size_t>(receptors_->view_of_receptor[r]);
        values[i * names + receptors_->name_of_type[type]] =
            seen[view * outputs() + receptors_->sensitivity_of_type[type]];
      }
    }
    return values;
  }

  std::shared_ptr<const Eye> eye_;
  std::shared_ptr<Renderer> renderer_;  // of the eye, or of the views of its receptors
  std::optional<Receptors> receptors_;
  std::vector<double> weights_;  // [sensitivity][band] of receptors, or empty
  bool error_;
  std::vector<float> responses_, errors_;  // [ommatidium or view][output]
};

RendererHandle make_renderer(const WorldHandle& world, const EyeHandle& eye, const val& options) {
  return checked([&] { return RendererHandle(world, eye, read_options(options)); });
}

}  // namespace

void bind_renderer() {
  emscripten::class_<WorldHandle>("World");
  emscripten::function("make_world", &make_world);
  emscripten::class_<RendererHandle>("Renderer")
      .function("info", &RendererHandle::info)
      .function("render", &RendererHandle::render)
      .function("error", &RendererHandle::error);
  emscripten::function("make_renderer", &make_renderer);
}

}  // namespace omma::web
