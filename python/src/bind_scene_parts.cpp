// The parts that scenes are made of for Python: images, textures, materials, meshes, instances and
// hit boxes. Their arrays are read-only views; those of a scene's own parts are its memory.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "values.h"

namespace omma::python {

namespace {

constexpr Words<Wrap, 3> wraps = {{{"repeat", Wrap::repeat},
                                   {"mirrored_repeat", Wrap::mirrored_repeat},
                                   {"clamp_to_edge", Wrap::clamp_to_edge}}};
constexpr Words<Filter, 2> filters = {{{"nearest", Filter::nearest}, {"linear", Filter::linear}}};
constexpr Words<AlphaMode, 3> alpha_modes = {
    {{"opaque", AlphaMode::opaque}, {"mask", AlphaMode::mask}, {"blend", AlphaMode::blend}}};

std::string named(const char* what, const std::string& name) {
  return std::string("<omma.scene.") + what + (name.empty() ? "" : " '" + name + "'");
}

std::string counted(std::size_t count, const char* what) {
  return std::to_string(count) + " " + what;
}

std::size_t hash_of(const std::string& name, std::size_t number) {
  return std::hash<std::string>{}(name) ^ number;
}

template <typename Vec>
nb::object numbers(const Vec& v) {
  const auto* values = reinterpret_cast<const float*>(&v);
  nb::list list;
  for (std::size_t i = 0; i < sizeof(Vec) / sizeof(float); ++i)
    list.append(static_cast<double>(values[i]));
  return nb::tuple(list);
}

void bind_image(nb::module_& m) {
  nb::class_<Image> image(
      m, "Image",
      "A picture in memory, row 0 at the top.\n\n"
      "Made from an array of shape (height, width, 3 or 4), where uint8 is sRGB and float linear,\n"
      "or from the path of a PNG, JPEG, Radiance HDR or OpenEXR file. Alpha is linear always.\n\n"
      "Raises `omma.Error` where the array or the file is not such an image.");
  image
      .def(
          "__init__",
          [](Image* self, nb::handle pixels, nb::handle name) {
            const std::string called = text_argument(name, "name");
            Image made = image_argument(pixels, "pixels");
            made.name = called;
            new (self) Image(valid_alone(std::move(made), &Scene::images));
          },
          nb::arg("pixels"), nb::arg("name") = "",
          nb::sig("def __init__(self, pixels: str | os.PathLike[str] | numpy.typing.ArrayLike, "
                  "name: str = '') -> None"))
      .def_ro("name", &Image::name)
      .def_prop_ro(
          "pixels",
          [](nb::handle_t<Image> self) { return pixels_view(self, nb::cast<const Image&>(self)); },
          nb::for_getter(nb::sig("def pixels(self, /) -> numpy.typing.NDArray[typing.Any]")),
          "RGBA, read-only: (height, width, 4), uint8 (sRGB) or float32 (linear).")
      .def("__hash__",
           [](const Image& i) {
             return hash_of(i.name, static_cast<std::size_t>(i.width) * 65536u +
                                        static_cast<std::size_t>(i.height));
           })
      .def("__repr__", [](const Image& i) {
        return named("Image", i.name) + " " + std::to_string(i.width) + " x " +
               std::to_string(i.height) + (i.rgba_srgb8.empty() ? ", linear>" : ", sRGB>");
      });
  def_value(image, {"pixels", "name"});
}

void bind_texture(nb::module_& m) {
  nb::class_<Texture> texture(
      m, "Texture",
      "How a picture is read: beyond its edges it repeats, mirrored or not, or goes on as at the\n"
      "edge ('repeat', 'mirrored_repeat', 'clamp_to_edge'); between its pixels it is interpolated\n"
      "('linear') or not ('nearest'). ``image`` is an index into the scene's images.");
  texture
      .def(
          "__init__",
          [](Texture* self, nb::handle image, nb::handle wrap_u, nb::handle wrap_v,
             nb::handle filter) {
            new (self) Texture{
                whole_argument(image, "image"), word_argument(wraps, wrap_u, "wrap_u"),
                word_argument(wraps, wrap_v, "wrap_v"), word_argument(filters, filter, "filter")};
          },
          nb::arg("image"), nb::arg("wrap_u") = "repeat", nb::arg("wrap_v") = "repeat",
          nb::arg("filter") = "linear",
          nb::sig("def __init__(self, image: int, wrap_u: str = 'repeat', wrap_v: str = 'repeat', "
                  "filter: str = 'linear') -> None"))
      .def_ro("image", &Texture::image, "Index into the scene's images.")
      .def_prop_ro("wrap_u", [](const Texture& t) { return word_of(wraps, t.wrap_u); })
      .def_prop_ro("wrap_v", [](const Texture& t) { return word_of(wraps, t.wrap_v); })
      .def_prop_ro("filter", [](const Texture& t) { return word_of(filters, t.filter); })
      .def("__hash__", [](const Texture& t) { return hash_of("", std::size_t(t.image)); })
      .def("__repr__", [](const Texture& t) {
        return "<omma.scene.Texture of image " + std::to_string(t.image) + ", " +
               word_of(wraps, t.wrap_u) + ", " + word_of(wraps, t.wrap_v) + ", " +
               word_of(filters, t.filter) + ">";
      });
  def_value(texture, {"image", "wrap_u", "wrap_v", "filter"});
}

void bind_texture_use(nb::module_& m) {
  nb::class_<TextureUse> use(
      m, "TextureUse",
      "A texture as a material uses it: an index into the scene's textures, which of a mesh's two\n"
      "sets of texture coordinates it is read with, and what becomes of these before: offset +\n"
      "rotation · scale · coordinate.");
  use.def(
         "__init__",
         [](TextureUse* self, nb::handle texture, nb::handle texcoord_set, nb::handle offset,
            nb::handle scale, nb::handle rotation_rad) {
           new (self) TextureUse{whole_argument(texture, "texture"),
                                 whole_argument(texcoord_set, "texcoord_set"),
                                 vec2_argument(offset, "offset"), vec2_argument(scale, "scale"),
                                 static_cast<float>(number_argument(rotation_rad, "rotation_rad"))};
         },
         nb::arg("texture"), nb::arg("texcoord_set") = 0,
         nb::arg("offset") = nb::make_tuple(0.0, 0.0), nb::arg("scale") = nb::make_tuple(1.0, 1.0),
         nb::arg("rotation_rad") = 0.0,
         nb::sig("def __init__(self, texture: int, texcoord_set: int = 0, offset: "
                 "numpy.typing.ArrayLike = (0.0, 0.0), scale: numpy.typing.ArrayLike = (1.0, 1.0), "
                 "rotation_rad: float = 0.0) -> None"))
      .def_ro("texture", &TextureUse::texture, "Index into the scene's textures.")
      .def_ro("texcoord_set", &TextureUse::texcoord_set, "0 or 1.")
      .def_prop_ro(
          "offset", [](const TextureUse& u) { return numbers(u.offset); },
          nb::for_getter(nb::sig("def offset(self, /) -> tuple[float, float]")))
      .def_prop_ro(
          "scale", [](const TextureUse& u) { return numbers(u.scale); },
          nb::for_getter(nb::sig("def scale(self, /) -> tuple[float, float]")))
      .def_ro("rotation_rad", &TextureUse::rotation_rad)
      .def("__hash__", [](const TextureUse& u) { return hash_of("", std::size_t(u.texture)); })
      .def("__repr__", [](const TextureUse& u) {
        return "<omma.scene.TextureUse of texture " + std::to_string(u.texture) +
               ", coordinate set " + std::to_string(u.texcoord_set) + ">";
      });
  def_value(use, {"texture", "texcoord_set", "offset", "scale", "rotation_rad"});
}

TextureUse texture_use_argument(nb::handle object, const char* name) {
  if (object.is_none()) return {};
  if (nb::isinstance<TextureUse>(object)) return nb::cast<const TextureUse&>(object);
  TextureUse use;
  use.texture = whole_argument(object, name);
  return use;
}

nb::object texture_use_or_none(const TextureUse& use) {
  return use.texture < 0 ? nb::none() : nb::cast(use);
}

// RGBA; RGB is opaque.
Vec4 rgba_argument(nb::handle object, const char* name) {
  const auto values = float_array(object, name, {-1});
  const float* v = values.data();
  if (values.shape(0) != 3 && values.shape(0) != 4)
    throw Error(std::string(name) + ": expected three or four numbers, found " +
                std::to_string(values.shape(0)));
  return {v[0], v[1], v[2], values.shape(0) == 4 ? v[3] : 1.0f};
}

void bind_material(nb::module_& m) {
  nb::class_<Material> material(
      m, "Material",
      "What a surface looks like: base colour × texture × the mesh's vertex colours, and emission\n"
      "× its texture beside that. All factors are linear.\n\n"
      "``alpha_mode`` 'opaque' takes no notice of alpha, 'mask' cuts where it is under\n"
      "``alpha_cutoff``, 'blend' lets light through. Back faces are seen only where\n"
      "``double_sided``. ``unlit`` says that its base colour is its radiance, whatever falls on\n"
      "it.");
  material
      .def(
          "__init__",
          [](Material* self, nb::handle name, nb::handle base_color, nb::handle base_color_texture,
             nb::handle emissive, nb::handle emissive_texture, nb::handle alpha_mode,
             nb::handle alpha_cutoff, nb::handle double_sided, nb::handle unlit) {
            Material made;
            made.name = text_argument(name, "name");
            made.base_color = rgba_argument(base_color, "base_color");
            made.base_color_texture =
                texture_use_argument(base_color_texture, "base_color_texture");
            made.emissive = to_float(vec3d(emissive, "emissive"));
            made.emissive_texture = texture_use_argument(emissive_texture, "emissive_texture");
            made.alpha_mode = word_argument(alpha_modes, alpha_mode, "alpha_mode");
            made.alpha_cutoff = static_cast<float>(number_argument(alpha_cutoff, "alpha_cutoff"));
            made.double_sided = flag_argument(double_sided, "double_sided");
            made.unlit = flag_argument(unlit, "unlit");
            if (made.unlit &&
                (made.emissive != Vec3{0, 0, 0} || made.emissive_texture.texture >= 0))
              throw Error("unlit: is unlit and has an emission, which unlit materials do not have");
            new (self) Material(std::move(made));
          },
          nb::arg("name") = "", nb::kw_only(),
          nb::arg("base_color") = nb::make_tuple(1.0, 1.0, 1.0, 1.0),
          nb::arg("base_color_texture") = nb::none(),
          nb::arg("emissive") = nb::make_tuple(0.0, 0.0, 0.0),
          nb::arg("emissive_texture") = nb::none(), nb::arg("alpha_mode") = "opaque",
          nb::arg("alpha_cutoff") = 0.5, nb::arg("double_sided") = false, nb::arg("unlit") = false,
          nb::sig(
              "def __init__(self, name: str = '', *, base_color: numpy.typing.ArrayLike = "
              "(1.0, 1.0, 1.0, 1.0), base_color_texture: int | TextureUse | None = None, "
              "emissive: numpy.typing.ArrayLike = (0.0, 0.0, 0.0), emissive_texture: int | "
              "TextureUse | None = None, alpha_mode: str = 'opaque', alpha_cutoff: float = 0.5, "
              "double_sided: bool = False, unlit: bool = False) -> None"))
      .def_ro("name", &Material::name)
      .def_prop_ro(
          "base_color", [](const Material& one) { return numbers(one.base_color); },
          nb::for_getter(nb::sig("def base_color(self, /) -> tuple[float, float, float, float]")),
          "Linear factor, RGBA.")
      .def_prop_ro(
          "base_color_texture",
          [](const Material& one) { return texture_use_or_none(one.base_color_texture); },
          nb::for_getter(nb::sig("def base_color_texture(self, /) -> TextureUse | None")))
      .def_prop_ro(
          "emissive", [](const Material& one) { return numbers(one.emissive); },
          nb::for_getter(nb::sig("def emissive(self, /) -> tuple[float, float, float]")),
          "Linear radiance, RGB.")
      .def_prop_ro(
          "emissive_texture",
          [](const Material& one) { return texture_use_or_none(one.emissive_texture); },
          nb::for_getter(nb::sig("def emissive_texture(self, /) -> TextureUse | None")))
      .def_prop_ro("alpha_mode",
                   [](const Material& one) { return word_of(alpha_modes, one.alpha_mode); })
      .def_ro("alpha_cutoff", &Material::alpha_cutoff)
      .def_ro("double_sided", &Material::double_sided)
      .def_ro("unlit", &Material::unlit)
      .def("__hash__",
           [](const Material& one) {
             return hash_of(one.name, std::size_t(one.base_color_texture.texture + 1));
           })
      .def("__repr__", [](const Material& one) {
        std::string text = named("Material", one.name);
        if (one.base_color_texture.texture >= 0)
          text += ", texture " + std::to_string(one.base_color_texture.texture);
        if (one.alpha_mode != AlphaMode::opaque)
          text += std::string(", ") + word_of(alpha_modes, one.alpha_mode);
        return text + (one.double_sided ? ", double sided>" : ">");
      });
  def_value(material, {"name", "base_color", "base_color_texture", "emissive", "emissive_texture",
                       "alpha_mode", "alpha_cutoff", "double_sided", "unlit"});
}

using MeshSelf = nb::handle_t<Mesh>;
const Mesh& mesh_of(MeshSelf self) {
  return nb::cast<const Mesh&>(self);
}

Mesh made_mesh(nb::handle positions_m, nb::handle triangles, nb::handle name, nb::handle normals,
               nb::handle texture_coordinates, nb::handle second_texture_coordinates,
               nb::handle colors, nb::handle material) {
  Mesh mesh;
  mesh.name = text_argument(name, "name");
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

void bind_mesh(nb::module_& m) {
  nb::class_<Mesh> mesh(
      m, "Mesh",
      "Triangles of one material, in a frame of their own.\n\n"
      "Positions (V, 3), m, and the three vertices of each triangle (T, 3), counter-clockwise as\n"
      "seen from in front. For each vertex, where there are any: normals (V, 3), which nothing\n"
      "reads yet; texture coordinates (V, 2), (0, 0) the upper left corner of the picture and\n"
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
          nb::arg("positions_m"), nb::arg("triangles"), nb::kw_only(), nb::arg("name") = "",
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
          nb::arg("mesh"), nb::arg("world_from_mesh") = nb::none(), nb::kw_only(),
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
           made.positions = vectors_argument(positions_m, "positions_m");
           made.triangles = triangles_argument(triangles, "triangles");
           if (!world_from_mesh.is_none())
             made.world_from_mesh = mat4(world_from_mesh, "world_from_mesh");
           new (self) HitBox(valid_alone(std::move(made), &Scene::hit_boxes));
         },
         nb::arg("name"), nb::arg("positions_m"), nb::arg("triangles"),
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

}  // namespace

void bind_scene_parts(nb::module_& m) {
  bind_image(m);
  bind_texture(m);
  bind_texture_use(m);
  bind_material(m);
  bind_mesh(m);
  bind_instance(m);
  bind_hit_box(m);
}

}  // namespace omma::python
