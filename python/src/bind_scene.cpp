// Scene, Camera and Background for Python. A scene is read-only: it is made by `load_scene` or
// empty, and shared with the renderers that use it.
#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>

#include "arrays.h"
#include "omma/error.h"
#include "omma/io.h"
#include "omma/scene.h"

namespace omma::python {

namespace {

const char* word(CameraType type) {
  return type == CameraType::perspective ? "perspective" : "orthographic";
}

const char* word(BackgroundType type) {
  switch (type) {
    case BackgroundType::constant:
      return "constant";
    case BackgroundType::simple_sky:
      return "simple_sky";
    case BackgroundType::test_pattern:
      return "test_pattern";
    case BackgroundType::image:
      return "image";
  }
  return "";
}

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

// [height][width][3 or 4] to RGBA; `opaque` is the alpha of an image without one.
template <typename T, typename Array>
std::vector<T> to_rgba(const Array& pixels, std::size_t components, T opaque) {
  const std::size_t count = pixels.shape(0) * pixels.shape(1);
  std::vector<T> rgba(count * 4, opaque);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < components; ++c)
      rgba[4 * i + c] = static_cast<T>(pixels.data()[components * i + c]);
  return rgba;
}

Background image_background(nb::handle source) {
  Background background = background_of_type(BackgroundType::image);
  if (nb::isinstance<nb::str>(source) || nb::hasattr(source, "__fspath__")) {
    background.image = load_image(path_text(source));
    return background;
  }
  const nb::object array = nb::module_::import_("numpy").attr("asarray")(source);
  const auto kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
  const bool bytes = str_of(array.attr("dtype")) == "uint8";
  const auto shape = nb::cast<std::vector<std::int64_t>>(array.attr("shape"));
  const bool rgb = shape.size() == 3 && (shape[2] == 3 || shape[2] == 4);
  const bool sized =
      rgb && shape[0] > 0 && shape[1] > 0 && shape[0] <= 1 << 16 && shape[1] <= 1 << 16;
  if (!sized || !(bytes || kind == "f"))
    throw Error(
        "image: expected a path, or uint8 (sRGB) or float (linear) values of shape (height, width, "
        "3 or 4), found " +
        str_of(array.attr("dtype")) + " of shape " + str_of(array.attr("shape")));
  background.image.name = "image";
  background.image.height = static_cast<int>(shape[0]);
  background.image.width = static_cast<int>(shape[1]);
  const auto components = static_cast<std::size_t>(shape[2]);
  if (bytes) {
    const nb::object packed = nb::module_::import_("numpy").attr("ascontiguousarray")(array);
    background.image.rgba_srgb8 =
        to_rgba<std::uint8_t>(nb::cast<InputArray<std::uint8_t>>(packed), components, 255);
  } else {
    const auto packed = float_array(array, "image", {-1, -1, shape[2]});
    const float* begin = packed.data();
    if (!std::all_of(begin, begin + packed.size(), [](float v) { return std::isfinite(v); }))
      throw Error("image: expected finite values");
    background.image.rgba_linear = to_rgba<float>(packed, components, 1.0f);
  }
  return background;
}

std::string repr(const Background& background) {
  std::string text = std::string("<omma.Background ") + word(background.type);
  if (background.type == BackgroundType::constant)
    text += " (" + std::to_string(background.color.x) + ", " + std::to_string(background.color.y) +
            ", " + std::to_string(background.color.z) + ")";
  if (background.type == BackgroundType::image)
    text += " " + std::to_string(background.image.width) + " x " +
            std::to_string(background.image.height);
  return text + ">";
}

std::string repr(const Camera& camera) {
  std::string text = "<omma.Camera '" + camera.name + "' " + word(camera.type);
  if (!camera.compound_structure.empty()) text += ", eye '" + camera.compound_structure + "'";
  return text + ">";
}

std::string repr(const Scene& scene) {
  return "<omma.Scene " + (scene.path.empty() ? "in memory" : "'" + scene.path + "'") + ": " +
         std::to_string(triangle_count(scene)) + " triangles, " +
         std::to_string(scene.cameras.size()) + " cameras>";
}

nb::object bounds(const Scene& scene) {
  const Bounds box = scene_bounds(scene);
  if (box.empty) return nb::none();
  return take(std::vector<double>{box.lower.x, box.lower.y, box.lower.z, box.upper.x, box.upper.y,
                                  box.upper.z},
              {2, 3});
}

nb::object extras(const Camera& camera) {
  if (camera.extras_json.empty()) return nb::dict();
  return nb::module_::import_("json").attr("loads")(camera.extras_json);
}

template <typename T>
auto size_of(std::vector<T> Scene::*list) {
  return [list](const Scene& scene) { return (scene.*list).size(); };
}

}  // namespace

