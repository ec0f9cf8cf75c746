"""What is white in a light: how bright a white sheet is in it. Pictures are exposed by it, and what
shines is told where it vanishes beside it."""

from __future__ import annotations

import numpy as np

from omma._core import PunctualLight, Scene
from omma.base.arrays import Floats
from omma.light import Light, watts_from_photons
from omma.scene.spectrum_colours import colour_matching, luminance

_LUMENS_PER_WATT = 683.0  # at 555 nm: the SI's definition of the candela
# Of a white sheet: what emits less is black beside it, on any screen.
_LEAST_SEEN = 1e-3


def xyz_from_bands(light: Light) -> Floats:
    """What the CIE's observer of 1931 sees of a radiance of 1 in each band, (3, B): X, Y and Z by
    lumens, so that Y is in cd m⁻²."""

    def seen_of_one(nm: Floats) -> Floats:
        power = watts_from_photons(1.0, nm) if light.unit == "photons" else np.ones_like(nm)
        return np.asarray((_LUMENS_PER_WATT * colour_matching(nm) * power).T)

    bands = light.bands
    return np.asarray(bands.mean(seen_of_one).T * bands.widths_nm)


def white_luminance(light: Light, scene: Scene | None = None) -> float:
    """Of a white matt sheet, cd m⁻²: what sky, sun and moon give to level ground; and of a scene
    what its lamps give to a sheet that faces each of them, half the scene's size away."""
    level = xyz_from_bands(light)[1] @ sum(light.irradiance())
    return float(level + (0.0 if scene is None else _lamp_illuminance(scene))) / np.pi


def emitted_luminance(scene: Scene, emission_cd_m2: float) -> tuple[float, str]:
    """Of the brightest surface that is told to emit in RGB, cd m⁻², and its material's name; 0
    where none does."""
    brightest, name = 0.0, ""
    for material in scene.materials:
        if material.unlit or material.emission is not None or not any(material.emissive):
            continue
        given = emission_cd_m2 * luminance(np.array(material.emissive))
        if given > brightest:
            brightest, name = given, material.name
    return brightest, name


def vanishing_emission(scene: Scene, light: Light, emission_cd_m2: float) -> str:
    """A sentence where surfaces emit so little that it is black beside the rest of the light."""
    brightest, name = emitted_luminance(scene, emission_cd_m2)
    if brightest == 0:
        return ""
    white = white_luminance(light, scene)
    if brightest >= _LEAST_SEEN * white:
        return ""
    return (
        f'emission: the brightest surface that emits, "{name}", gives {brightest:.3g} cd/m² where '
        f"a white sheet in this light has {white:.3g}: it looks black. emission_cd_m2 of "
        f"omma.World says what emission 1 is, now {emission_cd_m2:g} cd/m² (docs/light.md)"
    )


def without_light(scene: Scene, light: Light) -> str:
    """A sentence where nothing gives light: no sky, no disc, no lamp, no surface that shines."""
    shows = scene.splats or any(one.unlit or any(one.emissive) for one in scene.materials)
    if light.sky is not None or light.discs or scene.lights or shows or not scene.triangle_count:
        return ""
    return (
        "light: no sky, and the scene has no lamps (KHR_lights_punctual) and no surface that "
        "shines: all is black. omma.light.clear_sky(30) is a light, and a scene takes lamps by "
        "scene.replace(lights=[omma.scene.PunctualLight(...)])"
    )


def _lamp_illuminance(scene: Scene) -> float:
    """Lux, half the scene's size away from each lamp."""
    lamps = scene.lights
    if not lamps:
        return 0.0
    away = max(_half_size_m(scene), 1e-6)
    return sum(_strength(one) / (1.0 if one.type == "directional" else away**2) for one in lamps)


def _strength(lamp: PunctualLight) -> float:
    """Candelas, or lux where it is directional."""
    if lamp.spectrum is None:
        return float(lamp.intensity * luminance(np.array(lamp.color)))
    nm = np.arange(380.0, 781.0)
    watts = np.interp(nm, lamp.spectrum.wavelength_nm, lamp.spectrum.value, left=0, right=0)
    return float(_LUMENS_PER_WATT * colour_matching(nm)[1] @ watts)


def _half_size_m(scene: Scene) -> float:
    """Half of the longest side of the box around all."""
    boxes = [
        (each.min(axis=0), each.max(axis=0)) if len(each) else None
        for each in (mesh.positions_m for mesh in scene.meshes)
    ]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for one in scene.instances:
        box = boxes[one.mesh]
        if box is None:
            continue
        middle, half = (box[0] + box[1]) / 2, (box[1] - box[0]) / 2
        placed = one.world_from_mesh[:3, :3] @ middle + one.world_from_mesh[:3, 3]
        reach = np.abs(one.world_from_mesh[:3, :3]) @ half
        low, high = np.minimum(low, placed - reach), np.maximum(high, placed + reach)
    return float(max((high - low).max() / 2, 0.0))
