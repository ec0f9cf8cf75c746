// Material for Python: what it looks like, and how it scatters light.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <cmath>

#include "model/scene_light.h"
#include "scene_parts.h"

namespace omma::python {

namespace {

constexpr Words<AlphaMode, 3> alpha_modes = {
    {{"opaque", AlphaMode::opaque}, {"mask", AlphaMode::mask}, {"blend", AlphaMode::blend}}};

// RGBA; RGB is opaque.
Vec4 rgba_argument(nb::handle object, const char* name) {
  const auto values = float_array(object, name, {-1});
  const float* v = values.data();
  if (values.shape(0) != 3 && values.shape(0) != 4)
    throw Error(std::string(name) + ": expected three or four numbers, found " +
                std::to_string(values.shape(0)));
  return {v[0], v[1], v[2], values.shape(0) == 4 ? v[3] : 1.0f};
}

float single(nb::handle object, const char* name) {
  return static_cast<float>(number_argument(object, name));
}

ExtraReflectance extra_argument(nb::handle object, const char* name) {
  if (object.is_none()) return {};
  if (nb::isinstance<ExtraReflectance>(object)) return nb::cast<const ExtraReflectance&>(object);
  throw nb::type_error((std::string(name) +
                        ": expected omma.scene.ExtraReflectance or None, found " +
                        type_name_of(object))
                           .c_str());
}

ExtraReflectance made_extra(nb::handle texture, nb::handle spectra) {
  expect_given(texture, "texture", "the index of a texture or an omma.scene.TextureUse");
  ExtraReflectance made;
  made.texture = texture_use_argument(texture, "texture");
  if (!nb::isinstance<nb::sequence>(spectra) || nb::isinstance<nb::str>(spectra))
    throw nb::type_error(("spectra: expected up to three of omma.light.Spectrum or None, found " +
                          type_name_of(spectra))
                             .c_str());
  const std::size_t count = nb::len(spectra);
  if (count < 1 || count > made.spectrum.size())
    throw Error("spectra: expected one to three, found " + std::to_string(count));
  for (std::size_t c = 0; c < count; ++c)
    made.spectrum[c] = spectrum_argument(spectra[c], "spectra");
  Material alone;
  alone.extra = made;
  check_scattering(alone, "");
  return made;
}

void bind_extra_reflectance(nb::module_& m) {
  nb::class_<ExtraReflectance> extra(
      m, "ExtraReflectance",
      "More reflectance of a surface than red, green and blue say, as a petal's ultraviolet "
      "guide:\n"
      "the channels of an image, linear, are amounts of up to three spectra, which add to what "
      "the\n"
      "base colour gives. A spectrum (`omma.light.Spectrum`, 0 to 1) is 0 beyond its wavelengths;\n"
      "None: the channel says nothing.\n\n"
      "Raises `omma.Error`, which names the argument.");
  extra
      .def(
          "__init__",
          [](ExtraReflectance* self, nb::handle texture, nb::handle spectra) {
            new (self) ExtraReflectance(made_extra(texture, spectra));
          },
          required("texture"), required("spectra"),
          nb::sig("def __init__(self, texture: int | TextureUse, spectra: "
                  "collections.abc.Sequence[Spectrum | None]) -> None"))
      .def_ro("texture", &ExtraReflectance::texture)
      .def_prop_ro(
          "spectra",
          [](const ExtraReflectance& one) {
            return nb::make_tuple(spectrum_or_none(one.spectrum[0]),
                                  spectrum_or_none(one.spectrum[1]),
                                  spectrum_or_none(one.spectrum[2]));
          },
          nb::for_getter(nb::sig("def spectra(self, /) -> tuple[Spectrum | None, Spectrum | None, "
                                 "Spectrum | None]")),
          "Of the channels red, green and blue.")
      .def("__hash__",
           [](const ExtraReflectance& one) {
             return hash_of("", static_cast<std::size_t>(one.texture.texture));
           })
      .def("__repr__", [](const ExtraReflectance& one) {
        return "<omma.scene.ExtraReflectance of texture " + std::to_string(one.texture.texture) +
               ">";
      });
  def_value(extra, {"texture", "spectra"});
}

}  // namespace

void bind_material(nb::module_& m) {
  bind_extra_reflectance(m);
  bind_boundary_table(m);
  nb::class_<Material> material(
      m, "Material",
      "What a surface looks like: base colour × texture × the mesh's vertex colours, and emission\n"
      "× its texture beside that. All factors are linear.\n\n"
      "``alpha_mode`` 'opaque' takes no notice of alpha, 'mask' cuts where it is under\n"
      "``alpha_cutoff``, 'blend' lets light through. Back faces are seen only where\n"
      "``double_sided``. ``unlit`` says that its base colour is its radiance, whatever falls on\n"
      "it; in a world with a light it reflects as matter of that colour.\n\n"
      "The others say how it scatters light, as glTF 2.0 and its extensions do, and count in a\n"
      "world with a light only. By default it is rough matter, not the metal that glTF's own\n"
      "defaults are. ``ior`` is the index of refraction; ``specular`` (and its colour) a factor "
      "of\n"
      "the reflection by it; ``transmission`` what goes straight through, "
      "or bends\n"
      "into a volume where ``thickness_m`` is above 0 (how far above does not count): then meshes\n"
      "bound it, seen from outside by their front, and it absorbs by ``attenuation_color`` and\n"
      "``attenuation_distance_m`` or, in their place, ``absorption_per_m``, a spectrum in m⁻¹;\n"
      "``diffuse_transmission``\n"
      "what leaves a thin sheet scattered on its other side; ``clearcoat`` a second surface on "
      "it.\n"
      "``reflectance`` and ``transmittance`` are spectra (`omma.light.Spectrum`, 0 to 1, together\n"
      "at most 1) in place of what RGB stands for, where the base colour has the relative\n"
      "luminance ``spectral_luminance``, and proportional to it elsewhere. ``extra_reflectance``\n"
      "adds an image of spectra, ``emission`` is the spectrum of what shines. ``boundary`` is how its\n"
      "metal, the part ``metallic`` of it, reflects by wavelength and angle, in place of the base\n"
      "colour (`LayerStack`); that polarises.\n\n"
      "Raises `omma.Error`, which names the argument.");
  material
      .def(
          "__init__",
          [](Material* self, nb::handle name, nb::handle base_color, nb::handle base_color_texture,
             nb::handle emissive, nb::handle emissive_texture, nb::handle alpha_mode,
             nb::handle alpha_cutoff, nb::handle double_sided, nb::handle unlit,
             nb::handle metallic, nb::handle roughness, nb::handle metallic_roughness_texture,
             nb::handle normal_texture, nb::handle normal_scale, nb::handle ior,
             nb::handle specular, nb::handle specular_texture, nb::handle specular_color,
             nb::handle specular_color_texture, nb::handle transmission,
             nb::handle transmission_texture, nb::handle thickness_m, nb::handle attenuation_color,
             nb::handle attenuation_distance_m, nb::handle absorption_per_m,
             nb::handle diffuse_transmission, nb::handle diffuse_transmission_factor_texture,
             nb::handle diffuse_transmission_color, nb::handle diffuse_transmission_texture,
             nb::handle clearcoat, nb::handle clearcoat_texture, nb::handle clearcoat_roughness,
             nb::handle clearcoat_roughness_texture, nb::handle clearcoat_normal_texture,
             nb::handle clearcoat_normal_scale, nb::handle reflectance, nb::handle transmittance,
             nb::handle spectral_luminance, nb::handle extra_reflectance, nb::handle emission,
             nb::handle boundary) {
            Material made;
            made.name = text_argument(name, "name");
            made.base_color = rgba_argument(base_color, "base_color");
            made.base_color_texture =
                texture_use_argument(base_color_texture, "base_color_texture");
            made.emissive = to_float(vec3d(emissive, "emissive"));
            made.emissive_texture = texture_use_argument(emissive_texture, "emissive_texture");
            made.alpha_mode = word_argument(alpha_modes, alpha_mode, "alpha_mode");
            made.alpha_cutoff = single(alpha_cutoff, "alpha_cutoff");
            made.double_sided = flag_argument(double_sided, "double_sided");
            made.unlit = flag_argument(unlit, "unlit");
            if (made.unlit &&
                (made.emissive != Vec3{0, 0, 0} || made.emissive_texture.texture >= 0))
              throw Error("unlit: is unlit and has an emission, which unlit materials do not have");
            made.metallic = single(metallic, "metallic");
            made.roughness = single(roughness, "roughness");
            made.metallic_roughness_texture =
                texture_use_argument(metallic_roughness_texture, "metallic_roughness_texture");
            made.normal_texture = texture_use_argument(normal_texture, "normal_texture");
            made.normal_scale = single(normal_scale, "normal_scale");
            made.ior = single(ior, "ior");
            made.specular = single(specular, "specular");
            made.specular_texture = texture_use_argument(specular_texture, "specular_texture");
            made.specular_color = to_float(vec3d(specular_color, "specular_color"));
            made.specular_color_texture =
                texture_use_argument(specular_color_texture, "specular_color_texture");
            made.transmission = single(transmission, "transmission");
            made.transmission_texture =
                texture_use_argument(transmission_texture, "transmission_texture");
            made.thickness_m = single(thickness_m, "thickness_m");
            made.attenuation_color = to_float(vec3d(attenuation_color, "attenuation_color"));
            if (!attenuation_distance_m.is_none())
              made.attenuation_distance_m =
                  single(attenuation_distance_m, "attenuation_distance_m");
            made.absorption_per_m = spectrum_argument(absorption_per_m, "absorption_per_m");
            made.diffuse_transmission = single(diffuse_transmission, "diffuse_transmission");
            made.diffuse_transmission_factor_texture = texture_use_argument(
                diffuse_transmission_factor_texture, "diffuse_transmission_factor_texture");
            made.diffuse_transmission_color =
                to_float(vec3d(diffuse_transmission_color, "diffuse_transmission_color"));
            made.diffuse_transmission_texture =
                texture_use_argument(diffuse_transmission_texture, "diffuse_transmission_texture");
            made.clearcoat = single(clearcoat, "clearcoat");
            made.clearcoat_texture = texture_use_argument(clearcoat_texture, "clearcoat_texture");
            made.clearcoat_roughness = single(clearcoat_roughness, "clearcoat_roughness");
            made.clearcoat_roughness_texture =
                texture_use_argument(clearcoat_roughness_texture, "clearcoat_roughness_texture");
            made.clearcoat_normal_texture =
                texture_use_argument(clearcoat_normal_texture, "clearcoat_normal_texture");
            made.clearcoat_normal_scale = single(clearcoat_normal_scale, "clearcoat_normal_scale");
            made.reflectance = spectrum_argument(reflectance, "reflectance");
            made.transmittance = spectrum_argument(transmittance, "transmittance");
            made.spectral_luminance = single(spectral_luminance, "spectral_luminance");
            made.extra = extra_argument(extra_reflectance, "extra_reflectance");
            made.emission = spectrum_argument(emission, "emission");
            made.boundary = boundary_argument(boundary, "boundary");
            check_scattering(made, "");
            new (self) Material(std::move(made));
          },
          nb::arg("name") = "", nb::kw_only(),
          nb::arg("base_color") = nb::make_tuple(1.0, 1.0, 1.0, 1.0),
          nb::arg("base_color_texture") = nb::none(),
          nb::arg("emissive") = nb::make_tuple(0.0, 0.0, 0.0),
          nb::arg("emissive_texture") = nb::none(), nb::arg("alpha_mode") = "opaque",
          nb::arg("alpha_cutoff") = 0.5, nb::arg("double_sided") = false, nb::arg("unlit") = false,
          nb::arg("metallic") = 0.0, nb::arg("roughness") = 1.0,
          nb::arg("metallic_roughness_texture") = nb::none(),
          nb::arg("normal_texture") = nb::none(), nb::arg("normal_scale") = 1.0,
          nb::arg("ior") = 1.5, nb::arg("specular") = 1.0, nb::arg("specular_texture") = nb::none(),
          nb::arg("specular_color") = nb::make_tuple(1.0, 1.0, 1.0),
          nb::arg("specular_color_texture") = nb::none(), nb::arg("transmission") = 0.0,
          nb::arg("transmission_texture") = nb::none(), nb::arg("thickness_m") = 0.0,
          nb::arg("attenuation_color") = nb::make_tuple(1.0, 1.0, 1.0),
          nb::arg("attenuation_distance_m") = nb::none(), nb::arg("absorption_per_m") = nb::none(),
          nb::arg("diffuse_transmission") = 0.0,
          nb::arg("diffuse_transmission_factor_texture") = nb::none(),
          nb::arg("diffuse_transmission_color") = nb::make_tuple(1.0, 1.0, 1.0),
          nb::arg("diffuse_transmission_texture") = nb::none(), nb::arg("clearcoat") = 0.0,
          nb::arg("clearcoat_texture") = nb::none(), nb::arg("clearcoat_roughness") = 0.0,
          nb::arg("clearcoat_roughness_texture") = nb::none(),
          nb::arg("clearcoat_normal_texture") = nb::none(), nb::arg("clearcoat_normal_scale") = 1.0,
          nb::arg("reflectance") = nb::none(), nb::arg("transmittance") = nb::none(),
          nb::arg("spectral_luminance") = 1.0, nb::arg("extra_reflectance") = nb::none(),
          nb::arg("emission") = nb::none(), nb::arg("boundary") = nb::none(),
          nb::sig(
              "def __init__(self, name: str = '', *, base_color: numpy.typing.ArrayLike = "
              "(1.0, 1.0, 1.0, 1.0), base_color_texture: int | TextureUse | None = None, "
              "emissive: numpy.typing.ArrayLike = (0.0, 0.0, 0.0), emissive_texture: int | "
              "TextureUse | None = None, alpha_mode: str = 'opaque', alpha_cutoff: float = 0.5, "
              "double_sided: bool = False, unlit: bool = False, metallic: float = 0.0, roughness: "
              "float = 1.0, metallic_roughness_texture: int | TextureUse | None = None, "
              "normal_texture: int | TextureUse | None = None, normal_scale: float = 1.0, ior: "
              "float = 1.5, specular: float = 1.0, specular_texture: int | TextureUse | None = "
              "None, specular_color: numpy.typing.ArrayLike = (1.0, 1.0, 1.0), "
              "specular_color_texture: int | TextureUse | None = None, transmission: float = 0.0, "
              "transmission_texture: int | TextureUse | None = None, thickness_m: float = 0.0, "
              "attenuation_color: numpy.typing.ArrayLike = (1.0, 1.0, 1.0), "
              "attenuation_distance_m: float | None = None, absorption_per_m: Spectrum | None = "
              "None, diffuse_transmission: float = 0.0, diffuse_transmission_factor_texture: int | "
              "TextureUse | None = None, "
              "diffuse_transmission_color: numpy.typing.ArrayLike = (1.0, 1.0, 1.0), "
              "diffuse_transmission_texture: int | TextureUse | None = None, clearcoat: float = "
              "0.0, clearcoat_texture: int | TextureUse | None = None, clearcoat_roughness: float "
              "= 0.0, clearcoat_roughness_texture: int | TextureUse | None = None, "
              "clearcoat_normal_texture: int | TextureUse | None = None, clearcoat_normal_scale: "
              "float = 1.0, reflectance: Spectrum | None = None, "
              "transmittance: Spectrum | None = None, spectral_luminance: float = 1.0, "
              "extra_reflectance: ExtraReflectance | None = None, emission: Spectrum | None = "
              "None, boundary: BoundaryTable | None = None) -> None"))
      .def_ro("name", &Material::name)
      .def_prop_ro(
          "base_color", [](const Material& one) { return numbers(one.base_color); },
          nb::for_getter(nb::sig("def base_color(self, /) -> tuple[float, float, float, float]")),
          "Linear factor, RGBA.")
      .def_prop_ro(
          "base_color_texture",
          [](const Material& one) { return texture_use_or_none(one.base_color_texture); },
          nb::for_getter(nb::sig("def base_color_texture(self, /) -> TextureUse | None")))
      .def_prop_ro(
          "emissive", [](const Material& one) { return numbers(one.emissive); },
          nb::for_getter(nb::sig("def emissive(self, /) -> tuple[float, float, float]")),
          "Linear radiance, RGB.")
      .def_prop_ro(
          "emissive_texture",
          [](const Material& one) { return texture_use_or_none(one.emissive_texture); },
          nb::for_getter(nb::sig("def emissive_texture(self, /) -> TextureUse | None")))
      .def_prop_ro("alpha_mode",
                   [](const Material& one) { return word_of(alpha_modes, one.alpha_mode); })
      .def_ro("alpha_cutoff", &Material::alpha_cutoff)
      .def_ro("double_sided", &Material::double_sided)
      .def_ro("unlit", &Material::unlit)
      .def_ro("metallic", &Material::metallic)
      .def_ro("roughness", &Material::roughness)
      .def_prop_ro(
          "metallic_roughness_texture",
          [](const Material& one) { return texture_use_or_none(one.metallic_roughness_texture); },
          nb::for_getter(nb::sig("def metallic_roughness_texture(self, /) -> TextureUse | None")),
          "Metallic in blue, roughness in green; linear.")
      .def_prop_ro(
          "normal_texture",
          [](const Material& one) { return texture_use_or_none(one.normal_texture); },
          nb::for_getter(nb::sig("def normal_texture(self, /) -> TextureUse | None")), "Linear.")
      .def_ro("normal_scale", &Material::normal_scale)
      .def_ro("ior", &Material::ior)
      .def_ro("specular", &Material::specular)
      .def_prop_ro(
          "specular_texture",
          [](const Material& one) { return texture_use_or_none(one.specular_texture); },
          nb::for_getter(nb::sig("def specular_texture(self, /) -> TextureUse | None")),
          "A factor of ``specular``: its alpha.")
      .def_prop_ro(
          "specular_color", [](const Material& one) { return numbers(one.specular_color); },
          nb::for_getter(nb::sig("def specular_color(self, /) -> tuple[float, float, float]")))
      .def_prop_ro(
          "specular_color_texture",
          [](const Material& one) { return texture_use_or_none(one.specular_color_texture); },
          nb::for_getter(nb::sig("def specular_color_texture(self, /) -> TextureUse | None")),
          "sRGB.")
      .def_ro("transmission", &Material::transmission)
      .def_prop_ro(
          "transmission_texture",
          [](const Material& one) { return texture_use_or_none(one.transmission_texture); },
          nb::for_getter(nb::sig("def transmission_texture(self, /) -> TextureUse | None")),
          "A factor of ``transmission``: its red; linear.")
      .def_ro("thickness_m", &Material::thickness_m)
      .def_prop_ro(
          "attenuation_color", [](const Material& one) { return numbers(one.attenuation_color); },
          nb::for_getter(nb::sig("def attenuation_color(self, /) -> tuple[float, float, float]")),
          "Linear, what is left of white after ``attenuation_distance_m``.")
      .def_prop_ro(
          "attenuation_distance_m",
          [](const Material& one) -> nb::object {
            if (std::isinf(one.attenuation_distance_m)) return nb::none();
            return nb::float_(static_cast<double>(one.attenuation_distance_m));
          },
          nb::for_getter(nb::sig("def attenuation_distance_m(self, /) -> float | None")),
          "None: nothing is absorbed.")
      .def_prop_ro(
          "absorption_per_m",
          [](const Material& one) { return spectrum_or_none(one.absorption_per_m); },
          nb::for_getter(nb::sig("def absorption_per_m(self, /) -> Spectrum | None")),
          "Of the volume, m⁻¹.")
      .def_ro("diffuse_transmission", &Material::diffuse_transmission)
      .def_prop_ro(
          "diffuse_transmission_factor_texture",
          [](const Material& one) {
            return texture_use_or_none(one.diffuse_transmission_factor_texture);
          },
          nb::for_getter(
              nb::sig("def diffuse_transmission_factor_texture(self, /) -> TextureUse | None")),
          "A factor of ``diffuse_transmission``: its alpha.")
      .def_prop_ro(
          "diffuse_transmission_color",
          [](const Material& one) { return numbers(one.diffuse_transmission_color); },
          nb::for_getter(
              nb::sig("def diffuse_transmission_color(self, /) -> tuple[float, float, float]")))
      .def_prop_ro(
          "diffuse_transmission_texture",
          [](const Material& one) { return texture_use_or_none(one.diffuse_transmission_texture); },
          nb::for_getter(nb::sig("def diffuse_transmission_texture(self, /) -> TextureUse | None")),
          "Of the colour, sRGB.")
      .def_ro("clearcoat", &Material::clearcoat)
      .def_prop_ro(
          "clearcoat_texture",
          [](const Material& one) { return texture_use_or_none(one.clearcoat_texture); },
          nb::for_getter(nb::sig("def clearcoat_texture(self, /) -> TextureUse | None")),
          "A factor of ``clearcoat``: its red; linear.")
      .def_ro("clearcoat_roughness", &Material::clearcoat_roughness)
      .def_prop_ro(
          "clearcoat_roughness_texture",
          [](const Material& one) { return texture_use_or_none(one.clearcoat_roughness_texture); },
          nb::for_getter(nb::sig("def clearcoat_roughness_texture(self, /) -> TextureUse | None")),
          "A factor of ``clearcoat_roughness``: its green; linear.")
      .def_prop_ro(
          "clearcoat_normal_texture",
          [](const Material& one) { return texture_use_or_none(one.clearcoat_normal_texture); },
          nb::for_getter(nb::sig("def clearcoat_normal_texture(self, /) -> TextureUse | None")),
          "Linear. Without it a coat has the mesh's normals, whatever ``normal_texture``.")
      .def_ro("clearcoat_normal_scale", &Material::clearcoat_normal_scale)
      .def_prop_ro(
          "reflectance", [](const Material& one) { return spectrum_or_none(one.reflectance); },
          nb::for_getter(nb::sig("def reflectance(self, /) -> Spectrum | None")))
      .def_prop_ro(
          "transmittance", [](const Material& one) { return spectrum_or_none(one.transmittance); },
          nb::for_getter(nb::sig("def transmittance(self, /) -> Spectrum | None")))
      .def_ro("spectral_luminance", &Material::spectral_luminance)
      .def_prop_ro(
          "extra_reflectance",
          [](const Material& one) {
            return one.extra.texture.texture < 0 ? nb::none() : nb::cast(one.extra);
          },
          nb::for_getter(nb::sig("def extra_reflectance(self, /) -> ExtraReflectance | None")))
      .def_prop_ro(
          "emission", [](const Material& one) { return spectrum_or_none(one.emission); },
          nb::for_getter(nb::sig("def emission(self, /) -> Spectrum | None")),
          "W m⁻² sr⁻¹ nm⁻¹ where the emissive factor times texture has luminance 1.")
      .def_prop_ro(
          "boundary",
          [](const Material& one) {
            return one.boundary.empty() ? nb::none() : nb::cast(one.boundary);
          },
          nb::for_getter(nb::sig("def boundary(self, /) -> BoundaryTable | None")))
      .def("__hash__",
           [](const Material& one) {
             return hash_of(one.name, std::size_t(one.base_color_texture.texture + 1));
           })
      .def("__repr__", [](const Material& one) {
        std::string text = named("Material", one.name);
        if (one.base_color_texture.texture >= 0)
          text += ", texture " + std::to_string(one.base_color_texture.texture);
        if (one.alpha_mode != AlphaMode::opaque)
          text += std::string(", ") + word_of(alpha_modes, one.alpha_mode);
        return text + (one.double_sided ? ", double sided>" : ">");
      });
  def_value(material, {"name",
                       "base_color",
                       "base_color_texture",
                       "emissive",
                       "emissive_texture",
                       "alpha_mode",
                       "alpha_cutoff",
                       "double_sided",
                       "unlit",
                       "metallic",
                       "roughness",
                       "metallic_roughness_texture",
                       "normal_texture",
                       "normal_scale",
                       "ior",
                       "specular",
                       "specular_texture",
                       "specular_color",
                       "specular_color_texture",
                       "transmission",
                       "transmission_texture",
                       "thickness_m",
                       "attenuation_color",
                       "attenuation_distance_m",
                       "absorption_per_m",
                       "diffuse_transmission",
                       "diffuse_transmission_factor_texture",
                       "diffuse_transmission_color",
                       "diffuse_transmission_texture",
                       "clearcoat",
                       "clearcoat_texture",
                       "clearcoat_roughness",
                       "clearcoat_roughness_texture",
                       "clearcoat_normal_texture",
                       "clearcoat_normal_scale",
                       "reflectance",
                       "transmittance",
                       "spectral_luminance",
                       "extra_reflectance",
                       "emission",
                       "boundary"});
}

}  // namespace omma::python
