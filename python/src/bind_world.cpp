// The world for Python: built and moved with the GIL released.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "arrays.h"
#include "moves.h"
#include "omma/world.h"
#include "progress.h"
#include "struct_values.h"

namespace omma::python {

namespace {

using Vectors = nb::ndarray<nb::numpy, const float, nb::shape<-1, 3>, nb::c_contig>;

std::span<const Vec3> vectors_of(const Vectors& vectors) {
  return {reinterpret_cast<const Vec3*>(vectors.data()), vectors.shape(0)};
}

nb::object vectors_array(const std::vector<Vec3>& vectors) {
  const auto* floats = reinterpret_cast<const float*>(vectors.data());
  return take(std::vector<float>(floats, floats + 3 * vectors.size()), {vectors.size(), 3});
}

using LightingTuple =
    std::tuple<Light, int, bool, std::optional<std::shared_ptr<BakedLight>>, bool>;

Lighting lighting_of(const LightingTuple& given) {
  const auto& [light, depth, polarized, baked, sun_map] = given;
  return {light, depth, polarized, baked.value_or(nullptr), sun_map};
}

nb::object build_times(const World& world) {
  nb::dict times;
  times["scene_s"] = world.build_times().scene_s;
  times["acceleration_s"] = world.build_times().acceleration_s;
  return times;
}

}  // namespace

void bind_world(nb::module_& m) {
  nb::class_<WorldInstance> instance_class(m, "WorldInstance",
                                           "Something in a world that can be moved.");
  instance_class
      .def_ro("name", &WorldInstance::name,
              "Of its node in the file; others may have the same one.")
      .def_prop_ro(
          "world_from_node",
          [](const WorldInstance& instance) { return matrix_array(instance.world_from_node); },
          nb::for_getter(nb::sig("def world_from_node(self, /) -> "
                                 "numpy.typing.NDArray[numpy.float64]")),
          "Where it was when it was asked for: (4, 4), m.")
      .def("__repr__", [](const WorldInstance& instance) {
        return "<omma.scene.WorldInstance '" + instance.name + "'>";
      });
  def_struct_value(
      instance_class, [](const WorldInstance&) {},
      [](const WorldInstance& value) { return std::hash<std::string>{}(value.name); });

  nb::class_<World>(m, "World", "The engine's world; `omma.World` is the one to use.")
      .def(
          "__init__",
          [](World* self, std::shared_ptr<Scene> scene, int threads,
             std::optional<Background> background, std::string backend, std::vector<int> devices,
             std::vector<double> band_from_rgb, const std::optional<LightingTuple>& lighting,
             const nb::object& progress) {
            WorldSettings settings{threads,
                                   std::move(background),
                                   std::move(backend),
                                   std::move(devices),
                                   std::move(band_from_rgb),
                                   std::nullopt};
            if (lighting) settings.lighting = lighting_of(*lighting);
            run_with_progress(progress, [&](const std::function<bool(double)>& report) {
              new (self) World(std::move(scene), std::move(settings), report);
            });
          },
          nb::arg("scene"), nb::arg("threads"), nb::arg("background").none(), nb::arg("backend"),
          nb::arg("devices"), nb::arg("band_from_rgb"), nb::arg("lighting").none(),
          nb::arg("progress").none())
      .def(
          "with_lighting",
          [](const World& world, const LightingTuple& lighting) {
            Lighting given = lighting_of(lighting);
            return run_long([&] { return world.with_lighting(std::move(given)); });
          },
          nb::arg("lighting"))
      .def(
          "with_background",
          [](const World& world, const Background& background) {
            return run_long([&] { return world.with_background(background); });
          },
          nb::arg("background"))
      .def_prop_ro("instances", &World::instances)
      .def("find_instance", &World::find_instance, nb::arg("name"))
      .def(
          "set_transforms",
          [](World& world, const Indices& instances, const Poses& transforms,
             const nb::object& progress) {
            run_with_progress(progress, [&](const std::function<bool(double)>& report) {
              world.set_transforms({instances.data(), instances.size()}, matrices_of(transforms),
                                   report);
            });
          },
          nb::arg("instances").noconvert(), nb::arg("transforms").noconvert(),
          nb::arg("progress").none(),
          nb::sig("def set_transforms(self, instances: numpy.typing.NDArray[numpy.int32], "
                  "transforms: numpy.typing.NDArray[numpy.float64], progress: "
                  "collections.abc.Callable[[float], object] | None) -> None"))
      .def(
          "set_vertices",
          [](World& world, int mesh, const Vectors& positions,
             const std::optional<Vectors>& normals, const nb::object& progress) {
            run_with_progress(progress, [&](const std::function<bool(double)>& report) {
              world.set_vertices(mesh, vectors_of(positions),
                                 normals ? vectors_of(*normals) : std::span<const Vec3>(), report);
            });
          },
          nb::arg("mesh"), nb::arg("positions_m").noconvert(), nb::arg("normals").none(),
          nb::arg("progress").none(),
          nb::sig("def set_vertices(self, mesh: int, positions_m: "
                  "numpy.typing.NDArray[numpy.float32], normals: "
                  "numpy.typing.NDArray[numpy.float32] | None, progress: "
                  "collections.abc.Callable[[float], object] | None) -> None"))
      .def("set_image", &World::set_image, nb::arg("image"), nb::arg("picture"))
      .def(
          "set_color",
          [](World& world, int material, std::array<float, 3> base, std::array<float, 3> emissive) {
            world.set_color(material, {base[0], base[1], base[2]},
                            {emissive[0], emissive[1], emissive[2]});
          },
          nb::arg("material"), nb::arg("base_color"), nb::arg("emissive"))
      .def_prop_ro("animated", &World::animated)
      .def(
          "animated_at",
          [](const World& world, double time_s, const Indices& animations) {
            const std::vector<Mat4> there =
                world.animated_at(time_s, {animations.data(), animations.size()});
            std::vector<double> numbers(there.size() * 16);
            std::memcpy(numbers.data(), there.data(), there.size() * sizeof(Mat4));
            return take(std::move(numbers), {there.size(), 4, 4});
          },
          nb::arg("time_s"), nb::arg("animations").noconvert(),
          nb::sig("def animated_at(self, time_s: float, animations: "
                  "numpy.typing.NDArray[numpy.int32]) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro("reshaped", &World::reshaped)
      .def(
          "positions",
          [](const World& world, int mesh) { return vectors_array(world.positions(mesh)); },
          nb::arg("mesh"),
          nb::sig("def positions(self, mesh: int) -> numpy.typing.NDArray[numpy.float32]"))
      .def(
          "normals",
          [](const World& world, int mesh) { return vectors_array(world.normals(mesh)); },
          nb::arg("mesh"),
          nb::sig("def normals(self, mesh: int) -> numpy.typing.NDArray[numpy.float32]"))
      .def(
          "set_time",
          [](World& world, double time_s, const Indices& animations, const nb::object& progress) {
            run_with_progress(progress, [&](const std::function<bool(double)>& report) {
              world.set_time(time_s, {animations.data(), animations.size()}, report);
            });
          },
          nb::arg("time_s"), nb::arg("animations").noconvert(), nb::arg("progress").none(),
          nb::sig("def set_time(self, time_s: float, animations: "
                  "numpy.typing.NDArray[numpy.int32], progress: "
                  "collections.abc.Callable[[float], object] | None) -> None"))
      .def(
          "precision_warning",
          [](const World& world, const Poses& poses) {
            return world.precision_warning(matrices_of(poses));
          },
          nb::arg("poses").noconvert(),
          nb::sig("def precision_warning(self, poses: numpy.typing.NDArray[numpy.float64]) -> str"))
      .def(
          "pose_slip",
          [](const World& world, const Poses& poses) {
            return world.pose_slip(matrices_of(poses));
          },
          nb::arg("poses").noconvert(),
          nb::sig("def pose_slip(self, poses: numpy.typing.NDArray[numpy.float64]) -> str"))
      .def_prop_ro("bands", &World::bands)
      .def_prop_ro("components", &World::components)
      .def_prop_ro("threads", &World::threads)
      .def_prop_ro("backend", &World::backend)
      .def_prop_ro("build_times", &build_times,
                   nb::for_getter(nb::sig("def build_times(self, /) -> dict[str, float]")));
}

}  // namespace omma::python
