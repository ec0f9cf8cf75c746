"""How a world is lit: by which light, how far it is followed, and what RGB says of ultraviolet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error, Scene
from omma.base.arguments import expect, one_of, whole, within
from omma.base.values import value_class
from omma.base.warn import warn_caller
from omma.light import Light
from omma.scene.baking import Bake
from omma.scene.white import vanishing_emission, without_light

LightingName = Literal["baked", "path", "unlit"]
# How the sun is asked for where the rest of the light was baked.
Sun = Literal["exact", "map"]
# What is reflected below 400 nm where only RGB is known.
Rule = Literal["dark", "as_blue"] | float
Ultraviolet = Rule | Mapping[str, Rule] | None

_MOST_DEPTH = 1000
_MOST_EMISSION = 1e15  # as of colours
_NAMES_TOLD = 8
_OF_ROUNDING = "from the origin of their own coordinates"
# What a colour of 1 is, cd/m², in worlds whose splats were told of.
_told_of_splats: set[float] = set()
_BAKED_ONLY = 'goes with lighting="baked"'


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Lighting:
    """What `omma.World` is given of light, checked; its docstring says what each is."""

    light: Light
    lighting: LightingName
    depth: int | None
    polarized: bool
    ultraviolet: Ultraviolet
    sun: Sun
    bake: Bake | None  # where light is baked
    emission_cd_m2: float

    def light_arguments(self, scene: Scene) -> dict[str, Any]:
        """The arguments of the engine's light for a scene.

        Raises:
            omma.Error: a material of which nobody says what it reflects in the ultraviolet.
        """
        arguments = self.light._for_engine()
        arguments["ultraviolet"] = self._weights(scene)
        arguments["emission_cd_m2"] = self.emission_cd_m2
        return arguments

    def for_engine(
        self, arguments: dict[str, Any], baked: _core.BakedLight | None = None
    ) -> tuple[Any, int, bool, _core.BakedLight | None, bool]:
        """The engine's lighting, of the arguments of its light."""
        has_map = baked is not None and self.sun == "map"
        return _core.Light(**arguments), self.depth or 0, self.polarized, baked, has_map

    def _weights(self, scene: Scene) -> NDArray[np.float64] | None:
        """Reflectance below 400 nm as weights of red, green, blue and of 1: (M + 1, 4); the last is
        for surfaces without a material."""
        names = _names_of_materials(scene)
        weights = np.zeros((len(names), 4))
        left = []
        for material in self._unknown(scene):
            rule = self._rule(names[material])
            if rule is None:
                left.append(material)
            else:
                weights[material] = _weights_of(rule)
        if left:
            raise Error(_asking(scene, left, self.light))
        return weights

    def names_without_ultraviolet(self, scene: Scene) -> tuple[str, ...]:
        """Of materials of which only RGB is known, where the light reaches below 400 nm."""
        names = _names_of_materials(scene)
        return tuple(names[material] for material in self._unknown(scene))

    def _unknown(self, scene: Scene) -> list[int]:
        bands = self.light.bands
        return _core.materials_without_ultraviolet(scene, bands.wavelength_nm, bands.weight)

    def _rule(self, name: str) -> Rule | None:
        if isinstance(self.ultraviolet, Mapping):
            return self.ultraviolet.get(name, self.ultraviolet.get(""))
        return self.ultraviolet


def checked_lighting(
    light: Light | None,
    lighting: str | None,
    depth: int | None,
    polarized: bool,
    ultraviolet: Ultraviolet,
    sun: str,
    bake: Bake | None,
    emission_cd_m2: float = 1.0,
) -> Lighting | None:
    """The arguments of a world as a value; None where it is not lit.

    Raises:
        omma.Error: an argument is out of its range, or needs a light.
        TypeError: an argument is of another type.
    """
    if lighting is not None:
        one_of(lighting, ("baked", "path", "unlit"), "lighting")
    one_of(sun, ("exact", "map"), "sun")
    if light is None or lighting == "unlit":
        if lighting in ("baked", "path"):
            raise Error(f'lighting: "{lighting}" needs a light (omma.light.clear_sky makes one)')
        if light is not None:
            raise Error('lighting: "unlit" is what it is without a light; expected light=None')
        for name, given in (
            ("depth", depth),
            ("polarized", polarized or None),
            ("ultraviolet", ultraviolet),
            ("bake", bake),
        ):
            if given is not None:
                raise Error(f"{name}: is for worlds with a light, found none")
        return None
    expect(light, Light, "light", "omma.light.clear_sky makes one")
    number = None if depth is None else whole(depth, "depth", 1, _MOST_DEPTH)
    how: LightingName = "baked" if lighting == "baked" else "path"
    if how == "baked" and depth is not None:
        raise Error(
            f"depth: expected None, as baked light is that of all scatterings, found {depth}; "
            'lighting="path" follows light so far'
        )
    if how == "path" and bake is not None:
        raise Error(f"bake: {_BAKED_ONLY}, found lighting={lighting!r}")
    if how == "path" and sun != "exact":
        raise Error(f'sun: "map" {_BAKED_ONLY}, found lighting={lighting!r}')
    if how == "baked" and bake is None:
        bake = Bake()
    kind: Sun = "map" if sun == "map" else "exact"
    if not isinstance(polarized, (bool, np.bool_)):
        raise TypeError(f"polarized: expected True or False, found {polarized!r:.40}")
    if isinstance(ultraviolet, Mapping):
        ultraviolet = {of: checked_rule(rule) for of, rule in ultraviolet.items()}
    elif ultraviolet is not None:
        ultraviolet = checked_rule(ultraviolet)
    emission = within(emission_cd_m2, "emission_cd_m2", 0, _MOST_EMISSION)
    return Lighting(light, how, number, bool(polarized), ultraviolet, kind, bake, emission)


