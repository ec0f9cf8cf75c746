// The renderer and poses for Python. Rendering writes straight into the caller's NumPy memory, with
// the GIL released; the progress callback takes it back a few times a second so that Ctrl-C works.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <optional>
#include <span>

#include "arrays.h"
#include "omma/pose.h"
#include "omma/render.h"
#include "progress.h"

namespace omma::python {

namespace {

constexpr std::pair<const char*, std::optional<Kernel>> kernels[] = {
    {"own", std::nullopt},
    {"gaussian", Kernel::gaussian},
    {"pillbox", Kernel::pillbox},
    {"compoundray", Kernel::compoundray}};
constexpr std::pair<const char*, Sampling> samplings[] = {
    {"low_discrepancy", Sampling::low_discrepancy}, {"random", Sampling::random}};
constexpr std::pair<const char*, Noise> noises[] = {{"frozen", Noise::frozen},
                                                    {"new_every_frame", Noise::new_every_frame}};

template <typename Table>
auto by_name(const Table& table, const std::string& name, const std::string& argument) {
  std::string names;
  for (const auto& [known, value] : table) {
    if (name == known) return value;
    names += (names.empty() ? "" : ", ") + std::string(known);
  }
  throw Error(argument + ": expected one of " + names + ", found '" + name + "'");
}

template <typename Table, typename Value>
const char* name_of(const Table& table, Value wanted) {
  for (const auto& [known, value] : table)
    if (value == wanted) return known;
  return "";
}

using Poses = nb::ndarray<nb::numpy, const double, nb::shape<-1, 4, 4>, nb::c_contig>;
using Output = nb::ndarray<nb::numpy, float, nb::ndim<3>, nb::c_contig>;
using CountOutput = nb::ndarray<nb::numpy, std::int32_t, nb::ndim<2>, nb::c_contig>;
using RayOutput = nb::ndarray<nb::numpy, float, nb::ndim<4>, nb::c_contig>;

using Matrix = nb::ndarray<nb::numpy, const double, nb::ndim<2>, nb::c_contig>;

std::span<float> span_of(const Output& output) {
  return {output.data(), output.size()};
}

void render(const Renderer& renderer, const Poses& poses, const Output& responses,
            const std::optional<Output>& standard_error, const std::optional<CountOutput>& rays,
            const std::optional<RayOutput>& ray_radiance, std::optional<std::uint64_t> first_pose,
            const std::optional<Matrix>& output_from_band, const nb::object& progress) {
  RenderCall call;
  if (output_from_band)
    call.output_from_band = {output_from_band->data(), output_from_band->size()};
  call.first_pose = first_pose;
  if (standard_error) call.standard_error = span_of(*standard_error);
  if (rays) call.rays = {rays->data(), rays->size()};
  if (ray_radiance) call.ray_radiance = {ray_radiance->data(), ray_radiance->size()};
  // The memory of a C-ordered (4, 4) float64 array is that of a Mat4.
  const std::span<const Mat4> world_from_head(reinterpret_cast<const Mat4*>(poses.data()),
                                              poses.shape(0));
  run_with_progress(progress, [&](const std::function<bool(double)>& report) {
    call.progress = report;
    renderer.render(world_from_head, span_of(responses), call);
  });
}

RenderSettings settings_of(int samples, std::uint64_t seed, const std::string& kernel,
                           const std::string& sampling, int threads, bool footprints,
                           bool share_rays, const std::string& noise, double error,
                           int most_samples) {
  RenderSettings settings;
  settings.samples = samples;
  settings.seed = seed;
  settings.kernel = by_name(kernels, kernel, "kernel");
  settings.sampling = by_name(samplings, sampling, "sampling");
  settings.threads = threads;
  settings.noise = by_name(noises, noise, "noise");
  settings.footprints = footprints;
  settings.share_rays = share_rays;
  settings.error = error;
  settings.most_samples = most_samples;
  return settings;
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
          [](RenderSettings* self, int samples, std::uint64_t seed, const std::string& kernel,
             const std::string& sampling, int threads, bool footprints, bool share_rays,
             const std::string& noise, double error, int most_samples) {
            new (self)
                RenderSettings(settings_of(samples, seed, kernel, sampling, threads, footprints,
                                           share_rays, noise, error, most_samples));
          },
          nb::kw_only(), nb::arg("samples"), nb::arg("seed"), nb::arg("kernel"),
          nb::arg("sampling"), nb::arg("threads"), nb::arg("footprints"), nb::arg("share_rays"),
          nb::arg("noise"), nb::arg("error"), nb::arg("most_samples"))
      .def_ro("samples", &RenderSettings::samples)
      .def_ro("seed", &RenderSettings::seed)
      .def_prop_ro("kernel", [](const RenderSettings& s) { return name_of(kernels, s.kernel); })
      .def_prop_ro("sampling",
                   [](const RenderSettings& s) { return name_of(samplings, s.sampling); })
      .def_ro("footprints", &RenderSettings::footprints)
      .def_ro("share_rays", &RenderSettings::share_rays)
      .def_prop_ro("noise", [](const RenderSettings& s) { return name_of(noises, s.noise); })
      .def_ro("error", &RenderSettings::error)
      .def_ro("most_samples", &RenderSettings::most_samples);

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
      .def("render", &render, nb::arg("poses").noconvert(), nb::arg("responses").noconvert(),
           nb::arg("standard_error").noconvert().none(), nb::arg("rays").noconvert().none(),
           nb::arg("ray_radiance").noconvert().none(), nb::arg("first_pose").none(),
           nb::arg("output_from_band").noconvert().none(), nb::arg("progress").none(),
           nb::sig("def render(self, poses: numpy.typing.NDArray[numpy.float64], responses: "
                   "numpy.typing.NDArray[numpy.float32], standard_error: "
                   "numpy.typing.NDArray[numpy.float32] | None, rays: "
                   "numpy.typing.NDArray[numpy.int32] | None, ray_radiance: "
                   "numpy.typing.NDArray[numpy.float32] | None, first_pose: int | None, "
                   "output_from_band: numpy.typing.NDArray[numpy.float64] | None, progress: "
                   "collections.abc.Callable[[float], object] | None) -> None"))
      .def(
          "precision_warning",
          [](const Renderer& renderer, const Poses& poses) {
            return renderer.precision_warning(
                {reinterpret_cast<const Mat4*>(poses.data()), poses.shape(0)});
          },
          nb::arg("poses").noconvert(),
          nb::sig("def precision_warning(self, poses: numpy.typing.NDArray[numpy.float64]) -> str"))
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
