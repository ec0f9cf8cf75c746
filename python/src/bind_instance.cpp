// Instance for Python: a mesh placed in the world.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "scene_parts.h"

namespace omma::python {

void bind_instance(nb::module_& m) {
  nb::class_<Instance> instance(
      m, "Instance",
      "A mesh placed in the world: an index into the scene's meshes, where it is\n"
      "(``world_from_mesh`` (4, 4), m; None: where its positions say), and the name it is moved\n"
      "by. Instances of one ``node`` move together and must be in one place; None: it moves "
      "alone.");
  instance
      .def(
          "__init__",
          [](Instance* self, nb::handle mesh, nb::handle world_from_mesh, nb::handle name,
             nb::handle node) {
            Instance made;
            made.mesh = whole_argument(mesh, "mesh");
            if (!world_from_mesh.is_none())
              made.world_from_mesh = mat4(world_from_mesh, "world_from_mesh");
            made.name = text_argument(name, "name");
            made.node = handle_argument(node, "node");
            new (self) Instance(std::move(made));
          },
          required("mesh"), nb::arg("world_from_mesh") = nb::none(), nb::kw_only(),
          nb::arg("name") = "", nb::arg("node") = nb::none(),
          nb::sig("def __init__(self, mesh: int, world_from_mesh: numpy.typing.ArrayLike | None = "
                  "None, *, name: str = '', node: int | None = None) -> None"))
      .def_ro("mesh", &Instance::mesh, "Index into the scene's meshes.")
      .def_prop_ro(
          "world_from_mesh", [](const Instance& i) { return matrix_array(i.world_from_mesh); },
          nb::for_getter(nb::sig("def world_from_mesh(self, /) -> "
                                 "numpy.typing.NDArray[numpy.float64]")),
          "(4, 4), m.")
      .def_ro("name", &Instance::name)
      .def_prop_ro(
          "node", [](const Instance& i) { return index_or_none(i.node); },
          nb::for_getter(nb::sig("def node(self, /) -> int | None")),
          "Those with the same one move together; None: it moves alone.")
      .def("__hash__", [](const Instance& i) { return hash_of(i.name, std::size_t(i.mesh)); })
      .def("__repr__", [](const Instance& i) {
        return named("Instance", i.name) + " of mesh " + std::to_string(i.mesh) + ">";
      });
  def_value(instance, {"mesh", "world_from_mesh", "name", "node"});
}

}  // namespace omma::python
