// The renderer and poses for Python. Rendering writes straight into the caller's NumPy memory, with
// the GIL released; the progress callback takes it back a few times a second so that Ctrl-C works.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <variant>

#include "arrays.h"
#include "card_places.h"
#include "moves.h"
#include "omma/pose.h"
#include "omma/render.h"
#include "progress.h"

namespace omma::python {

namespace {

using CountOutput = nb::ndarray<nb::numpy, std::int32_t, nb::ndim<2>, nb::c_contig>;
using RayOutput = nb::ndarray<nb::numpy, float, nb::ndim<4>, nb::c_contig>;

using Matrix = nb::ndarray<nb::numpy, const double, nb::ndim<2>, nb::c_contig>;

void render(const Renderer& renderer, const Poses& poses, const Place& responses,
            const std::optional<Place>& standard_error, const std::optional<CountOutput>& rays,
            const std::optional<RayOutput>& ray_radiance,
            const std::optional<RayOutput>& beside_rays, std::optional<std::uint64_t> first_pose,
            const std::optional<Matrix>& output_from_band, bool stokes,
            const std::optional<MovesTuple>& moves, const nb::object& progress) {
  RenderCall call;
  call.stokes = stokes;
  if (output_from_band)
    call.output_from_band = {output_from_band->data(), output_from_band->size()};
  call.first_pose = first_pose;
  Places places(card_that_writes(renderer, standard_error.has_value()));
  const std::span<float> to = places.add(responses);
  if (standard_error) call.standard_error = places.add(*standard_error);
  if (rays) call.rays = {rays->data(), rays->size()};
  if (ray_radiance) call.ray_radiance = {ray_radiance->data(), ray_radiance->size()};
  if (beside_rays) call.beside_rays = {beside_rays->data(), beside_rays->size()};
  const std::span<const Mat4> world_from_head = matrices_of(poses);
  if (moves) take_moves(*moves, call);
  run_with_progress(progress, [&](const std::function<bool(double)>& report) {
    call.progress = report;
    places.run([&] { renderer.render(world_from_head, to, call); });
  });
}

std::string repr_of(nb::handle object) {
  return str_of(nb::repr(object));
}

void read_option(const char* name, auto& value, nb::handle given) {
  using Value = std::remove_reference_t<decltype(value)>;
  if (nb::try_cast(given, value)) return;
  const char* expected = std::is_same_v<Value, bool> ? "True or False" : "a number in its range";
  throw Error(std::string(name) + ": expected " + expected + ", found " + repr_of(given));
}

void read_option(const char* name, auto& value, nb::handle given, const auto& names) {
  std::string found, known;
  for (const auto& named : names) {
    if (nb::try_cast(given, found) && found == named.name) {
      value = named.value;
      return;
    }
    known += (known.empty() ? "" : ", ") + std::string(named.name);
  }
  throw Error(std::string(name) + ": expected one of " + known + ", found " + repr_of(given));
}

nb::object option_object(const auto& value) {
  return nb::cast(value);
}

nb::object option_object(const auto& value, const auto& names) {
  for (const auto& named : names)
    if (named.value == value) return nb::str(named.name);
  return nb::none();
}

Sampling sampling_of(const nb::tuple& given) {
  const auto holds = [&](const char* kind, auto&... numbers) {
    std::string found;
    std::size_t i = 1;
    return given.size() == 1 + sizeof...(numbers) && nb::try_cast(given[0], found) &&
           found == kind && (nb::try_cast(given[i++], numbers) && ...);
  };
  Fixed fixed;
  ToError to_error;
  Shared shared;
  if (holds("fixed", fixed.samples)) return fixed;
  ToError& e = to_error;
  if (holds("to_error", e.error, e.least, e.most, e.relative_error)) return e;
  if (holds("shared", shared.samples)) return shared;
  throw Error(
      "sampling: expected ('fixed', samples), ('to_error', error, least, most, relative_error) "
      "or ('shared', samples), found " +
      repr_of(given));
}

nb::tuple sampling_tuple(const Fixed& s) {
  return nb::make_tuple("fixed", s.samples);
}
nb::tuple sampling_tuple(const ToError& s) {
  return nb::make_tuple("to_error", s.error, s.least, s.most, s.relative_error);
}
nb::tuple sampling_tuple(const Shared& s) {
  return nb::make_tuple("shared", s.samples);
}

// `options` loses what is read from it.
RenderSettings settings_of(const nb::tuple& sampling, nb::dict options) {
  RenderSettings settings;
  settings.sampling = sampling_of(sampling);
  if (options.contains("eye_sizes")) {
    const nb::object given(options.attr("pop")("eye_sizes"));
    if (!nb::try_cast(given, settings.eye_sizes))
      throw Error("eye_sizes: expected whole numbers, found " + repr_of(given));
  }
  if (options.contains("delays_s")) {
    const nb::object given(options.attr("pop")("delays_s"));
    if (!nb::try_cast(given, settings.delays_s))
      throw Error("delays_s: expected numbers, found " + repr_of(given));
  }
  std::string known;
  for_each_option(settings, [&](const char* name, auto& value, const auto&... names) {
    known += (known.empty() ? "" : ", ") + std::string(name);
    if (options.contains(name))
      read_option(name, value, nb::object(options.attr("pop")(name)), names...);
  });
  for (const auto& [name, value] : options)
    throw Error("options: expected " + known + ", found " + str_of(name));
  return settings;
}

nb::dict options_of(const RenderSettings& settings) {
  nb::dict options;
  for_each_option(settings, [&](const char* name, const auto& value, const auto&... names) {
    options[name] = option_object(value, names...);
  });
  return options;
}

nb::object build_times(const Renderer& renderer) {
  nb::dict times;
  times["scene_s"] = renderer.build_times().scene_s;
  times["acceleration_s"] = renderer.build_times().acceleration_s;
  times["directions_s"] = renderer.build_times().directions_s;
  return times;
}

}  // namespace

void bind_renderer(nb::module_& m) {
  nb::class_<RenderSettings>(m, "RenderSettings", "What `omma.Renderer` was asked for.")
      .def(
          "__init__",
          [](RenderSettings* self, const nb::tuple& sampling, const nb::kwargs& options) {
            new (self) RenderSettings(settings_of(sampling, options));
          },
          nb::kw_only(), nb::arg("sampling"), nb::arg("options"),
          nb::sig("def __init__(self, *, "
                  "sampling: tuple[str, int] | tuple[str, float, int, int, float], "
                  "**options: object) -> None"),
          "``sampling`` is ('fixed', samples), ('to_error', error, least, most, relative_error) "
          "or\n"
          "('shared', samples); the options are those of RenderSettings in omma/render.h.")
      .def_prop_ro(
          "sampling",
          [](const RenderSettings& s) {
            return std::visit([](const auto& chosen) { return sampling_tuple(chosen); },
                              s.sampling);
          },
          nb::for_getter(nb::sig("def sampling(self, /) -> tuple[typing.Any, ...]")))
      .def_prop_ro("options", &options_of,
                   nb::for_getter(nb::sig("def options(self, /) -> dict[str, typing.Any]")));

  nb::class_<Renderer>(m, "Renderer", "The engine; `omma.Renderer` is the one to use.")
      .def(
          "__init__",
          [](Renderer* self, const World& world, const Eye& eye, const RenderSettings& settings) {
            run_long_work([&] { new (self) Renderer(world, eye, settings); });
          },
          nb::arg("world"), nb::arg("eye"), nb::arg("settings"))
      .def(
          "__init__",
          [](Renderer* self, const Renderer& same_world, const Eye& eye,
             const RenderSettings& settings) {
            run_long_work([&] { new (self) Renderer(same_world, eye, settings); });
          },
          nb::arg("same_world"), nb::arg("eye"), nb::arg("settings"))
      .def(
          "__init__",
          [](Renderer* self, const Renderer& same_eye, const World& world) {
            run_long_work([&] { new (self) Renderer(same_eye, world); });
          },
          nb::arg("same_eye"), nb::arg("world"))
      .def("render", &render, nb::arg("poses").noconvert(), nb::arg("responses").noconvert(),
           nb::arg("standard_error").noconvert().none(), nb::arg("rays").noconvert().none(),
           nb::arg("ray_radiance").noconvert().none(), nb::arg("beside_rays").noconvert().none(),
           nb::arg("first_pose").none(), nb::arg("output_from_band").noconvert().none(),
           nb::arg("stokes"), nb::arg("moves").none(), nb::arg("progress").none(),
           nb::sig("def render(self, poses: numpy.typing.NDArray[numpy.float64], responses: "
                   "numpy.typing.NDArray[numpy.float32] | CardSpan, standard_error: "
                   "numpy.typing.NDArray[numpy.float32] | CardSpan | None, rays: "
                   "numpy.typing.NDArray[numpy.int32] | None, ray_radiance: "
                   "numpy.typing.NDArray[numpy.float32] | None, beside_rays: "
                   "numpy.typing.NDArray[numpy.float32] | None, first_pose: int | None, "
                   "output_from_band: numpy.typing.NDArray[numpy.float64] | None, stokes: bool, "
                   "moves: omma.rendering.moves.EngineMoves | None, progress: "
                   "collections.abc.Callable[[float], object] | None) -> None"))
      .def(
          "ray_directions",
          [](const Renderer& renderer, const Poses& poses, std::uint64_t first_pose,
             const RayOutput& directions) {
            const std::span<const Mat4> world_from_head = matrices_of(poses);
            const std::span<float> to{directions.data(), directions.size()};
            const nb::gil_scoped_release released;
            renderer.ray_directions(world_from_head, first_pose, to);
          },
          nb::arg("poses").noconvert(), nb::arg("first_pose"), nb::arg("directions").noconvert(),
          nb::sig("def ray_directions(self, poses: numpy.typing.NDArray[numpy.float64], "
                  "first_pose: int, directions: numpy.typing.NDArray[numpy.float32]) -> None"))
      .def(
          "precision_warning",
          [](const Renderer& renderer, const Poses& poses) {
            return renderer.precision_warning(matrices_of(poses));
          },
          nb::arg("poses").noconvert(),
          nb::sig("def precision_warning(self, poses: numpy.typing.NDArray[numpy.float64]) -> str"))
      .def(
          "pose_slip",
          [](const Renderer& renderer, const Poses& poses) {
            return renderer.world().pose_slip(matrices_of(poses));
          },
          nb::arg("poses").noconvert(),
          nb::sig("def pose_slip(self, poses: numpy.typing.NDArray[numpy.float64]) -> str"))
      .def_prop_ro("eye", &Renderer::eye, nb::rv_policy::reference_internal)
      .def_prop_ro("settings", &Renderer::settings, nb::rv_policy::reference_internal)
      .def_prop_ro("bands", [](const Renderer& r) { return r.world().bands(); })
      .def_prop_ro("threads", &Renderer::threads)
      .def_prop_ro("rays_per_frame", &Renderer::rays_per_frame)
      .def_prop_ro(
          "shared_ommatidia",
          [](const Renderer& renderer) {
            const std::vector<char> shared = renderer.shared_ommatidia();
            std::vector<std::uint8_t> values(shared.begin(), shared.end());
            const std::size_t size = values.size();
            return take(std::move(values), {size});
          },
          nb::for_getter(
              nb::sig("def shared_ommatidia(self, /) -> numpy.typing.NDArray[numpy.uint8]")))
      .def_prop_ro("backend", &Renderer::backend)
      .def_prop_ro("build_times", &build_times,
                   nb::for_getter(nb::sig("def build_times(self, /) -> dict[str, float]")));

  m.attr("rgb_bands") = rgb_bands;
  m.attr("most_bands") = most_bands;
  m.attr("error_scrambles") = error_scrambles;
  m.def(
      "look_at",
      [](nb::handle position, nb::handle target, nb::handle up) {
        return matrix_array(
            look_at(vec3d(position, "position_m"), vec3d(target, "target_m"), vec3d(up, "up")));
      },
      nb::arg("position_m"), nb::arg("target_m"), nb::arg("up") = nb::make_tuple(0.0, 1.0, 0.0),
      nb::sig("def look_at(position_m: numpy.typing.ArrayLike, target_m: numpy.typing.ArrayLike, "
              "up: numpy.typing.ArrayLike = (0.0, 1.0, 0.0)) -> "
              "numpy.typing.NDArray[numpy.float64]"),
      "The pose ``world_from_head`` of a head at a position (3,), m, that looks towards a target\n"
      "(3,), m, with ``up`` roughly up: (4, 4) float64.\n\n"
      "Raises `omma.Error` where the target is the position or ``up`` is along the view.");
}

}  // namespace omma::python
