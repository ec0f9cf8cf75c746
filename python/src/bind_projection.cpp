// Pictures for Python: id maps, painting and PNG files.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>

#include "arrays.h"
#include "omma/error.h"
#include "omma/io.h"
#include "omma/projection.h"
#include "progress.h"

namespace omma::python {

namespace {

nb::object ids(const Eye& eye, int width, int height, bool by_position, float max_angle_rad) {
  auto map = run_long([&] {
    return by_position ? equirectangular_ids_by_position(eye, width, height, max_angle_rad)
                       : equirectangular_ids(eye, width, height, max_angle_rad);
  });
  return take(std::move(map), {static_cast<std::size_t>(height), static_cast<std::size_t>(width)});
}

nb::object projection_map(const Eye& eye, const std::string& projection, int width, int height) {
  auto map = run_long(
      [&] { return projection_ids(eye, projection_from_name(projection), width, height); });
  return take(std::move(map), {static_cast<std::size_t>(height), static_cast<std::size_t>(width)});
}

nb::object field_map(const Eye& eye, int width, int height, bool side_by_side) {
  auto map = run_long([&] {
    return side_by_side ? side_by_side_ids(eye, width, height) : field_ids(eye, width, height);
  });
  const std::size_t columns = map.size() / static_cast<std::size_t>(height);
  return take(std::move(map), {static_cast<std::size_t>(height), columns});
}

nb::object encode_array(nb::handle ids_object) {
  const auto map = int_array(ids_object, "ids", {-1, -1});
  return take(run_long([&] {
                return encode_ids({map.data(), map.size()});
              }),
              {map.shape(0), map.shape(1), 4});
}

nb::object paint_array(nb::handle ids_object, nb::handle responses_object, double gamma) {
  const auto map = int_array(ids_object, "ids", {-1, -1});
  const auto responses = float_array(responses_object, "responses", {-1, rgb_bands});
  if (!(gamma > 0)) throw Error("gamma: expected a number over 0, found " + std::to_string(gamma));
  const auto count = static_cast<std::int32_t>(responses.shape(0));
  const std::span<const std::int32_t> map_span(map.data(), map.size());
  auto pixels = run_long([&] {
    for (const std::int32_t id : map_span)
      if (id < -1 || id >= count)
        throw Error("ids: expected numbers under " + std::to_string(count) +
                    " (the ommatidia in responses), found " + std::to_string(id));
    return paint(map_span, {responses.data(), responses.size()}, gamma);
  });
  return take(std::move(pixels), {map.shape(0), map.shape(1), 3});
}

using Pixels = nb::ndarray<nb::numpy, const std::uint8_t, nb::ndim<3>, nb::c_contig>;

Pixels to_pixels(nb::handle pixels) {
  const nb::object packed = nb::module_::import_("numpy").attr("ascontiguousarray")(pixels);
  Pixels array;
  const bool matches =
      nb::try_cast(packed, array, false) && (array.shape(2) == 3 || array.shape(2) == 4);
  if (!matches || array.size() == 0 || array.shape(0) > 1 << 16 || array.shape(1) > 1 << 16)
    throw Error("pixels: expected uint8 of shape (height, width, 3 or 4), found " +
                str_of(packed.attr("dtype")) + " of shape " + str_of(packed.attr("shape")));
  return array;
}

void save_png_array(nb::handle path, nb::handle pixels) {
  const Pixels array = to_pixels(pixels);
  const std::string name = path_text(path);
  run_with_progress(nb::none(), [&](const std::function<bool(double)>& report) {
    save_png(name, {array.data(), array.size()}, static_cast<int>(array.shape(1)),
             static_cast<int>(array.shape(0)), static_cast<int>(array.shape(2)), report);
  });
}

nb::bytes encode_png_array(nb::handle path, nb::handle pixels, bool quick) {
  const Pixels array = to_pixels(pixels);
  const std::string name = path_text(path);
  std::string bytes;
  run_with_progress(nb::none(), [&](const std::function<bool(double)>& report) {
    bytes = png_bytes(name, {array.data(), array.size()}, static_cast<int>(array.shape(1)),
                      static_cast<int>(array.shape(0)), static_cast<int>(array.shape(2)),
                      quick ? PngPacking::quick : PngPacking::small, report);
  });
  return nb::bytes(bytes.data(), bytes.size());
}

}  // namespace

void bind_projection(nb::module_& m) {
  m.def("equirectangular_ids", &ids, nb::arg("eye"), nb::arg("width"), nb::arg("height"),
        nb::arg("by_position"), nb::arg("max_angle_rad"),
        nb::sig("def equirectangular_ids(eye: Eye, width: int, height: int, by_position: bool, "
                "max_angle_rad: float) -> numpy.typing.NDArray[numpy.int32]"));
  m.def("projection_ids", &projection_map, nb::arg("eye"), nb::arg("projection"), nb::arg("width"),
        nb::arg("height"),
        nb::sig("def projection_ids(eye: Eye, projection: str, width: int, height: int) -> "
                "numpy.typing.NDArray[numpy.int32]"));
  m.def("field_ids", &field_map, nb::arg("eye"), nb::arg("width"), nb::arg("height"),
        nb::arg("side_by_side"),
        nb::sig("def field_ids(eye: Eye, width: int, height: int, side_by_side: bool) -> "
                "numpy.typing.NDArray[numpy.int32]"));
  m.def("projection_names", [] {
    std::vector<std::string> names;
    for (const NamedProjection& named : named_projections()) names.emplace_back(named.name);
    return names;
  });
  m.def("encode_ids", &encode_array, nb::arg("ids"),
        nb::sig("def encode_ids(ids: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.uint8]"),
        "An id map (height, width) as an RGBA picture, uint8 (height, width, 4).\n\n"
        "The id is a 32-bit number, its highest byte in R, its lowest in A, as in CompoundRay's\n"
        "``_ids`` projections; -1 is 255, 255, 255, 255. Back again: ``picture.view('>i4')[..., "
        "0]``.\n\n"
        "Raises `omma.Error` where the ids are not two-dimensional whole numbers.");
  m.def(
      "paint", &paint_array, nb::arg("ids"), nb::arg("responses"), nb::arg("gamma") = 2.2,
      nb::sig("def paint(ids: numpy.typing.ArrayLike, responses: numpy.typing.ArrayLike, gamma: "
              "float = 2.2) -> numpy.typing.NDArray[numpy.uint8]"),
      "One pose's responses (N, 3) through an id map (height, width) as an 8-bit RGB picture\n"
      "(height, width, 3). Display value = 255 * clamp(response)^(1/gamma); id -1 is mid grey.\n\n"
      "Raises `omma.Error` on a wrong shape, an id over N or a gamma that is not over 0.");
  m.def("save_png", &save_png_array, nb::arg("path"), nb::arg("pixels"),
        nb::sig("def save_png(path: str | os.PathLike[str], pixels: "
                "numpy.typing.NDArray[numpy.uint8]) -> None"),
        "Write 8-bit pixels (height, width, 3 or 4), row 0 at the top, as a PNG file.\n\n"
        "It is written under another name and renamed, so that no half of a file is left.\n"
        "Raises `omma.Error` where the pixels or the path do not do.");
  m.def("encode_png", &encode_png_array, nb::arg("path"), nb::arg("pixels"),
        nb::arg("quick") = false,
        nb::sig("def encode_png(path: str | os.PathLike[str], pixels: "
                "numpy.typing.NDArray[numpy.uint8], quick: bool = False) -> bytes"));
}

}  // namespace omma::python
