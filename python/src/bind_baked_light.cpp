// Baked light for Python: made by the engine, or of arrays that a file has kept.
#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "arrays.h"
#include "omma/bake.h"
#include "omma/error.h"
#include "omma/world.h"
#include "progress.h"

namespace omma::python {

namespace {

using Values = nb::ndarray<nb::numpy, const std::uint16_t, nb::shape<-1, 2, -1>, nb::c_contig>;
using ProbeValues =
    nb::ndarray<nb::numpy, const std::uint16_t, nb::shape<-1, -1, -1, 6, -1>, nb::c_contig>;
using Indices = nb::ndarray<nb::numpy, const std::int32_t, nb::shape<-1>, nb::c_contig>;

std::vector<std::int32_t> vector_of(const Indices& array) {
  return {array.data(), array.data() + array.size()};
}

void make_baked_light(BakedLight* self, double unit, const Values& values,
                                             const Indices& first_cell,
                                             const std::vector<Indices>& cell_of_triangle,
                                             nb::handle probe_origin_m, nb::handle probe_spacing_m,
                                             const ProbeValues& probe_values, double cell_m,
                                             int paths, std::int64_t by_probes, double seconds) {
  constexpr std::size_t most = 1u << 30;
  if (values.shape(0) > most || values.shape(2) != probe_values.shape(4))
    throw Error("baked light: expected at most 2^30 cells, and as many bands of probes as of cells");
  BakedLight baked;
  baked.bands = static_cast<int>(values.shape(2));
  baked.unit = unit;
  baked.first_cell = vector_of(first_cell);
  for (const Indices& first : cell_of_triangle) baked.cell_of_triangle.push_back(vector_of(first));
  baked.cells = static_cast<std::int32_t>(values.shape(0));
  const std::size_t bytes = values.size() * sizeof(std::uint16_t);
  baked.lines.resize((bytes + sizeof(BakedLine) - 1) / sizeof(BakedLine));
  if (bytes > 0) std::memcpy(baked.lines.data(), values.data(), bytes);
  const auto origin = double_array(probe_origin_m, "probe_origin_m", {3});
  const auto spacing = double_array(probe_spacing_m, "probe_spacing_m", {3});
  for (std::size_t a = 0; a < 3; ++a) {
    baked.probe_origin_m[a] = static_cast<float>(origin.data()[a]);
    baked.probe_spacing_m[a] = static_cast<float>(spacing.data()[a]);
    baked.probes[a] = static_cast<std::int32_t>(std::min(probe_values.shape(2 - a), most));
  }
  baked.probe_values.assign(probe_values.data(), probe_values.data() + probe_values.size());
  baked.cell_m = cell_m;
  baked.paths = paths;
  baked.by_probes = by_probes;
  baked.seconds = seconds;
  new (self) BakedLight(std::move(baked));
}

nb::object doubles(const float (&values)[3]) {
  return take(std::vector<double>(values, values + 3), {3});
}

nb::object values_of(nb::handle self) {
  const auto& baked = nb::cast<const BakedLight&>(self);
  const std::uint16_t* first = baked.lines.empty() ? nullptr : baked.lines.front().values;
  return view(self, first,
              {static_cast<std::size_t>(baked.cells), 2, static_cast<std::size_t>(baked.bands)});
}

nb::object first_cell_of(nb::handle self) {
  const auto& first = nb::cast<const BakedLight&>(self).first_cell;
  return view(self, first.data(), {first.size()});
}

nb::list cell_of_triangle_of(nb::handle self) {
  nb::list arrays;
  for (const std::vector<std::int32_t>& first : nb::cast<const BakedLight&>(self).cell_of_triangle)
    arrays.append(view(self, first.data(), {first.size()}));
  return arrays;
}

nb::object probe_values_of(nb::handle self) {
  const auto& baked = nb::cast<const BakedLight&>(self);
  return view(self, baked.probe_values.data(),
              {static_cast<std::size_t>(baked.probes[2]), static_cast<std::size_t>(baked.probes[1]),
               static_cast<std::size_t>(baked.probes[0]), 6,
               static_cast<std::size_t>(baked.bands)});
}

}  // namespace

void bind_baked_light(nb::module_& m) {
  nb::class_<BakedLight>(m, "BakedLight", "Light that was baked, as the engine reads it.")
      .def("__init__", &make_baked_light, nb::arg("unit"), nb::arg("values").noconvert(),
           nb::arg("first_cell").noconvert(), nb::arg("cell_of_triangle"),
           nb::arg("probe_origin_m"), nb::arg("probe_spacing_m"),
           nb::arg("probe_values").noconvert(), nb::arg("cell_m"), nb::arg("paths"),
           nb::arg("by_probes"), nb::arg("seconds"),
           nb::sig("def __init__(self, unit: float, values: numpy.typing.NDArray[numpy.uint16], "
                   "first_cell: numpy.typing.NDArray[numpy.int32], cell_of_triangle: "
                   "collections.abc.Sequence[numpy.typing.NDArray[numpy.int32]], probe_origin_m: "
                   "numpy.typing.ArrayLike, probe_spacing_m: numpy.typing.ArrayLike, probe_values: "
                   "numpy.typing.NDArray[numpy.uint16], cell_m: float, paths: int, by_probes: int, "
                   "seconds: float) -> None"))
      .def_ro("unit", &BakedLight::unit)
      .def_ro("cell_m", &BakedLight::cell_m)
      .def_ro("cells", &BakedLight::cells)
      .def_ro("paths", &BakedLight::paths)
      .def_ro("by_probes", &BakedLight::by_probes)
      .def_ro("seconds", &BakedLight::seconds)
      .def_prop_ro("bytes", &BakedLight::bytes)
      .def_prop_ro("values", &values_of,
                   nb::for_getter(nb::sig("def values(self, /) -> "
                                          "numpy.typing.NDArray[numpy.uint16]")))
      .def_prop_ro("first_cell", &first_cell_of,
                   nb::for_getter(nb::sig("def first_cell(self, /) -> "
                                          "numpy.typing.NDArray[numpy.int32]")))
      .def_prop_ro("cell_of_triangle", &cell_of_triangle_of,
                   nb::for_getter(nb::sig("def cell_of_triangle(self, /) -> "
                                          "list[numpy.typing.NDArray[numpy.int32]]")))
      .def_prop_ro("probe_origin_m",
                   [](const BakedLight& baked) { return doubles(baked.probe_origin_m); },
                   nb::for_getter(nb::sig("def probe_origin_m(self, /) -> "
                                          "numpy.typing.NDArray[numpy.float64]")))
      .def_prop_ro("probe_spacing_m",
                   [](const BakedLight& baked) { return doubles(baked.probe_spacing_m); },
                   nb::for_getter(nb::sig("def probe_spacing_m(self, /) -> "
                                          "numpy.typing.NDArray[numpy.float64]")))
      .def_prop_ro("probe_values", &probe_values_of,
                   nb::for_getter(nb::sig("def probe_values(self, /) -> "
                                          "numpy.typing.NDArray[numpy.uint16]")));

  m.def(
      "bake_light",
      [](const World& world, double cell_m, int paths, std::size_t most_bytes,
         const nb::object& progress) {
        std::shared_ptr<BakedLight> baked;
        run_with_progress(progress, [&](const std::function<bool(double)>& report) {
          baked = std::make_shared<BakedLight>(
              bake_light(world, {cell_m, paths, most_bytes}, report));
        });
        return baked;
      },
      nb::arg("world"), nb::arg("cell_m"), nb::arg("paths"), nb::arg("most_bytes"),
      nb::arg("progress").none(),
      nb::sig("def bake_light(world: World, cell_m: float, paths: int, most_bytes: int, progress: "
              "collections.abc.Callable[[float], object] | None) -> BakedLight"));
}

}  // namespace omma::python
