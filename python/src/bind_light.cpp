// What worlds are lit by, for Python: the engine's light, made once of the arrays that
// omma.light has put together.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "arrays.h"
#include "backend/scatter_data.h"
#include "light/check_light.h"
#include "omma/error.h"
#include "omma/light.h"
#include "progress.h"
#include "values.h"

namespace omma::python {

namespace {

using Self = nb::handle_t<Light>;

constexpr Words<LightUnit, 2> units = {
    {{"photons", LightUnit::photons}, {"watts", LightUnit::watts}}};

template <typename T>
std::vector<T> vector_of(const InputArray<T>& array) {
  return {array.data(), array.data() + array.size()};
}

std::shared_ptr<const SkyMap> sky_argument(nb::handle radiance, nb::handle band_from_channel) {
  if (radiance.is_none()) {
    if (!band_from_channel.is_none())
      throw Error("band_from_channel: expected None where there is no sky");
    return nullptr;
  }
  const auto values = float_array(radiance, "sky", {2, -1, -1, -1, -1});
  for (std::size_t axis = 1; axis < 5; ++axis)
    if (values.shape(axis) > std::size_t{most_sky_columns})
      throw Error("sky: expected at most 65536 along each axis, found " +
                  std::to_string(values.shape(axis)));
  auto sky = std::make_shared<SkyMap>();
  sky->rows = static_cast<int>(values.shape(1));
  sky->columns = static_cast<int>(values.shape(2));
  sky->components = static_cast<int>(values.shape(3));
  sky->channels = static_cast<int>(values.shape(4));
  sky->radiance = vector_of(values);
  if (!band_from_channel.is_none())
    sky->band_from_channel =
        vector_of(double_array(band_from_channel, "band_from_channel", {-1, sky->channels}));
  return sky;
}

std::vector<Disc> discs_argument(nb::handle discs) {
  std::vector<Disc> made;
  for (const nb::handle item : discs) {
    if (!nb::isinstance<nb::tuple>(item) || nb::len(item) != 4)
      throw Error(
          "discs: expected tuples (direction, angular_radius_rad, radiance, limb_darkening), "
          "found " +
          type_name_of(item));
    Disc disc;
    disc.direction = to_float(vec3d(item[0], "discs: direction"));
    disc.angular_radius_rad = number_argument(item[1], "discs: angular_radius_rad");
    disc.radiance = vector_of(double_array(item[2], "discs: radiance", {-1}));
    if (!nb::object(item[3]).is_none())
      disc.limb_darkening = vector_of(double_array(item[3], "discs: limb_darkening", {-1}));
    made.push_back(std::move(disc));
  }
  return made;
}

std::shared_ptr<const CloudShadow> cloud_shadow_argument(nb::handle given) {
  if (given.is_none()) return nullptr;
  if (!nb::isinstance<nb::tuple>(given) || nb::len(given) != 4)
    throw Error(
        "cloud_shadow: expected a tuple (optical_depth, spacing_m, height_m, first_m), found " +
        type_name_of(given));
  const auto depth = float_array(given[0], "cloud_shadow: optical_depth", {-1, -1});
  auto made = std::make_shared<CloudShadow>();
  made->rows = static_cast<int>(depth.shape(0));
  made->columns = static_cast<int>(depth.shape(1));
  made->optical_depth.assign(depth.data(), depth.data() + depth.size());
  made->spacing_m = number_argument(given[1], "cloud_shadow: spacing_m");
  made->height_m = number_argument(given[2], "cloud_shadow: height_m");
  const auto first = double_array(given[3], "cloud_shadow: first_m", {2});
  made->first_x_m = first.data()[0];
  made->first_z_m = first.data()[1];
  return made;
}

Light light_of(nb::handle wavelength_nm, nb::handle weight, nb::handle cell_nm, nb::handle unit,
               nb::handle sky, nb::handle band_from_channel, nb::handle discs,
               nb::handle extinction_per_m, nb::handle cloud_shadow, nb::handle ultraviolet,
               nb::handle emission_cd_m2, bool bottomless) {
  Light light;
  light.bands.wavelength_nm = vector_of(double_array(wavelength_nm, "wavelength_nm", {-1}));
  light.bands.weight = vector_of(double_array(
      weight, "weight", {-1, static_cast<std::int64_t>(light.bands.wavelength_nm.size())}));
  if (!cell_nm.is_none()) light.bands.cell_nm = vector_of(double_array(cell_nm, "cell_nm", {-1}));
  light.unit = word_argument(units, unit, "unit");
  light.sky = sky_argument(sky, band_from_channel);
  light.discs = discs_argument(discs);
  if (!extinction_per_m.is_none())
    light.extinction_per_m = vector_of(double_array(extinction_per_m, "extinction_per_m", {-1}));
  light.cloud_shadow = cloud_shadow_argument(cloud_shadow);
  if (!ultraviolet.is_none()) {
    const auto weights = double_array(ultraviolet, "ultraviolet", {-1, 4});
    light.ultraviolet.resize(weights.shape(0));
    for (std::size_t i = 0; i < light.ultraviolet.size(); ++i)
      std::copy_n(weights.data() + 4 * i, 4, light.ultraviolet[i].begin());
  }
  light.emission_cd_m2 = number_argument(emission_cd_m2, "emission_cd_m2");
  light.bottomless = bottomless;
  return light;
}

nb::object values_or_none(nb::handle owner, const std::vector<double>& values,
                          std::size_t columns) {
  if (values.empty()) return nb::none();
  return view(owner, values.data(), {values.size() / columns, columns});
}

nb::object sky_view(Self self) {
  const SkyMap* sky = nb::cast<const Light&>(self).sky.get();
  if (sky == nullptr) return nb::none();
  const auto size = [](int x) { return static_cast<std::size_t>(x); };
  return view(self, sky->radiance.data(),
              {2, size(sky->rows), size(sky->columns), size(sky->components), size(sky->channels)});
}

nb::object disc_views(Self self) {
  nb::list discs;
  for (const Disc& disc : nb::cast<const Light&>(self).discs)
    discs.append(nb::make_tuple(
        nb::make_tuple(disc.direction.x, disc.direction.y, disc.direction.z),
        disc.angular_radius_rad, view(self, disc.radiance.data(), {disc.radiance.size()}),
        disc.limb_darkening.empty()
            ? nb::none()
            : view(self, disc.limb_darkening.data(), {disc.limb_darkening.size()})));
  return nb::tuple(discs);
}

}  // namespace

void bind_light(nb::module_& m) {
  nb::class_<Light>(
      m, "Light",
      "What the engine lights a world with; the values of `omma.light` are the ones to use.\n\n"
      "Args:\n"
      "    wavelength_nm: (K,), ascending.\n"
      "    weight: (B, K), of the wavelengths in each band, adding up to 1.\n"
      "    cell_nm: (K,), how much there is about each wavelength that its weight stands for; "
      "None:\n"
      "        the wavelengths alone.\n"
      "    unit: 'photons' (m^-2 s^-1 sr^-1 nm^-1) or 'watts' (m^-2 sr^-1 nm^-1).\n"
      "    sky: radiance by direction, (2, rows, columns, components, channels): above and below\n"
      "        the horizon, from it to the zenith and the nadir, to the right from -Z; 1 "
      "component\n"
      "        (I) or 3 (I, Q, U). None: dark.\n"
      "    band_from_channel: (B, channels); None: channels are the bands.\n"
      "    discs: tuples (direction (3,), angular_radius_rad, radiance (B,), limb_darkening (B,)\n"
      "        or None).\n"
      "    extinction_per_m: (B,), of the air between surfaces; None: it is clear.\n"
      "    cloud_shadow: (optical_depth (rows, columns), spacing_m, height_m, (x, z) of the first\n"
      "        node, m), of clouds that shade what lies below them from discs; None: none do.\n"
      "    ultraviolet: (M, 4), of each material of the scene that will be lit: reflectance below\n"
      "        400 nm of what is known in RGB only, as weights of red, green, blue and 1.\n"
      "    emission_cd_m2: what white emission of 1 is, cd m^-2.\n"
      "    bottomless: whether the air between surfaces goes on below without end, as water "
      "does.\n\n"
      "Raises `omma.Error` that names the argument.")
      .def(
          "__init__",
          [](Light* self, nb::handle wavelength_nm, nb::handle weight, nb::handle cell_nm,
             nb::handle unit, nb::handle sky, nb::handle band_from_channel, nb::handle discs,
             nb::handle extinction_per_m, nb::handle cloud_shadow, nb::handle ultraviolet,
             nb::handle emission_cd_m2, bool bottomless) {
            Light made =
                light_of(wavelength_nm, weight, cell_nm, unit, sky, band_from_channel, discs,
                         extinction_per_m, cloud_shadow, ultraviolet, emission_cd_m2, bottomless);
            run_long_work([&] { validate_light(made, made.ultraviolet.size()); });
            new (self) Light(std::move(made));
          },
          nb::arg("wavelength_nm"), nb::arg("weight"), nb::arg("cell_nm").none(), nb::arg("unit"),
          nb::arg("sky").none(), nb::arg("band_from_channel").none(), nb::arg("discs"),
          nb::arg("extinction_per_m").none(), nb::arg("cloud_shadow").none(),
          nb::arg("ultraviolet").none(), nb::arg("emission_cd_m2") = 1.0,
          nb::arg("bottomless") = false,
          nb::sig("def __init__(self, wavelength_nm: numpy.typing.ArrayLike, weight: "
                  "numpy.typing.ArrayLike, cell_nm: numpy.typing.ArrayLike | None, unit: str, "
                  "sky: numpy.typing.ArrayLike | None, "
                  "band_from_channel: numpy.typing.ArrayLike | None, discs: "
                  "collections.abc.Iterable[tuple[numpy.typing.ArrayLike, float, "
                  "numpy.typing.ArrayLike, numpy.typing.ArrayLike | None]], extinction_per_m: "
                  "numpy.typing.ArrayLike | None, cloud_shadow: tuple[numpy.typing.ArrayLike, "
                  "float, float, numpy.typing.ArrayLike] | None, ultraviolet: "
                  "numpy.typing.ArrayLike | None, emission_cd_m2: float = 1.0, "
                  "bottomless: bool = False) -> None"))
      .def_prop_ro(
          "wavelength_nm",
          [](Self self) {
            const auto& nm = nb::cast<const Light&>(self).bands.wavelength_nm;
            return view(self, nm.data(), {nm.size()});
          },
          nb::for_getter(
              nb::sig("def wavelength_nm(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "Read-only, (K,).")
      .def_prop_ro(
          "weight",
          [](Self self) {
            const Bands& bands = nb::cast<const Light&>(self).bands;
            return view(self, bands.weight.data(), {bands.count(), bands.wavelength_nm.size()});
          },
          nb::for_getter(nb::sig("def weight(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "Read-only, (B, K).")
      .def_prop_ro(
          "unit", [](const Light& light) { return word_of(units, light.unit); },
          "'photons' or 'watts'.")
      .def_prop_ro(
          "sky", &sky_view,
          nb::for_getter(nb::sig("def sky(self, /) -> numpy.typing.NDArray[numpy.float32] | None")),
          "Read-only, as given; or None.")
      .def_prop_ro(
          "band_from_channel",
          [](Self self) -> nb::object {
            const SkyMap* sky = nb::cast<const Light&>(self).sky.get();
            if (sky == nullptr) return nb::none();
            return values_or_none(self, sky->band_from_channel,
                                  static_cast<std::size_t>(sky->channels));
          },
          nb::for_getter(nb::sig(
              "def band_from_channel(self, /) -> numpy.typing.NDArray[numpy.float64] | None")),
          "Read-only, (B, channels); or None.")
      .def_prop_ro(
          "discs", &disc_views,
          nb::for_getter(nb::sig(
              "def discs(self, /) -> tuple[tuple[tuple[float, float, float], float, "
              "numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64] | None], "
              "...]")),
          "Tuples as given.")
      .def_prop_ro(
          "extinction_per_m",
          [](Self self) -> nb::object {
            const auto& extinction = nb::cast<const Light&>(self).extinction_per_m;
            if (extinction.empty()) return nb::none();
            return view(self, extinction.data(), {extinction.size()});
          },
          nb::for_getter(nb::sig(
              "def extinction_per_m(self, /) -> numpy.typing.NDArray[numpy.float64] | None")),
          "Read-only, (B,); or None.")
      .def_ro("bottomless", &Light::bottomless)
      .def_prop_ro(
          "cloud_shadow",
          [](Self self) -> nb::object {
            const CloudShadow* shadow = nb::cast<const Light&>(self).cloud_shadow.get();
            if (shadow == nullptr) return nb::none();
            return nb::make_tuple(
                view(self, shadow->optical_depth.data(),
                     {static_cast<std::size_t>(shadow->rows),
                      static_cast<std::size_t>(shadow->columns)}),
                shadow->spacing_m, shadow->height_m,
                nb::make_tuple(shadow->first_x_m, shadow->first_z_m));
          },
          nb::for_getter(nb::sig(
              "def cloud_shadow(self, /) -> tuple[numpy.typing.NDArray[numpy.float32], float, "
              "float, tuple[float, float]] | None")),
          "As given, its array read-only; or None.")
      .def_prop_ro(
          "ultraviolet",
          [](Self self) -> nb::object {
            const auto& weights = nb::cast<const Light&>(self).ultraviolet;
            if (weights.empty()) return nb::none();
            return view(self, weights[0].data(), {weights.size(), 4});
          },
          nb::for_getter(
              nb::sig("def ultraviolet(self, /) -> numpy.typing.NDArray[numpy.float64] | None")),
          "Read-only, (M, 4); or None.");

  m.def(
      "materials_without_ultraviolet",
      [](const Scene& scene, nb::handle wavelength_nm, nb::handle weight) {
        Bands bands;
        bands.wavelength_nm = vector_of(double_array(wavelength_nm, "wavelength_nm", {-1}));
        bands.weight = vector_of(double_array(
            weight, "weight", {-1, static_cast<std::int64_t>(bands.wavelength_nm.size())}));
        return materials_without_ultraviolet(scene, bands);
      },
      nb::arg("scene"), nb::arg("wavelength_nm"), nb::arg("weight"),
      nb::sig("def materials_without_ultraviolet(scene: Scene, wavelength_nm: "
              "numpy.typing.ArrayLike, weight: numpy.typing.ArrayLike) -> list[int]"),
      "Materials in use of which nothing is known in some of the bands' ultraviolet: indices, -1 "
      "for\nmeshes without a material.");
}

}  // namespace omma::python
