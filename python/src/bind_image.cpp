// Image for Python: its pixels are a read-only view.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "scene_parts.h"

namespace omma::python {

void bind_image(nb::module_& m) {
  nb::class_<Image> image(
      m, "Image",
      "A picture in memory, row 0 at the top.\n\n"
      "Made from an array of shape (height, width, 3 or 4) or, of greys, (height, width), where\n"
      "uint8 is sRGB and float linear, or from the path of a PNG, JPEG, WebP, Radiance HDR or\n"
      "OpenEXR file. Alpha is linear always.\n\n"
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
          required("pixels"), nb::arg("name") = "",
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

}  // namespace omma::python
