// HitBox for Python: a region that is never drawn.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "scene_parts.h"

namespace omma::python {

void bind_hit_box(nb::module_& m) {
  using Self = nb::handle_t<HitBox>;
  nb::class_<HitBox> box(
      m, "HitBox",
      "A closed surface that marks a region and is never drawn: positions (V, 3), m, triangles\n"
      "(T, 3) and where it is, ``world_from_mesh`` (4, 4), m.");
  box.def(
         "__init__",
         [](HitBox* self, nb::handle name, nb::handle positions_m, nb::handle triangles,
            nb::handle world_from_mesh) {
           HitBox made;
           made.name = text_argument(name, "name");
           expect_given(positions_m, "positions_m", "numbers of shape (N, 3)");
           made.positions = vectors_argument(positions_m, "positions_m");
           made.triangles = triangles_argument(triangles, "triangles");
           if (!world_from_mesh.is_none())
             made.world_from_mesh = mat4(world_from_mesh, "world_from_mesh");
           new (self) HitBox(valid_alone(std::move(made), &Scene::hit_boxes));
         },
         required("name"), required("positions_m"), required("triangles"),
         nb::arg("world_from_mesh") = nb::none(),
         nb::sig("def __init__(self, name: str, positions_m: numpy.typing.ArrayLike, triangles: "
                 "numpy.typing.ArrayLike, world_from_mesh: numpy.typing.ArrayLike | None = None) "
                 "-> None"))
      .def_ro("name", &HitBox::name)
      .def_prop_ro(
          "positions_m",
          [](Self self) {
            return vectors_view<float>(self, nb::cast<const HitBox&>(self).positions);
          },
          nb::for_getter(
              nb::sig("def positions_m(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "(V, 3), m.")
      .def_prop_ro(
          "triangles",
          [](Self self) {
            return vectors_view<std::uint32_t>(self, nb::cast<const HitBox&>(self).triangles);
          },
          nb::for_getter(nb::sig("def triangles(self, /) -> numpy.typing.NDArray[numpy.uint32]")),
          "(T, 3).")
      .def_prop_ro(
          "world_from_mesh", [](const HitBox& b) { return matrix_array(b.world_from_mesh); },
          nb::for_getter(nb::sig("def world_from_mesh(self, /) -> "
                                 "numpy.typing.NDArray[numpy.float64]")),
          "(4, 4), m.")
      .def("__hash__", [](const HitBox& b) { return hash_of(b.name, b.triangles.size()); })
      .def("__repr__", [](const HitBox& b) {
        return named("HitBox", b.name) + " of " + counted(b.triangles.size(), "triangles>");
      });
  def_value(box, {"name", "positions_m", "triangles", "world_from_mesh"});
}

}  // namespace omma::python
