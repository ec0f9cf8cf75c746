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
#include "model/long_work.h"
#include "omma/bake.h"
#include "omma/error.h"
#include "omma/world.h"
#include "progress.h"

namespace omma::python {

namespace {

using Values = nb::ndarray<nb::numpy, const std::uint16_t, nb::shape<-1, 2, -1>, nb::c_contig>;
// CellError, a number each.
using Errors = nb::ndarray<nb::numpy, const std::uint32_t, nb::shape<-1, 2>, nb::c_contig>;
static_assert(sizeof(CellError) == sizeof(std::uint32_t));
using ProbeValues =
    nb::ndarray<nb::numpy, const std::uint16_t, nb::shape<-1, -1, -1, 6, -1>, nb::c_contig>;
using Indices = nb::ndarray<nb::numpy, const std::int32_t, nb::shape<-1>, nb::c_contig>;

std::vector<std::int32_t> vector_of(const Indices& array) {
  return {array.data(), array.data() + array.size()};
}

void make_baked_light(BakedLight* self, double unit, const Values& values, const Errors& errors,
                      const Indices& first_cell, const std::vector<Indices>& cell_of_triangle,
                      nb::handle probe_origin_m, nb::handle probe_spacing_m,
                      const ProbeValues& probe_values, const std::vector<double>& numbers) {
  constexpr std::size_t most = 1u << 30;
  if (values.shape(0) > most || values.shape(2) != probe_values.shape(4))
    throw Error("baked light: expected at most 2^30 cells, and as many bands of probes as of cells");
  if (errors.shape(0) != values.shape(0) || numbers.size() != 6)
    throw Error("baked light: expected errors of all cells, and six numbers");
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
  baked.errors.resize(errors.size());
  if (errors.size() > 0)
    std::memcpy(static_cast<void*>(baked.errors.data()), errors.data(),
                errors.size() * sizeof(CellError));
  baked.cell_m = numbers[0];
  baked.paths = numbers[1];
  baked.by_probes = static_cast<std::int64_t>(numbers[2]);
  baked.seconds = numbers[3];
  baked.error_median = numbers[4];
  baked.error_95 = numbers[5];
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

nb::object errors_of(nb::handle self) {
  const auto& baked = nb::cast<const BakedLight&>(self);
  return view(self, reinterpret_cast<const std::uint32_t*>(baked.errors.data()),
              {static_cast<std::size_t>(baked.cells), 2});
}

nb::list numbers_of(const BakedLight& baked) {
  nb::list numbers;
  for (const double x : {baked.cell_m, baked.paths, static_cast<double>(baked.by_probes),
                         baked.seconds, baked.error_median, baked.error_95})
    numbers.append(x);
  return numbers;
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

using Bytes = nb::ndarray<nb::numpy, const std::uint8_t, nb::shape<-1>, nb::c_contig>;
using Codes = nb::ndarray<nb::numpy, const std::uint16_t, nb::shape<-1>, nb::c_contig>;

void make_unfinished(UnfinishedBake* self, const std::vector<double>& numbers, const Bytes& done,
                     const std::vector<Codes>& lines, const Codes& paths_of_group) {
  if (numbers.size() != 4 || lines.size() != 4)
    throw Error("unfinished bake: expected four numbers and four arrays of lines");
  UnfinishedBake bake;
  bake.pass = static_cast<int>(numbers[0]);
  bake.gathers = numbers[1] > 0;
  bake.unit = numbers[2];
  bake.seconds = numbers[3];
  bake.done.assign(done.data(), done.data() + done.size());
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t bytes = lines[k].size() * sizeof(std::uint16_t);
    bake.lines[k].resize(bytes / sizeof(BakedLine));
    if (!bake.lines[k].empty())
      std::memcpy(bake.lines[k].data(), lines[k].data(), bake.lines[k].size() * sizeof(BakedLine));
  }
  bake.paths_of_group.assign(paths_of_group.data(), paths_of_group.data() + paths_of_group.size());
  new (self) UnfinishedBake(std::move(bake));
}

nb::list lines_of(nb::handle self) {
  nb::list arrays;
  for (const std::vector<BakedLine>& lines : nb::cast<const UnfinishedBake&>(self).lines)
    arrays.append(view(self, lines.empty() ? nullptr : lines.front().values,
                       {lines.size() * sizeof(BakedLine) / sizeof(std::uint16_t)}));
  return arrays;
}

}  // namespace

void bind_baked_light(nb::module_& m) {
  nb::class_<BakedLight>(m, "BakedLight", "Light that was baked, as the engine reads it.")
      .def("__init__", &make_baked_light, nb::arg("unit"), nb::arg("values").noconvert(),
           nb::arg("errors").noconvert(), nb::arg("first_cell").noconvert(),
           nb::arg("cell_of_triangle"), nb::arg("probe_origin_m"), nb::arg("probe_spacing_m"),
           nb::arg("probe_values").noconvert(), nb::arg("numbers"),
           nb::sig("def __init__(self, unit: float, values: numpy.typing.NDArray[numpy.uint16], "
                   "errors: numpy.typing.NDArray[numpy.uint32], "
                   "first_cell: numpy.typing.NDArray[numpy.int32], cell_of_triangle: "
                   "collections.abc.Sequence[numpy.typing.NDArray[numpy.int32]], probe_origin_m: "
                   "numpy.typing.ArrayLike, probe_spacing_m: numpy.typing.ArrayLike, probe_values: "
                   "numpy.typing.NDArray[numpy.uint16], numbers: "
                   "collections.abc.Sequence[float]) -> None"))
      .def_ro("unit", &BakedLight::unit)
      .def_ro("cell_m", &BakedLight::cell_m)
      .def_ro("cells", &BakedLight::cells)
      .def_ro("paths", &BakedLight::paths)
      .def_ro("by_probes", &BakedLight::by_probes)
      .def_ro("seconds", &BakedLight::seconds)
      .def_ro("error_median", &BakedLight::error_median)
      .def_ro("error_95", &BakedLight::error_95)
      .def_prop_ro("numbers", &numbers_of,
                   nb::for_getter(nb::sig("def numbers(self, /) -> list[float]")))
      .def_prop_ro("errors", &errors_of,
                   nb::for_getter(nb::sig("def errors(self, /) -> "
                                          "numpy.typing.NDArray[numpy.uint32]")))
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

  nb::class_<UnfinishedBake>(m, "UnfinishedBake", "What is finished of a bake that was cancelled.")
      .def(nb::init<>())
      .def("__init__", &make_unfinished, nb::arg("numbers"), nb::arg("done"), nb::arg("lines"),
           nb::arg("paths_of_group"),
           nb::sig("def __init__(self, numbers: collections.abc.Sequence[float], done: "
                   "numpy.typing.NDArray[numpy.uint8], lines: "
                   "collections.abc.Sequence[numpy.typing.NDArray[numpy.uint16]], paths_of_group: "
                   "numpy.typing.NDArray[numpy.uint16]) -> None"))
      .def_ro("share", &UnfinishedBake::share)
      .def_prop_ro("numbers",
                   [](const UnfinishedBake& bake) {
                     return std::vector<double>{static_cast<double>(bake.pass),
                                                bake.gathers ? 1.0 : 0.0, bake.unit, bake.seconds};
                   },
                   nb::for_getter(nb::sig("def numbers(self, /) -> list[float]")))
      .def_prop_ro("done",
                   [](nb::handle self) {
                     const auto& done = nb::cast<const UnfinishedBake&>(self).done;
                     return view(self, done.data(), {done.size()});
                   },
                   nb::for_getter(nb::sig("def done(self, /) -> numpy.typing.NDArray[numpy.uint8]")))
      .def_prop_ro("lines", &lines_of,
                   nb::for_getter(nb::sig("def lines(self, /) -> "
                                          "list[numpy.typing.NDArray[numpy.uint16]]")))
      .def_prop_ro("paths_of_group",
                   [](nb::handle self) {
                     const auto& paths = nb::cast<const UnfinishedBake&>(self).paths_of_group;
                     return view(self, paths.data(), {paths.size()});
                   },
                   nb::for_getter(nb::sig("def paths_of_group(self, /) -> "
                                          "numpy.typing.NDArray[numpy.uint16]")));

  m.def(
      "bake_light",
      [](const World& world, double cell_m, int paths, std::size_t most_bytes, std::uint32_t seed,
         const nb::object& progress, UnfinishedBake* unfinished) {
        std::shared_ptr<BakedLight> baked;
        run_with_progress(progress, [&](const std::function<bool(double)>& report) {
          baked = std::make_shared<BakedLight>(
              bake_light(world, {cell_m, paths, most_bytes, seed}, report, unfinished));
        });
        return baked;
      },
      nb::arg("world"), nb::arg("cell_m"), nb::arg("paths"), nb::arg("most_bytes"), nb::arg("seed"),
      nb::arg("progress").none(), nb::arg("unfinished").none() = nb::none(),
      nb::sig("def bake_light(world: World, cell_m: float, paths: int, most_bytes: int, seed: int, "
              "progress: collections.abc.Callable[[float], object] | None, unfinished: "
              "UnfinishedBake | None = None) -> BakedLight"));
  m.def(
      "bake_cost",
      [](const World& world, double cell_m, int paths, std::size_t most_bytes,
         const nb::object& progress) {
        BakeCost cost;
        run_with_progress(progress, [&](const Progress& told) {
          run_watched(told, [&](WorkState&) {
            cost = bake_cost(world, {cell_m, paths, most_bytes, 0});
          });
        });
        return nb::make_tuple(cost.cells, cost.by_probes, cost.bytes, cost.seconds);
      },
      nb::arg("world"), nb::arg("cell_m"), nb::arg("paths"), nb::arg("most_bytes"),
      nb::arg("progress").none(),
      nb::sig("def bake_cost(world: World, cell_m: float, paths: int, most_bytes: int, progress: "
              "collections.abc.Callable[[float], object] | None) -> tuple[int, int, int, float]"));
}

}  // namespace omma::python
