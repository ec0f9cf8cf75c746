// Scene and Background for Python. A scene is read-only: it is made by `load_scene` or
// empty, and shared with the renderers that use it.
#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>

#include "arrays.h"
#include "model/text.h"
#include "omma/camera.h"
#include "omma/error.h"
#include "omma/io.h"
#include "omma/scene.h"
#include "progress.h"
#include "threads/parallel.h"

namespace omma::python {

namespace {

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
    const std::string path = path_text(source);
    run_with_progress(nb::none(), [&](const std::function<bool(double)>& report) {
      background.image = load_image(path, report);
    });
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

std::string repr(const Scene& scene) {
  return "<omma.Scene " +
         (scene.path.empty() ? "in memory" : "'" + readable_text(scene.path) + "'") + ": " +
         std::to_string(triangle_count(scene)) + " triangles, " +
         std::to_string(scene.cameras.size()) + " cameras>";
}

nb::object corners(const Bounds& box) {
  if (box.empty) return nb::none();
  return take(std::vector<double>{box.lower.x, box.lower.y, box.lower.z, box.upper.x, box.upper.y,
                                  box.upper.z},
              {2, 3});
}

// All hit boxes of that name: a mesh in several places is several of them.
std::vector<const HitBox*> hit_boxes_called(const Scene& scene, const std::string& name) {
  std::vector<const HitBox*> found;
  std::string names;
  for (const HitBox& box : scene.hit_boxes) {
    if (box.name == name) found.push_back(&box);
    names += (names.empty() ? "'" : ", '") + box.name + "'";
  }
  if (found.empty())
    throw Error((scene.path.empty() ? "scene" : scene.path) + ": there is no hit box '" + name +
                "'; " + (names.empty() ? "the scene has none" : "there are " + names));
  return found;
}

std::vector<std::string> hit_box_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const HitBox& box : scene.hit_boxes)
    if (std::find(names.begin(), names.end(), box.name) == names.end()) names.push_back(box.name);
  return names;
}

nb::object bounds_of_hit_box(const Scene& scene, const std::string& name) {
  Bounds all;
  for (const HitBox* box : hit_boxes_called(scene, name)) {
    const Bounds one = hit_box_bounds(*box);
    if (one.empty) continue;
    if (all.empty) all = one;
    all.lower = {std::min(all.lower.x, one.lower.x), std::min(all.lower.y, one.lower.y),
                 std::min(all.lower.z, one.lower.z)};
    all.upper = {std::max(all.upper.x, one.upper.x), std::max(all.upper.y, one.upper.y),
                 std::max(all.upper.z, one.upper.z)};
  }
  return corners(all);
}