def options_after(before: Lighting | None, **options: Any) -> dict[str, Any]:
    """Options for `checked_lighting`: those that are not None, else those that a world was lit by
    before, where they go together."""
    found = {"polarized": False, "sun": "exact", "emission_cd_m2": 1.0}
    if before is not None:
        if options["lighting"] is None:
            options["lighting"] = before.lighting if options["depth"] is None else "path"
        kept = ["polarized", "ultraviolet", "emission_cd_m2"]
        kept += {"path": ["depth"], "baked": ["bake", "sun"]}.get(options["lighting"], [])
        found |= {name: getattr(before, name) for name in kept}
    return options | found | {name: one for name, one in options.items() if one is not None}


def tell_of_making(scene: Scene) -> None:
    """Warns of a scene that was made in memory, of which no loader has told; not of what rounding
    does, which its warnings and `omma info` say."""
    for sentence in () if scene.path else scene.warnings:
        if _OF_ROUNDING not in sentence:
            warn_caller(sentence, UserWarning)


def tell_of_splats(scene: Scene, lighting: Lighting | None) -> None:
    """Warns that a light does not shine on Gaussian splats: once a session, and once more where a
    colour of 1 is another light."""
    if lighting is None or not scene.splats or lighting.emission_cd_m2 in _told_of_splats:
        return
    warn_caller(
        "sun, sky and lamps do not light Gaussian splats, which keep the light of their capture: a "
        f"colour of 1 is {lighting.emission_cd_m2:g} cd/m² (emission_cd_m2, "
        "omma.scene.calibrate), and nothing below 400 nm. They do dim what is behind them",
        UserWarning,
    )
    # Where warnings are errors it is not told before somebody lets it pass.
    _told_of_splats.add(lighting.emission_cd_m2)


def tell_of_emission(scene: Scene, lighting: Lighting | None) -> None:
    """A warning where what shines vanishes beside the rest of the light, or nothing does."""
    if lighting is None:
        return
    told = vanishing_emission(scene, lighting.light, lighting.emission_cd_m2)
    for sentence in (told, without_light(scene, lighting.light)):
        if sentence:
            warn_caller(sentence, UserWarning)


def checked_rule(rule: Any) -> Rule:
    """What a material reflects in the ultraviolet, checked."""
    if isinstance(rule, str) and rule in ("dark", "as_blue"):
        return rule  # type: ignore[return-value]
    if isinstance(rule, (int, float, np.number)) and not isinstance(rule, bool) and 0 <= rule <= 1:
        return float(rule)
    raise Error(
        f'ultraviolet: expected "dark", "as_blue" or a reflectance from 0 to 1, found {rule!r:.40}'
    )


def _names_of_materials(scene: Scene) -> list[str]:
    """The last, "", is of surfaces without a material."""
    return [one.name for one in scene.materials] + [""]


def _weights_of(rule: Rule) -> tuple[float, float, float, float]:
    if rule == "as_blue":
        return 0.0, 0.0, 1.0, 0.0
    return 0.0, 0.0, 0.0, 0.0 if rule == "dark" else float(rule)


def _asking(scene: Scene, left: list[int], light: Light) -> str:
    """The message that ultraviolet reflectances are missing: of which materials, how much of the
    light is concerned, and what can be said."""
    named = [f'"{one.name}"' if one.name else "one without a name" for one in scene.materials]
    names = [[*named, "those without a material"][material] for material in left]
    bands = light.bands
    below = (bands.weight * (bands.wavelength_nm < 400)).sum(axis=1)
    fallen = sum(light.irradiance()) * bands.widths_nm
    if fallen.sum() > 0:
        reach = f"{float((fallen * below).sum() / fallen.sum()):.1%} of this light is below 400 nm"
    else:
        reach = (
            "This light sends down nothing itself, but has bands below 400 nm: lamps and surfaces "
            "shine there by spectra of their own"
        )
    told = ", ".join(names[:_NAMES_TOLD])
    more = f" and {len(names) - _NAMES_TOLD} more" if len(names) > _NAMES_TOLD else ""
    return (
        "ultraviolet: expected what surfaces reflect below 400 nm, such as "
        'ultraviolet="dark" (nothing), or a light of visible bands alone '
        "(bands=omma.light.Bands.equal(12, 400, 700), among the words of a light bands=visible). "
        f"{reach}, of which RGB says nothing, and of {len(names)} materials only RGB is known, or "
        f"a spectrum that does not reach as far down as the light: {told}{more}. Or say "
        'ultraviolet="as_blue", a reflectance such as ultraviolet=0.02 (leaves) or, in Python, a '
        "mapping by name; or give materials spectra (docs/materials.md). "
        "omma.rendering.ultraviolet_dependence tells by how much responses depend on it"
    )
