// Mesh for Python. Its arrays are read-only views; those of a scene's own meshes are its memory.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "scene_parts.h"

namespace omma::python {

namespace {

using MeshSelf = nb::handle_t<Mesh>;
const Mesh& mesh_of(MeshSelf self) {
  return nb::cast<const Mesh&>(self);
}

Mesh made_mesh(nb::handle positions_m, nb::handle triangles, nb::handle name, nb::handle normals,
               nb::handle texture_coordinates, nb::handle second_texture_coordinates,
               nb::handle colors, nb::handle material) {
  Mesh mesh;
  mesh.name = text_argument(name, "name");
  expect_given(positions_m, "positions_m", "numbers of shape (N, 3)");
  mesh.positions = vectors_argument(positions_m, "positions_m");
  mesh.triangles = triangles_argument(triangles, "triangles");
  mesh.normals = vectors_argument(normals, "normals");
  mesh.texcoords = {coordinates_argument(texture_coordinates, "texture_coordinates"),
                    coordinates_argument(second_texture_coordinates, "second_texture_coordinates")};
  mesh.colors = colors_argument(colors, "colors");
  // Which materials there are only the scene knows.
  mesh = valid_alone(std::move(mesh), &Scene::meshes);
  mesh.material = handle_argument(material, "material");
  return mesh;
}

}  // namespace

void bind_mesh(nb::module_& m) {
  nb::class_<Mesh> mesh(
      m, "Mesh",
      "Triangles of one material, in a frame of their own.\n\n"
      "Positions (V, 3), m, and the three vertices of each triangle (T, 3), counter-clockwise as\n"
      "seen from in front. For each vertex, where there are any: normals (V, 3), none of\n"
      "them zero, which count in a world with a light; texture coordinates (V, 2), (0, 0) the upper left corner of the picture and\n"
      "(1, 1) the lower right one; linear colours (V, 3 or 4). ``material`` is an index into the\n"
      "scene's materials, None white.\n\n"
      "Raises `omma.Error` where sizes do not go together, a triangle has a vertex that is not\n"
      "there, or a number is not finite.");
  mesh.def(
          "__init__",
          [](Mesh* self, nb::handle positions_m, nb::handle triangles, nb::handle name,
             nb::handle normals, nb::handle texture_coordinates,
             nb::handle second_texture_coordinates, nb::handle colors, nb::handle material) {
            new (self) Mesh(made_mesh(positions_m, triangles, name, normals, texture_coordinates,
                                      second_texture_coordinates, colors, material));
          },
          required("positions_m"), required("triangles"), nb::kw_only(), nb::arg("name") = "",
          nb::arg("normals") = nb::none(), nb::arg("texture_coordinates") = nb::none(),
          nb::arg("second_texture_coordinates") = nb::none(), nb::arg("colors") = nb::none(),
          nb::arg("material") = nb::none(),
          nb::sig("def __init__(self, positions_m: numpy.typing.ArrayLike, triangles: "
                  "numpy.typing.ArrayLike, *, name: str = '', normals: numpy.typing.ArrayLike | "
                  "None = None, texture_coordinates: numpy.typing.ArrayLike | None = None, "
                  "second_texture_coordinates: numpy.typing.ArrayLike | None = None, colors: "
                  "numpy.typing.ArrayLike | None = None, material: int | None = None) -> None"))
      .def_ro("name", &Mesh::name)
      .def_prop_ro(
          "positions_m",
          [](MeshSelf self) { return vectors_view<float>(self, mesh_of(self).positions); },
          nb::for_getter(
              nb::sig("def positions_m(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "(V, 3), m.")
      .def_prop_ro(
          "triangles",
          [](MeshSelf self) { return vectors_view<std::uint32_t>(self, mesh_of(self).triangles); },
          nb::for_getter(nb::sig("def triangles(self, /) -> numpy.typing.NDArray[numpy.uint32]")),
          "(T, 3).")
      .def_prop_ro(
          "normals",
          [](MeshSelf self) { return vectors_view<float>(self, mesh_of(self).normals, true); },
          nb::for_getter(
              nb::sig("def normals(self, /) -> numpy.typing.NDArray[numpy.float32] | None")),
          "(V, 3), or None.")
      .def_prop_ro(
          "texture_coordinates",
          [](MeshSelf self) { return vectors_view<float>(self, mesh_of(self).texcoords[0], true); },
          nb::for_getter(nb::sig("def texture_coordinates(self, /) -> "
                                 "numpy.typing.NDArray[numpy.float32] | None")),
          "(V, 2), or None.")
      .def_prop_ro(
          "second_texture_coordinates",
          [](MeshSelf self) { return vectors_view<float>(self, mesh_of(self).texcoords[1], true); },
          nb::for_getter(nb::sig("def second_texture_coordinates(self, /) -> "
                                 "numpy.typing.NDArray[numpy.float32] | None")),
          "(V, 2), or None: set 1 of a `TextureUse`.")
      .def_prop_ro(
          "colors",
          [](MeshSelf self) { return vectors_view<float>(self, mesh_of(self).colors, true); },
          nb::for_getter(
              nb::sig("def colors(self, /) -> numpy.typing.NDArray[numpy.float32] | None")),
          "Linear RGBA (V, 4), or None.")
      .def_prop_ro(
          "material", [](const Mesh& one) { return index_or_none(one.material); },
          nb::for_getter(nb::sig("def material(self, /) -> int | None")),
          "Index into the scene's materials; None: white.")
      .def("__hash__",
           [](const Mesh& one) {
             return hash_of(one.name, one.positions.size() + one.triangles.size());
           })
      .def("__repr__", [](const Mesh& one) {
        return named("Mesh", one.name) + " of " + counted(one.positions.size(), "vertices, ") +
               counted(one.triangles.size(), "triangles") +
               (one.material < 0 ? ">" : ", material " + std::to_string(one.material) + ">");
      });
  def_value(mesh, {"positions_m", "triangles", "name", "normals", "texture_coordinates",
                   "second_texture_coordinates", "colors", "material"});
}

}  // namespace omma::python
