// SplatCloud for Python: Gaussian splats of one capture.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "scene_parts.h"

namespace omma::python {

namespace {

using Self = nb::handle_t<SplatCloud>;

constexpr Words<SplatColor, 2> color_spaces = {
    {{"srgb", SplatColor::srgb}, {"linear", SplatColor::linear}}};
constexpr Words<SplatDirection, 2> directions = {
    {{"center", SplatDirection::center}, {"ray", SplatDirection::ray}}};

template <typename Vector>
std::vector<Vector> rows_argument(nb::handle object, const char* name) {
  constexpr std::size_t components = sizeof(Vector) / sizeof(float);
  const auto array = float_array(object, name, {-1, static_cast<std::int64_t>(components)});
  const auto* rows = reinterpret_cast<const Vector*>(array.data());
  return {rows, rows + array.shape(0)};
}

void init(SplatCloud* self, nb::handle positions_m, nb::handle scales_m, nb::handle rotations,
          nb::handle opacities, nb::handle harmonics, nb::handle color_space, nb::handle direction,
          nb::handle white, nb::handle bands_nm, nb::handle world_from_splats, nb::handle name) {
  SplatCloud made;
  made.positions = rows_argument<Vec3>(positions_m, "positions_m");
  made.scales = rows_argument<Vec3>(scales_m, "scales_m");
  made.rotations = rows_argument<Vec4>(rotations, "rotations");
  const auto opacity = float_array(opacities, "opacities", {-1});
  made.opacities.assign(opacity.data(), opacity.data() + opacity.shape(0));
  if (!bands_nm.is_none()) {
    const auto bands = double_array(bands_nm, "bands_nm", {-1, 2});
    for (std::size_t c = 0; c < bands.shape(0); ++c)
      made.bands_nm.push_back({bands.data()[2 * c], bands.data()[2 * c + 1]});
  }
  const auto channels = static_cast<std::int64_t>(channels_of(made));
  const auto colors = float_array(harmonics, "harmonics", {-1, -1, channels});
  made.harmonics.assign(colors.data(), colors.data() + colors.size());
  made.terms = static_cast<int>(colors.shape(1));
  made.color_space = word_argument(color_spaces, color_space, "color_space");
  made.direction = word_argument(directions, direction, "direction");
  made.white.assign(channels_of(made), 1.0f);
  if (!white.is_none()) {
    const auto linear = float_array(white, "white", {channels});
    made.white.assign(linear.data(), linear.data() + linear.size());
  }
  if (!world_from_splats.is_none())
    made.world_from_splats = mat4(world_from_splats, "world_from_splats");
  made.name = text_argument(name, "name");
  new (self) SplatCloud(valid_alone(std::move(made), &Scene::splats));
}

const SplatCloud& cloud_of(nb::handle self) {
  return nb::cast<const SplatCloud&>(self);
}

}  // namespace

void bind_splats(nb::module_& m) {
  nb::class_<SplatCloud> cloud(
      m, "SplatCloud",
      "Gaussian splats (Kerbl et al. 2023, doi:10.1145/3592433): a place as photographs have it, "
      "N\n"
      "soft ellipsoids, each with an opacity and a colour that depends on from where it is seen.\n"
      "They hold the light of their capture, and nothing lights them.\n\n"
      "``positions_m`` (N, 3) are their middles, ``scales_m`` (N, 3), m, standard deviations "
      "along\n"
      "their own axes, which ``rotations`` (N, 4), unit quaternions x, y, z, w, turn;\n"
      "``opacities`` (N,), 0 to 1; ``harmonics`` (N, 1, 4, 9 or 16, C), spherical harmonics of\n"
      "degree 0 to 3 by channel, in the order and with the signs of Kerbl et al.: a colour is 0.5\n"
      "and their sum, no less than 0. Channels are RGB; ``bands_nm`` (C, 2) names others, 3 to 16\n"
      "bands from one wavelength to another, in which a lit world sees them; one that is not lit\n"
      "shows the first three as RGB. ``color_space``, 'srgb' or 'linear', is that in which they "
      "were\n"
      "trained and are composited; ``direction`` is what colours depend on: 'center', from where "
      "a\n"
      "ray starts to the middle of a splat, as Kerbl et al. have it, or 'ray', its own direction,\n"
      "as Moenne-Loccoz et al. 2024 (doi:10.1145/3687934). ``white`` (C,) is what a colour of 1 "
      "is\n"
      "in linear numbers, all 1 where it is None; `omma.scene.calibrate` finds it.\n"
      "``world_from_splats`` (4, 4) places them, m.\n\n"
      "Raises `omma.Error`, which names the splat, where sizes do not go together or a number is\n"
      "not what it stands for.");
  cloud
      .def("__init__", &init, required("positions_m"), required("scales_m"), required("rotations"),
           required("opacities"), required("harmonics"), nb::kw_only(),
           nb::arg("color_space") = "srgb", nb::arg("direction") = "center",
           nb::arg("white") = nb::none(), nb::arg("bands_nm") = nb::none(),
           nb::arg("world_from_splats") = nb::none(), nb::arg("name") = "",
           nb::sig(
               "def __init__(self, positions_m: numpy.typing.ArrayLike, scales_m: "
               "numpy.typing.ArrayLike, rotations: numpy.typing.ArrayLike, opacities: "
               "numpy.typing.ArrayLike, harmonics: numpy.typing.ArrayLike, *, color_space: str "
               "= 'srgb', direction: str = 'center', white: numpy.typing.ArrayLike | None = None, "
               "bands_nm: numpy.typing.ArrayLike | None = None, world_from_splats: "
               "numpy.typing.ArrayLike | None = None, name: str = '') -> None"))
      .def_prop_ro(
          "positions_m",
          [](Self self) { return vectors_view<float>(self, cloud_of(self).positions); },
          nb::for_getter(
              nb::sig("def positions_m(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "(N, 3), m, in their own frame.")
      .def_prop_ro(
          "scales_m", [](Self self) { return vectors_view<float>(self, cloud_of(self).scales); },
          nb::for_getter(nb::sig("def scales_m(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "(N, 3), m.")
      .def_prop_ro(
          "rotations",
          [](Self self) { return vectors_view<float>(self, cloud_of(self).rotations); },
          nb::for_getter(nb::sig("def rotations(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "(N, 4), x, y, z, w.")
      .def_prop_ro(
          "opacities",
          [](Self self) {
            const std::vector<float>& values = cloud_of(self).opacities;
            return view(self, values.data(), {values.size()});
          },
          nb::for_getter(nb::sig("def opacities(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "(N,), 0 to 1.")
      .def_prop_ro(
          "harmonics",
          [](Self self) {
            const SplatCloud& c = cloud_of(self);
            return view(self, c.harmonics.data(),
                        {c.positions.size(), static_cast<std::size_t>(c.terms), channels_of(c)});
          },
          nb::for_getter(nb::sig("def harmonics(self, /) -> numpy.typing.NDArray[numpy.float32]")),
          "(N, 1, 4, 9 or 16, C).")
      .def_prop_ro("color_space",
                   [](const SplatCloud& c) { return word_of(color_spaces, c.color_space); })
      .def_prop_ro("direction",
                   [](const SplatCloud& c) { return word_of(directions, c.direction); })
      .def_prop_ro(
          "white",
          [](const SplatCloud& c) {
            nb::list values;
            for (const float w : c.white) values.append(w);
            return nb::tuple(values);
          },
          nb::for_getter(nb::sig("def white(self, /) -> tuple[float, ...]")),
          "(C,), linear, what a colour of 1 is.")
      .def_prop_ro(
          "bands_nm",
          [](const SplatCloud& c) -> nb::object {
            if (c.bands_nm.empty()) return nb::none();
            nb::list bands;
            for (const auto& [from_nm, to_nm] : c.bands_nm)
              bands.append(nb::make_tuple(from_nm, to_nm));
            return nb::tuple(bands);
          },
          nb::for_getter(
              nb::sig("def bands_nm(self, /) -> tuple[tuple[float, float], ...] | None")),
          "(C, 2), nm, or None: RGB.")
      .def_prop_ro(
          "world_from_splats",
          [](const SplatCloud& c) { return matrix_array(c.world_from_splats); },
          nb::for_getter(nb::sig("def world_from_splats(self, /) -> "
                                 "numpy.typing.NDArray[numpy.float64]")),
          "(4, 4), m.")
      .def_ro("name", &SplatCloud::name)
      .def("__hash__", [](const SplatCloud& c) { return hash_of(c.name, c.positions.size()); })
      .def("__repr__", [](const SplatCloud& c) {
        return named("SplatCloud", c.name) + " of " + counted(c.positions.size(), "splats>");
      });
  def_value(cloud, {"positions_m", "scales_m", "rotations", "opacities", "harmonics", "color_space",
                    "direction", "white", "bands_nm", "world_from_splats", "name"});
}

}  // namespace omma::python
