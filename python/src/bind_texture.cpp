// Textures, and their uses by materials, for Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "scene_parts.h"

namespace omma::python {

namespace {

constexpr Words<Wrap, 3> wraps = {{{"repeat", Wrap::repeat},
                                   {"mirrored_repeat", Wrap::mirrored_repeat},
                                   {"clamp_to_edge", Wrap::clamp_to_edge}}};
constexpr Words<Filter, 2> filters = {{{"nearest", Filter::nearest}, {"linear", Filter::linear}}};

}  // namespace

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
          required("image"), nb::arg("wrap_u") = "repeat", nb::arg("wrap_v") = "repeat",
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
         required("texture"), nb::arg("texcoord_set") = 0,
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

}  // namespace omma::python
