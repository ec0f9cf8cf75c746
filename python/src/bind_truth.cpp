// Renders with ground truth for Python (omma/truth.h): straight into the caller's NumPy memory.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>

#include <optional>
#include <span>

#include "arrays.h"
#include "moves.h"
#include "omma/render.h"
#include "progress.h"

namespace omma::python {

namespace {

// The memory of an array of this name; empty where there is none.
template <typename T>
std::span<T> memory_of(const nb::dict& arrays, const char* name) {
  if (!arrays.contains(name)) return {};
  const auto array = nb::cast<nb::ndarray<nb::numpy, T, nb::c_contig>>(arrays[name], false);
  return {array.data(), array.size()};
}

// An array [.., linear and angular] of so many rows of six.
std::span<const Velocity> velocities_of(const nb::dict& arrays, const char* name) {
  static_assert(sizeof(Velocity) == 6 * sizeof(double));
  const std::span<const double> numbers = memory_of<const double>(arrays, name);
  return {reinterpret_cast<const Velocity*>(numbers.data()), numbers.size() / 6};
}

void render_truth(const Renderer& renderer, const Poses& poses, const nb::dict& arrays,
                  std::optional<std::uint64_t> first_pose, const std::optional<MovesTuple>& moves,
                  const nb::object& progress) {
  RenderCall call;
  call.first_pose = first_pose;
  call.standard_error = memory_of<float>(arrays, "standard_error");
  call.rays = memory_of<std::int32_t>(arrays, "rays");
  TruthCall& truth = call.truth;
  truth.distance_m = memory_of<float>(arrays, "distance_m");
  truth.nearest_m = memory_of<float>(arrays, "nearest_m");
  truth.inverse_distance_per_m = memory_of<float>(arrays, "inverse_distance_per_m");
  truth.met = memory_of<float>(arrays, "met");
  truth.source_distance_m = memory_of<float>(arrays, "source_distance_m");
  truth.position_m = memory_of<double>(arrays, "position_m");
  truth.normal = memory_of<float>(arrays, "normal");
  truth.shares = memory_of<float>(arrays, "shares");
  truth.share_of_instance = memory_of<const std::int32_t>(arrays, "share_of_instance");
  if (!truth.share_of_instance.empty())
    truth.share_count = nb::cast<int>(nb::object(arrays["shares"].attr("shape")[-1]));
  truth.flow_rotation = memory_of<float>(arrays, "flow_rotation_rad_s");
  truth.flow_translation = memory_of<float>(arrays, "flow_translation_rad_s");
  truth.flow_objects = memory_of<float>(arrays, "flow_objects_rad_s");
  truth.head = velocities_of(arrays, "head");
  truth.moving = memory_of<const std::int32_t>(arrays, "moving");
  truth.objects = velocities_of(arrays, "objects");
  const std::span<float> responses = memory_of<float>(arrays, "responses");
  if (moves) take_moves(*moves, call);
  run_with_progress(progress, [&](const std::function<bool(double)>& report) {
    call.progress = report;
    renderer.render(matrices_of(poses), responses, call);
  });
}

}  // namespace

void bind_truth(nb::module_& m) {
  m.def("render_truth", &render_truth, nb::arg("renderer"), nb::arg("poses").noconvert(),
        nb::arg("arrays"), nb::arg("first_pose").none(), nb::arg("moves").none(),
        nb::arg("progress").none(),
        nb::sig("def render_truth(renderer: Renderer, poses: "
                "numpy.typing.NDArray[numpy.float64], arrays: dict[str, "
                "numpy.typing.NDArray[typing.Any]], first_pose: int | None, moves: "
                "omma.rendering.moves.EngineMoves | None, progress: "
                "collections.abc.Callable[[float], object] | None) -> None"),
        "Responses and ground truth, into arrays by name: those of `omma.rendering.GroundTruth`,\n"
        "and what it is asked with; see omma/truth.h.");
}

}  // namespace omma::python
