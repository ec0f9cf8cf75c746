"""Measured spectra for the materials of a scene, by their names."""

from __future__ import annotations

from typing import Any

import numpy as np

from omma._core import Error, Material, Scene, Spectrum
from omma.base.arguments import checked, one_of, positive
from omma.scene.facets import mirrored_straight
from omma.scene.spectrum_colours import linear_srgb, luminance

# Without ultraviolet a world asks what there is; beyond the visible end nobody would.
_VISIBLE_NM = (400.0, 700.0)


@checked
def with_reflectance(
    scene: Scene,
    name: str,
    reflectance: Spectrum,
    *,
    transmittance: Spectrum | None = None,
    gloss: bool = False,
    at_luminance: float | None = None,
    plain: bool = False,
) -> Scene:
    """A scene whose material of this name reflects a measured spectrum, in worlds that are lit.

    All materials of the name get it. They are opaque unless a transmittance is given, no metals and
    not unlit; their base colour becomes what people see of the spectrum. Roughness, normals and
    cut-outs stay.

    Args:
        name: a material's.
        reflectance: of all light that is sent back, 0 to 1, at least from 400 to 700 nm, as
            `omma.light.load_spectra` reads it. Where it begins above 300 nm, a world with light
            below that wants to be told what is reflected there (``ultraviolet``).
        transmittance: diffuse, of what goes through a thin sheet.
        gloss: False: the surface becomes matt, so that it sends back what was measured, evenly in
            all directions. True: it keeps its gloss, F of light that falls straight on it, and the
            spectrum is the whole: (reflectance - F)/(1 - F), at least 0, is scattered below.
        at_luminance: of a material with a texture or vertex colours, which then still paint: the
            relative luminance of the base colour where the spectrum was measured, above 0; it is
            proportional to that elsewhere (docs/materials.md).
        plain: texture and vertex colours are left out instead: it is the spectrum all over.

    Example:
        >>> flower = omma.scene.natural_material("white petal").replace(name="petal")
        >>> scene = omma.scene.disc(0.03).replace(materials=[flower])
        >>> spectrum = omma.light.Spectrum([300, 400, 700], [0.05, 0.4, 0.6])
        >>> scene = omma.scene.with_reflectance(scene, "petal", spectrum)
        >>> scene.materials[0].reflectance == spectrum
        True

    Raises:
        omma.Error: no material of that name, which names those that there are; a spectrum that does
            not reach over 400 to 700 nm or is above 1; a texture or vertex colours without a word
            about them, or one that cuts out and would be left out.
    """
    names = [one.name for one in scene.materials]
    if not names:
        raise Error("name: expected the name of a material of the scene, which has none")
    one_of(name, dict.fromkeys(names), "name")
    for what, spectrum in (("reflectance", reflectance), ("transmittance", transmittance)):
        if spectrum is not None:
            check_reach(spectrum, what)
    if at_luminance is not None:
        at_luminance = positive(at_luminance, "at_luminance")
        if plain:
            raise Error("at_luminance: not together with plain, which leaves out what paints")
    chosen = {k for k, one in enumerate(names) if one == name}
    coloured = [mesh.material in chosen and mesh.colors is not None for mesh in scene.meshes]
    materials = list(scene.materials)
    for k in chosen:
        if (
            at_luminance is None
            and not plain
            and (materials[k].base_color_texture or any(coloured))
        ):
            paints = "a texture" if materials[k].base_color_texture else "vertex colours"
            raise Error(
                f"at_luminance: material {name!r} has {paints}; expected the luminance of its base "
                "colour where the spectrum was measured, or plain=True to leave them out"
            )
        materials[k] = _measured(materials[k], reflectance, transmittance, gloss, at_luminance)
    if not (plain and any(coloured)):
        return scene.replace(materials=materials)
    meshes = [
        mesh.replace(colors=None) if drop else mesh
        for mesh, drop in zip(scene.meshes, coloured, strict=True)
    ]
    return scene.replace(materials=materials, meshes=meshes)


def check_reach(spectrum: Spectrum, what: str) -> None:
    first, last = spectrum.wavelength_nm[[0, -1]]
    if first > _VISIBLE_NM[0] or last < _VISIBLE_NM[1]:
        raise Error(
            f"{what}: expected values from {_VISIBLE_NM[0]:g} nm or below to {_VISIBLE_NM[1]:g} "
            f"nm, found {first:g} to {last:g} nm; what lies beyond is not made up"
        )


def _measured(
    material: Material,
    reflectance: Spectrum,
    transmittance: Spectrum | None,
    gloss: bool,
    at_luminance: float | None,
) -> Material:
    changes: dict[str, Any] = {
        "metallic": 0.0, "metallic_roughness_texture": None, "unlit": False,
        "transmission": 0.0, "transmission_texture": None,
        "diffuse_transmission": 0.0, "diffuse_transmission_texture": None,
        "extra_reflectance": None, "boundary": None,
    }  # fmt: skip
    if gloss:
        surface = material.specular * mirrored_straight(material.roughness, material.ior)
        reflectance = _below(reflectance, surface)
    else:
        changes |= {"specular": 0.0, "specular_texture": None, "specular_color_texture": None,
                    "clearcoat": 0.0, "clearcoat_texture": None}  # fmt: skip
    if at_luminance is None:
        if material.base_color_texture is not None and material.alpha_mode != "opaque":
            raise Error(
                f"plain: expected a material whose texture does not cut it out, found "
                f"{material.name!r}, which is {material.alpha_mode}; give at_luminance instead"
            )
        seen = linear_srgb(reflectance.wavelength_nm, reflectance.value)
        # Of black any colour does: the spectrum is what counts.
        seen = seen if luminance(seen) > 0 else np.ones(3)
        changes |= {"base_color": (*seen, material.base_color[3]), "base_color_texture": None}
        at_luminance = luminance(seen)
    return material.replace(
        reflectance=reflectance,
        transmittance=transmittance,
        spectral_luminance=at_luminance,
        **changes,
    )


def _below(whole: Spectrum, surface: float) -> Spectrum:
    """What is scattered below a surface, of the whole that is sent back."""
    inside = np.clip((whole.value - surface) / (1 - surface), 0, 1)
    return whole.replace(value=inside)
