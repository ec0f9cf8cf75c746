// Background for Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "values.h"

namespace omma::python {

namespace {

using Self = nb::handle_t<Background>;

constexpr Words<BackgroundType, 4> types = {{{"constant", BackgroundType::constant},
                                             {"simple_sky", BackgroundType::simple_sky},
                                             {"test_pattern", BackgroundType::test_pattern},
                                             {"image", BackgroundType::image}}};

Background constant_background(nb::handle color) {
  const Vec3d c = vec3d(color, "color");
  if (!std::isfinite(c.x) || !std::isfinite(c.y) || !std::isfinite(c.z))
    throw Error("color: expected three finite numbers");
  Background background;
  background.color = to_float(c);
  return background;
}

Background background_of_type(BackgroundType type) {
  Background background;
  background.type = type;
  return background;
}

// It may be a part of a panorama, or a fisheye's; what has few pixels was made up.
void warn_of_shape(const Image& image) {
  constexpr double most_off = 0.02;
  constexpr int least_pixels = 16;
  if (std::min(image.width, image.height) < least_pixels) return;
  if (std::abs(image.width / (2.0 * image.height) - 1) <= most_off) return;
  const std::string sentence = "image: " + std::to_string(image.width) + " x " +
                               std::to_string(image.height) +
                               " pixels are stretched over the whole sphere, of which an "
                               "equirectangular picture is twice as wide as high";
  if (PyErr_WarnEx(PyExc_UserWarning, sentence.c_str(), 1) < 0) throw nb::python_error();
}

// Of a file as its EXIF turns it.
Image upright_argument(nb::handle source) {
  if (!nb::isinstance<nb::str>(source) && !nb::hasattr(source, "__fspath__"))
    return image_argument(source, "image");
  const nb::object load = nb::module_::import_("omma.base.orientation").attr("load_upright");
  return nb::cast<Image>(load(source));
}

Background image_background(nb::handle source) {
  Background background = background_of_type(BackgroundType::image);
  background.image = upright_argument(source);
  warn_of_shape(background.image);
  return background;
}

// From what __getstate__ gives.
Background restored(const nb::tuple& state) {
  if (state.size() != 4) throw Error("state: expected that of a background");
  Background background = constant_background(state[1]);
  background.type = word_argument(types, state[0], "type");
  if (background.type == BackgroundType::image) {
    background.image = image_argument(state[2], "pixels");
    background.image.name = text_argument(state[3], "name");
  }
  return background;
}

std::string repr(const Background& background) {
  std::string text = std::string("<omma.Background ") + word_of(types, background.type);
  if (background.type == BackgroundType::constant)
    text += " (" + std::to_string(background.color.x) + ", " + std::to_string(background.color.y) +
            ", " + std::to_string(background.color.z) + ")";
  if (background.type == BackgroundType::image)
    text += " " + std::to_string(background.image.width) + " x " +
            std::to_string(background.image.height);
  return text + ">";
}

}  // namespace

void bind_background(nb::module_& m) {
  nb::class_<Background> background(
      m, "Background",
      "Radiance of a ray that meets no surface, instead of the scene's own background.\n\n"
      "Make one with ``constant``, ``simple_sky``, ``test_pattern`` or ``image`` and pass it to\n"
      "`Renderer`.");
  background
      .def_static("constant", &constant_background, nb::arg("color"),
                  nb::sig("def constant(color: numpy.typing.ArrayLike) -> Background"),
                  "The same linear radiance ``(r, g, b)`` in every direction.\n\n"
                  "Raises `omma.Error` where it is not three finite numbers.")
      .def_static(
          "simple_sky", [] { return background_of_type(BackgroundType::simple_sky); },
          "CompoundRay's ``simple_sky``: (143, 179, 203)/255*0.8 at the horizon and below, linear\n"
          "in elevation to (1, 31, 117)/255 at the zenith; taken as linear radiance.")
      .def_static(
          "test_pattern", [] { return background_of_type(BackgroundType::test_pattern); },
          "CompoundRay's ``default_background``: red grows with azimuth, green with elevation,\n"
          "black where a component of the direction is under 0.01.")
      .def_static(
          "image", &image_background, nb::arg("image"),
          nb::sig("def image(image: str | os.PathLike[str] | numpy.typing.ArrayLike) -> "
                  "Background"),
          "An equirectangular image: forward (-Z) in the middle, +X to the right of it, +Y\n"
          "at the top.\n\n"
          "A path to a PNG, JPEG or WebP (8 and 16 bit: sRGB), Radiance HDR or OpenEXR file\n"
          "(float: linear radiance, HDR divided by its EXPOSURE; OpenEXR has channels R, G and B,\n"
          "or Y alone), turned as its EXIF says, or an array of shape (height, width, 3 or 4)\n"
          "or, of greys, (height, width): uint8 is sRGB, float is linear radiance. Between the\n"
          "middles of pixels it is interpolated, which takes contrast from what is a few pixels\n"
          "wide.\n\n"
          "Raises `omma.Error` where the file or the array is not such an image.\n"
          "Warns `UserWarning` where it is not twice as wide as high.")
      .def_prop_ro(
          "type", [](const Background& b) { return word_of(types, b.type); },
          "'constant', 'simple_sky', 'test_pattern' or 'image'.")
      .def_prop_ro(
          "color",
          [](const Background& b) { return nb::make_tuple(b.color.x, b.color.y, b.color.z); },
          nb::for_getter(nb::sig("def color(self, /) -> tuple[float, float, float]")),
          "Linear radiance (r, g, b) of a constant background.")
      .def_prop_ro(
          "pixels",
          [](Self self) {
            const auto& b = nb::cast<const Background&>(self);
            return b.type == BackgroundType::image ? pixels_view(self, b.image) : nb::none();
          },
          nb::for_getter(nb::sig("def pixels(self, /) -> numpy.typing.NDArray[typing.Any] | None")),
          "RGBA of an image, read-only: (height, width, 4), uint8 (sRGB) or float32 (linear).")
      .def(
          "__getstate__",
          [](Self self) {
            const auto& b = nb::cast<const Background&>(self);
            return nb::make_tuple(self.attr("type"), self.attr("color"), self.attr("pixels"),
                                  b.image.name);
          },
          nb::sig("def __getstate__(self) -> tuple[typing.Any, ...]"))
      .def(
          "__setstate__",
          [](Background& self, const nb::tuple& state) { new (&self) Background(restored(state)); },
          nb::sig("def __setstate__(self, state: tuple[typing.Any, ...]) -> None"))
      .def("__hash__", [](const Background& b) { return static_cast<std::size_t>(b.type); })
      .def("__repr__", [](const Background& b) { return repr(b); });
  def_equality(background);
}

}  // namespace omma::python
