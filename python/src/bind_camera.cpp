// Cameras and their pictures for Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "arrays.h"
#include "omma/camera.h"
#include "progress.h"

namespace omma::python {

namespace {

const char* word(CameraType type) {
  switch (type) {
    case CameraType::perspective:
      return "perspective";
    case CameraType::orthographic:
      return "orthographic";
    case CameraType::panoramic:
      return "panoramic";
    case CameraType::compound:
      return "compound";
  }
  return "";
}

std::string repr(const Camera& camera) {
  std::string text = "<omma.scene.Camera '" + camera.name + "' " + word(camera.type);
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
  nb::class_<Camera>(m, "Camera", "A camera node of a scene. It looks along its -Z, +Y is up.")
      .def_ro("name", &Camera::name, "Name of the node (of the camera where the node has none).")
      .def_prop_ro(
          "type", [](const Camera& c) { return word(c.type); },
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
      .def("__repr__", [](const Camera& c) { return repr(c); });

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
