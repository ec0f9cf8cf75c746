// Lamps of a scene for Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "model/scene_light.h"
#include "scene_parts.h"

namespace omma::python {

namespace {

constexpr Words<PunctualLightType, 3> types = {{{"directional", PunctualLightType::directional},
                                                {"point", PunctualLightType::point},
                                                {"spot", PunctualLightType::spot}}};

}  // namespace

void bind_punctual_light(nb::module_& m) {
  nb::class_<PunctualLight> light(
      m, "PunctualLight",
      "A lamp without size, which shines in a world with a light: 'point' to all sides, 'spot' in "
      "a\n"
      "cone along its -Z, 'directional' along its -Z from afar, as KHR_lights_punctual has "
      "them.\n\n"
      "``color`` is linear, ``intensity`` in cd, of a directional one in lx; ``spectrum`` in\n"
      "W sr⁻¹ nm⁻¹, of a directional one in W m⁻² nm⁻¹, stands in place of both. ``range_m`` is\n"
      "where it ends, 0 nowhere. A spot has full intensity within ``inner_cone_rad`` of its axis\n"
      "and none beyond ``outer_cone_rad``. ``world_from_light`` is (4, 4), m.\n\n"
      "Raises `omma.Error`, which names the argument.");
  light
      .def(
          "__init__",
          [](PunctualLight* self, nb::handle name, nb::handle type, nb::handle color,
             nb::handle intensity, nb::handle range_m, nb::handle inner_cone_rad,
             nb::handle outer_cone_rad, nb::handle world_from_light, nb::handle spectrum) {
            PunctualLight made;
            made.name = text_argument(name, "name");
            made.type = word_argument(types, type, "type");
            made.color = to_float(vec3d(color, "color"));
            made.intensity = number_argument(intensity, "intensity");
            made.range_m = number_argument(range_m, "range_m");
            made.inner_cone_rad = number_argument(inner_cone_rad, "inner_cone_rad");
            made.outer_cone_rad = number_argument(outer_cone_rad, "outer_cone_rad");
            if (!world_from_light.is_none())
              made.world_from_light = mat4(world_from_light, "world_from_light");
            made.spectrum = spectrum_argument(spectrum, "spectrum");
            check_punctual_light(made, "");
            new (self) PunctualLight(valid_alone(std::move(made), &Scene::lights));
          },
          nb::arg("name") = "", nb::kw_only(), nb::arg("type") = "point",
          nb::arg("color") = nb::make_tuple(1.0, 1.0, 1.0), nb::arg("intensity") = 1.0,
          nb::arg("range_m") = 0.0, nb::arg("inner_cone_rad") = 0.0,
          nb::arg("outer_cone_rad") = pi / 4, nb::arg("world_from_light") = nb::none(),
          nb::arg("spectrum") = nb::none(),
          nb::sig("def __init__(self, name: str = '', *, type: str = 'point', color: "
                  "numpy.typing.ArrayLike = (1.0, 1.0, 1.0), intensity: float = 1.0, range_m: "
                  "float = 0.0, inner_cone_rad: float = 0.0, outer_cone_rad: float = "
                  "0.7853981633974483, world_from_light: numpy.typing.ArrayLike | None = None, "
                  "spectrum: Spectrum | None = None) -> None"))
      .def_ro("name", &PunctualLight::name)
      .def_prop_ro("type", [](const PunctualLight& l) { return word_of(types, l.type); })
      .def_prop_ro(
          "color", [](const PunctualLight& l) { return numbers(l.color); },
          nb::for_getter(nb::sig("def color(self, /) -> tuple[float, float, float]")))
      .def_ro("intensity", &PunctualLight::intensity)
      .def_ro("range_m", &PunctualLight::range_m)
      .def_ro("inner_cone_rad", &PunctualLight::inner_cone_rad)
      .def_ro("outer_cone_rad", &PunctualLight::outer_cone_rad)
      .def_prop_ro(
          "world_from_light",
          [](const PunctualLight& l) { return matrix_array(l.world_from_light); },
          nb::for_getter(nb::sig("def world_from_light(self, /) -> "
                                 "numpy.typing.NDArray[numpy.float64]")),
          "(4, 4), m.")
      .def_prop_ro(
          "spectrum", [](const PunctualLight& l) { return spectrum_or_none(l.spectrum); },
          nb::for_getter(nb::sig("def spectrum(self, /) -> Spectrum | None")))
      .def("__hash__",
           [](const PunctualLight& l) { return hash_of(l.name, static_cast<std::size_t>(l.type)); })
      .def("__repr__", [](const PunctualLight& l) {
        return named("PunctualLight", l.name) + ", " + word_of(types, l.type) + ">";
      });
  def_value(light, {"name", "type", "color", "intensity", "range_m", "inner_cone_rad",
                    "outer_cone_rad", "world_from_light", "spectrum"});
}

}  // namespace omma::python