nb::object inside_hit_box(const Scene& scene, const std::string& name, nb::handle points) {
  const std::vector<const HitBox*> boxes = hit_boxes_called(scene, name);
  const auto array = double_array(points, "points_m", {-1, 3});
  const std::size_t count = array.shape(0);
  auto* inside = new bool[count];
  nb::capsule owner(inside, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  run_long_work([&] {
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      const double* p = array.data() + 3 * i;
      inside[i] = std::any_of(boxes.begin(), boxes.end(), [&](const HitBox* box) {
        return is_inside(*box, {p[0], p[1], p[2]});
      });
    });
  });
  return nb::cast(nb::ndarray<nb::numpy, bool>(inside, {count}, owner), nb::rv_policy::reference);
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
          "A path to a PNG or JPEG (8 and 16 bit: sRGB), Radiance HDR or OpenEXR file (float:\n"
          "linear radiance), or an array of shape (height, width, 3 or 4): uint8 is sRGB, float is\n"
          "linear radiance. OpenEXR has channels R, G and B, or Y alone.\n\n"
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

  nb::class_<Scene>(
      m, "Scene",
      "A scene: meshes, instances, materials, textures, cameras and a background, in\n"
      "glTF's world frame (right-handed, +Y up, metres). Read-only.\n\n"
      "`omma.load_scene` reads one; ``Scene()`` is empty: nothing but background.")
      .def("__init__", [](Scene* self) { new (self) Scene(); })
      .def_prop_ro(
          "path", [](const Scene& s) { return path_object(s.path); },
          nb::sig("def path(self, /) -> str"), "The file it came from, '' for one made in memory.")
      .def_prop_ro(
          "cameras", [](const Scene& s) { return s.cameras; },
          "Camera nodes in the order of the file.")
      .def(
          "camera",
          [](const Scene& s, nb::handle which) {
            if (!nb::isinstance<nb::str>(which) && !PyIndex_Check(which.ptr()))
              throw nb::type_error(
                  ("name_or_index: expected a name or a whole number, found " + type_name_of(which))
                      .c_str());
            return choose_camera(s, str_of(which));
          },
          nb::arg("name_or_index"), nb::sig("def camera(self, name_or_index: str | int) -> Camera"),
          "The camera of that name, or with that index among ``cameras``; an index may also be\n"
          "text, where no camera is called so.\n\n"
          "Raises `omma.Error`, with the names and indices there are, where there is none or\n"
          "several are called so.")
      .def_prop_ro(
          "bounds", [](const Scene& s) { return corners(scene_bounds(s)); },
          nb::for_getter(
              nb::sig("def bounds(self, /) -> numpy.typing.NDArray[numpy.float64] | None")),
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
      .def_prop_ro("hit_boxes", &hit_box_names,
                   "Names of the regions: meshes whose extras say ``hitbox``, which are not drawn.")
      .def("hit_box_bounds", &bounds_of_hit_box, nb::arg("name"),
           nb::sig("def hit_box_bounds(self, name: str) -> numpy.typing.NDArray[numpy.float64] | "
                   "None"),
           "Lower and upper corner of the box around a hit box: (2, 3), m; None where it has no\n"
           "triangles.\n\nRaises `omma.Error`, with the names there are.")
      .def("is_inside", &inside_hit_box, nb::arg("name"), nb::arg("points_m"),
           nb::sig("def is_inside(self, name: str, points_m: numpy.typing.ArrayLike) -> "
                   "numpy.typing.NDArray[numpy.bool_]"),
           "Which points (N, 3), m, lie inside a hit box, taken as a closed surface: bool (N,).\n\n"
           "Raises `omma.Error`, with the names there are.")
      .def_prop_ro(
          "warnings",
          [](const Scene& s) {
            std::vector<std::string> sentences;
            for (const std::string& sentence : s.warnings)
              sentences.push_back(readable_text(sentence));
            return sentences;
          },
          "What the loader passed over, a sentence each.")
      .def("__repr__", [](const Scene& s) { return repr(s); });

  m.def(
      "load_scene",
      [](nb::handle path, int scene_index, const std::string& color_rule,
         const nb::object& progress) {
        const std::string name = path_text(path);
        if (color_rule != "gltf" && color_rule != "compoundray")
          throw Error("color_rule: expected gltf or compoundray, found '" + color_rule + "'");
        SceneOptions options;
        options.scene_index = scene_index;
        if (color_rule == "compoundray") options.color_rule = ColorRule::compoundray;
        auto scene = std::make_shared<Scene>();
        run_with_progress(progress, [&](const std::function<bool(double)>& report) {
          options.progress = report;
          *scene = load_scene(name, options);
        });
        return scene;
      },
      nb::arg("path"), nb::arg("scene_index") = -1, nb::arg("color_rule") = "gltf",
      nb::arg("progress") = nb::none(),
      nb::sig("def load_scene(path: str | os.PathLike[str], scene_index: int = -1, color_rule: str "
              "= 'gltf', progress: collections.abc.Callable[[float], object] | None = None) -> "
              "Scene"));
}

}  // namespace omma::python
