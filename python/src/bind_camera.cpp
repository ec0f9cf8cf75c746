// Cameras and their pictures for Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "io/gltf.h"
#include "omma/camera.h"
#include "progress.h"
#include "values.h"

namespace omma::python {

namespace {

constexpr Words<CameraType, 4> types = {{{"perspective", CameraType::perspective},
                                         {"orthographic", CameraType::orthographic},
                                         {"panoramic", CameraType::panoramic},
                                         {"compound", CameraType::compound}}};

// What is in the camera's extras says too what type it is: the one that was asked for.
Camera made_camera(nb::handle name, nb::handle type, nb::handle world_from_camera,
                   nb::handle yfov_rad, nb::handle aspect_ratio, nb::handle xmag_m,
                   nb::handle ymag_m, nb::handle znear_m, nb::handle zfar_m, nb::handle extras,
                   nb::handle data_name) {
  Camera camera;
  camera.name = text_argument(name, "name");
  camera.data_name = text_argument(data_name, "data_name");
  const CameraType wanted = word_argument(types, type, "type");
  if (!world_from_camera.is_none())
    camera.world_from_camera = mat4(world_from_camera, "world_from_camera");
  const bool flat = wanted == CameraType::orthographic;
  camera.type = flat ? wanted : CameraType::perspective;
  if (flat) {
    camera.xmag_m = number_argument(xmag_m, "xmag_m");
    camera.ymag_m = number_argument(ymag_m, "ymag_m");
  } else {
    camera.yfov_rad = number_argument(yfov_rad, "yfov_rad");
    camera.aspect_ratio = number_argument(aspect_ratio, "aspect_ratio");
  }
  camera.znear_m = number_argument(znear_m, "znear_m");
  camera.zfar_m = number_argument(zfar_m, "zfar_m");
  nb::object all = nb::borrow(extras);
  const char* flag = wanted == CameraType::panoramic  ? "panoramic"
                     : wanted == CameraType::compound ? "compound-eye"
                                                      : nullptr;
  if (flag != nullptr) {
    nb::dict flagged;
    flagged[flag] = "true";
    if (!all.is_none()) {
      if (!nb::isinstance<nb::dict>(all))
        throw nb::type_error(("extras: expected a dict, found " + type_name_of(all)).c_str());
      flagged.update(nb::borrow<nb::dict>(all));
    }
    all = flagged;
  }
  if (!all.is_none()) {
    std::string text;
    try {
      text = nb::cast<std::string>(
          nb::module_::import_("json").attr("dumps")(all, nb::arg("allow_nan") = false));
    } catch (nb::python_error& error) {
      if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
      throw Error("extras: expected what JSON can hold");
    }
    read_camera_extras(camera, text);
  }
  if (camera.type != wanted)
    throw Error(std::string("extras: say that the camera is ") + word_of(types, camera.type) +
                ", but its type is " + word_of(types, wanted));
  return valid_alone(std::move(camera), &Scene::cameras);
}

std::string repr(const Camera& camera) {
  std::string text = "<omma.scene.Camera '" + camera.name + "' " + word_of(types, camera.type);
  if (!camera.compound_structure.empty()) text += ", eye '" + camera.compound_structure + "'";
  return text + ">";
}

nb::object extras(const Camera& camera) {
  if (camera.extras_json.empty()) return nb::dict();
  return nb::module_::import_("json").attr("loads")(camera.extras_json);
}

using Picture = nb::ndarray<nb::numpy, float, nb::shape<-1, -1, -1>, nb::c_contig>;

void render(const World& world, const Camera& camera, const Picture& picture, int samples,
            std::uint64_t seed, const nb::object& progress) {
  const CameraSettings settings{
      {static_cast<int>(picture.shape(1)), static_cast<int>(picture.shape(0))}, samples, seed};
  run_with_progress(progress, [&](const std::function<bool(double)>& report) {
    render_camera(world, camera, settings, {picture.data(), picture.size()}, report);
  });
}

}  // namespace

void bind_camera(nb::module_& m) {
  nb::class_<Camera> camera_class(
      m, "Camera",
      "A camera node of a scene. It looks along its -Z, +Y is up.\n\n"
      "Its type is 'perspective' (vertical field of view ``yfov_rad``, width over height\n"
      "``aspect_ratio``, 0: any), 'orthographic' (half extents ``xmag_m`` and ``ymag_m``),\n"
      "'panoramic', or 'compound', of which ``extras`` names the eye (\"compound-structure\", an\n"
      "`.eye` file, and \"compound-projection\"). What is nearer than ``znear_m`` or farther than\n"
      "``zfar_m`` is seen all the same: the two are for other programs.");
  camera_class
      .def(
          "__init__",
          [](Camera* self, nb::handle name, nb::handle type, nb::handle world_from_camera,
             nb::handle yfov_rad, nb::handle aspect_ratio, nb::handle xmag_m, nb::handle ymag_m,
             nb::handle znear_m, nb::handle zfar_m, nb::handle extras, nb::handle data_name) {
            new (self) Camera(made_camera(name, type, world_from_camera, yfov_rad, aspect_ratio,
                                          xmag_m, ymag_m, znear_m, zfar_m, extras, data_name));
          },
          nb::arg("name") = "", nb::kw_only(), nb::arg("type") = "perspective",
          nb::arg("world_from_camera") = nb::none(), nb::arg("yfov_rad") = 1.0,
          nb::arg("aspect_ratio") = 0.0, nb::arg("xmag_m") = 1.0, nb::arg("ymag_m") = 1.0,
          nb::arg("znear_m") = 0.01, nb::arg("zfar_m") = 1000.0, nb::arg("extras") = nb::none(),
          nb::arg("data_name") = "",
          nb::sig("def __init__(self, name: str = '', *, type: str = 'perspective', "
                  "world_from_camera: numpy.typing.ArrayLike | None = None, yfov_rad: float = 1.0, "
                  "aspect_ratio: float = 0.0, xmag_m: float = 1.0, ymag_m: float = 1.0, znear_m: "
                  "float = 0.01, zfar_m: float = 1000.0, extras: typing.Any = None, data_name: str "
                  "= '') -> None"))
      .def_ro("name", &Camera::name, "Name of the node (of the camera where the node has none).")
      .def_prop_ro(
          "type", [](const Camera& c) { return word_of(types, c.type); },
          "'perspective', 'orthographic', 'panoramic' or 'compound'.")
      .def_prop_ro(
          "world_from_camera", [](const Camera& c) { return matrix_array(c.world_from_camera); },
          nb::for_getter(nb::sig("def world_from_camera(self, /) -> "
                                 "numpy.typing.NDArray[numpy.float64]")),
          "The node's whole transform, its scale too: (4, 4), m.")
      .def_prop_ro("extras", &extras, nb::for_getter(nb::sig("def extras(self, /) -> typing.Any")),
                   "The camera's extras in the glTF file, {} where there are none.")
      .def_ro("compound_structure", &Camera::compound_structure,
              "The `.eye` file that the camera's extras name, '' where they name none.")
      .def_ro("compound_projection", &Camera::compound_projection,
              "The projection of its eye that the camera's extras name, '' where they name none.")
      .def_ro("yfov_rad", &Camera::yfov_rad, "Vertical field of view; perspective only.")
      .def_ro("aspect_ratio", &Camera::aspect_ratio,
              "Width over height, 0 where not given; perspective only.")
      .def_ro("xmag_m", &Camera::xmag_m, "Horizontal half extent; orthographic only.")
      .def_ro("ymag_m", &Camera::ymag_m, "Vertical half extent; orthographic only.")
      .def_ro("znear_m", &Camera::znear_m)
      .def_ro("zfar_m", &Camera::zfar_m, "0 where the file gives none.")
      .def_ro("data_name", &Camera::data_name,
              "Name of the camera itself, by which it is found too.")
      .def("__hash__", [](const Camera& c) { return std::hash<std::string>{}(c.name); })
      .def("__repr__", [](const Camera& c) { return repr(c); });
  def_value(camera_class, {"name", "type", "world_from_camera", "yfov_rad", "aspect_ratio",
                           "xmag_m", "ymag_m", "znear_m", "zfar_m", "extras", "data_name"});

  m.attr("max_picture_extent") = max_picture_extent;
  m.def(
      "picture_size",
      [](const Camera& camera, int width, int height) {
        const PictureSize size = picture_size(camera, width, height);
        return nb::make_tuple(size.width, size.height);
      },
      nb::arg("camera"), nb::arg("width"), nb::arg("height"),
      nb::sig("def picture_size(camera: Camera, width: int, height: int) -> tuple[int, int]"));
  m.def("render_camera", &render, nb::arg("world"), nb::arg("camera"),
        nb::arg("picture").noconvert(), nb::arg("samples"), nb::arg("seed"),
        nb::arg("progress").none(),
        nb::sig("def render_camera(world: World, camera: Camera, picture: "
                "numpy.typing.NDArray[numpy.float32], samples: int, seed: int, progress: "
                "collections.abc.Callable[[float], object] | None) -> None"));
}

}  // namespace omma::python