void bind_scene(nb::module_& m) {
  nb::class_<Background>(
      m, "Background",
      "Radiance of a ray that meets no surface, instead of the scene's own background.\n\n"
      "Make one with ``constant``, ``simple_sky``, ``test_pattern`` or ``image`` and pass it to\n"
      "`Renderer`.")
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
          "A path to a PNG or JPEG (8 bit: sRGB) or Radiance HDR file, or an array of shape\n"
          "(height, width, 3 or 4): uint8 is sRGB, float is linear radiance.\n\n"
          "Raises `omma.Error` where the file or the array is not such an image.")
      .def_prop_ro(
          "type", [](const Background& b) { return word(b.type); },
          "'constant', 'simple_sky', 'test_pattern' or 'image'.")
      .def_prop_ro(
          "color",
          [](const Background& b) { return nb::make_tuple(b.color.x, b.color.y, b.color.z); },
          nb::for_getter(nb::sig("def color(self, /) -> tuple[float, float, float]")),
          "Linear radiance (r, g, b) of a constant background.")
      .def("__repr__", [](const Background& b) { return repr(b); });

  nb::class_<Camera>(m, "Camera", "A camera node of a scene. It looks along its -Z, +Y is up.")
      .def_ro("name", &Camera::name, "Name of the node (of the camera where the node has none).")
      .def_prop_ro(
          "type", [](const Camera& c) { return word(c.type); }, "'perspective' or 'orthographic'.")
      .def_prop_ro(
          "world_from_camera", [](const Camera& c) { return matrix_array(c.world_from_camera); },
          nb::for_getter(nb::sig("def world_from_camera(self, /) -> "
                                 "numpy.typing.NDArray[numpy.float64]")),
          "The node's whole transform, its scale too: (4, 4), m.")
      .def_prop_ro("extras", &extras, nb::for_getter(nb::sig("def extras(self, /) -> typing.Any")),
                   "The camera's extras in the glTF file, {} where there are none.")
      .def_ro("compound_structure", &Camera::compound_structure,
              "The `.eye` file that the camera's extras name, '' where it is no compound eye.")
      .def_ro("yfov_rad", &Camera::yfov_rad, "Vertical field of view; perspective only.")
      .def_ro("aspect_ratio", &Camera::aspect_ratio, "Width over height, 0 where not given.")
      .def_ro("xmag_m", &Camera::xmag_m, "Horizontal half extent; orthographic only.")
      .def_ro("ymag_m", &Camera::ymag_m, "Vertical half extent; orthographic only.")
      .def("__repr__", [](const Camera& c) { return repr(c); });

  nb::class_<Scene>(
      m, "Scene",
      "A scene: meshes, instances, materials, textures, cameras and a background, in\n"
      "glTF's world frame (right-handed, +Y up, metres). Read-only.\n\n"
      "`omma.load_scene` reads one; ``Scene()`` is empty: nothing but background.")
      .def("__init__", [](Scene* self) { new (self) Scene(); })
      .def_ro("path", &Scene::path, "The file it came from, '' for one made in memory.")
      .def_prop_ro(
          "cameras", [](const Scene& s) { return s.cameras; },
          "Camera nodes in the order of the file.")
      .def("camera", &find_camera, nb::arg("name"), nb::rv_policy::copy,
           "The camera of that name.\n\nRaises `omma.Error`, with the names there are.")
      .def_prop_ro("bounds", &bounds,
                   nb::for_getter(nb::sig(
                       "def bounds(self, /) -> numpy.typing.NDArray[numpy.float64] | None")),
                   "Lower and upper corner of the box around everything: (2, 3), m; None for an\n"
                   "empty scene.")
      .def_prop_ro("triangle_count", &triangle_count,
                   "Triangles as seen: each instance counts those of its mesh.")
      .def_prop_ro("mesh_count", size_of(&Scene::meshes),
                   "Meshes stored: one for each glTF primitive.")
      .def_prop_ro("instance_count", size_of(&Scene::instances), "Meshes placed in the world.")
      .def_prop_ro("material_count", size_of(&Scene::materials))
      .def_prop_ro("texture_count", size_of(&Scene::textures))
      .def_prop_ro("image_count", size_of(&Scene::images))
      .def_ro("node_count", &Scene::node_count, "Nodes reached from the loaded scene.")
      .def_prop_ro(
          "scene_names", [](const Scene& s) { return s.scene_names; },
          "Names of all scenes in the file.")
      .def_prop_ro(
          "background", [](const Scene& s) { return s.background; },
          "What a ray sees that meets no surface.")
      .def_prop_ro(
          "warnings", [](const Scene& s) { return s.warnings; },
          "What the loader passed over, a sentence each.")
      .def("__repr__", [](const Scene& s) { return repr(s); });

  m.def(
      "load_scene",
      [](nb::handle path, int scene_index) {
        const std::string name = path_text(path);
        nb::gil_scoped_release release;
        return std::make_shared<Scene>(load_scene(name, scene_index));
      },
      nb::arg("path"), nb::arg("scene_index") = -1,
      nb::sig("def load_scene(path: str | os.PathLike[str], scene_index: int = -1) -> Scene"));
}

}  // namespace omma::python
