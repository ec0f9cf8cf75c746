"""Natural materials: what leaves, soils, petals and water reflect and transmit from 300 to 700 nm.

The numbers are in materials.csv and, of leaves and swards, in leaf_spectra.csv, which
scripts/make_leaf_spectra.py computes. A row is `read` (from the source it names), `computed` (by
the model it names) or `assumed` (nobody's measurement). A curve passes smoothly through its rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from omma._core import Material, Spectrum
from omma.base.arguments import checked, one_of
from omma.base.arrays import Floats
from omma.base.tables import packaged_rows
from omma.base.values import value_class
from omma.scene.facets import mirrored_straight
from omma.scene.spectrum_colours import linear_srgb, luminance

STANDINGS = ("read", "computed", "assumed")
_NM = np.arange(300.0, 701.0, 5.0)
_NM.flags.writeable = False


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class MaterialFact:
    """One number of a natural material.

    ``quantity`` is "reflectance" or "transmittance" of light that falls straight on the surface,
    its gloss included; or "ior", "specular" or "roughness", as in glTF. ``wavelength_nm`` is None
    where the number holds at all. ``standing`` is "read", "computed" or "assumed"; ``source`` is a
    citation, ``source_read`` what of it was read.
    """

    material: str
    quantity: str
    wavelength_nm: float | None
    value: float
    standing: str
    source: str
    source_read: str
    note: str


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class NaturalMaterial:
    """Spectra and surface of a natural material, and the numbers they are made of.

    ``wavelength_nm`` (W,) is from 300 to 700 nm. ``total_reflectance`` (W,) and
    ``total_transmittance`` (W,), None where it is opaque, are shares of the light that falls
    straight on it. ``ior``, ``specular`` and ``roughness`` are those of its surface, as in glTF.
    ``facts`` are the numbers of the tables.
    """

    name: str
    wavelength_nm: Floats
    total_reflectance: Floats
    total_transmittance: Floats | None
    ior: float
    specular: float
    roughness: float
    facts: tuple[MaterialFact, ...]

    @property
    def surface_reflectance(self) -> float:
        """What the surface reflects of light that falls straight on it: none of it gets in. Of
        what rough facets mirror, some meets others and is lost."""
        return self.specular * mirrored_straight(self.roughness, self.ior)

    @property
    def reflectance(self) -> Floats:
        """Diffuse reflectance (W,): of the light that gets in, the share that comes out again."""
        surface = self.surface_reflectance
        return np.clip((self.total_reflectance - surface) / (1 - surface), 0, 1)

    @property
    def transmittance(self) -> Floats | None:
        """Diffuse transmittance (W,): of the light that gets in, the share that passes; or None."""
        if self.total_transmittance is None:
            return None
        return np.clip(self.total_transmittance / (1 - self.surface_reflectance), 0, 1)

    @property
    def diffuse_transmission(self) -> float:
        """Of the light that comes out again, the share that has passed, by luminance."""
        if self.transmittance is None:
            return 0.0
        passed = luminance(linear_srgb(self.wavelength_nm, self.transmittance))
        return passed / (passed + luminance(linear_srgb(self.wavelength_nm, self.reflectance)))

    @property
    def base_color(self) -> Floats:
        """Linear sRGB (3,) of the reflectance, as glTF wants it: over 1 - diffuse_transmission."""
        color = linear_srgb(self.wavelength_nm, self.reflectance)
        return np.clip(color / (1 - self.diffuse_transmission), 0, 1)

    @property
    def diffuse_transmission_color(self) -> Floats:
        """Linear sRGB (3,) of the transmittance, over diffuse_transmission."""
        if self.transmittance is None:
            return np.ones(3)
        color = linear_srgb(self.wavelength_nm, self.transmittance)
        return np.clip(color / self.diffuse_transmission, 0, 1)

    def __repr__(self) -> str:
        kinds = [kind for kind in STANDINGS if any(fact.standing == kind for fact in self.facts)]
        return f"NaturalMaterial({self.name}, {', '.join(kinds)})"


@checked
def natural_materials() -> dict[str, NaturalMaterial]:
    """All natural materials by their names, with spectra and the source of every number.

    Example:
        >>> leaf = omma.scene.natural_materials()["green leaf"]
        >>> round(float(leaf.total_reflectance[leaf.wavelength_nm == 540][0]), 2)
        0.14
    """
    return dict(_library())


@checked
def natural_material(name: str) -> Material:
    """A natural material as a material of scenes, for worlds that are lit.

    It has the spectra from 300 to 700 nm, the surface, and colours in which other programs show
    it. What transmits is seen from both sides.

    Args:
        name: one of `natural_materials`.

    Example:
        >>> omma.scene.natural_material("grass blade").name
        'grass blade'

    Raises:
        omma.Error: a name that is not among them.
    """
    one = _library()[one_of(name, _library(), "name")]
    through = one.transmittance
    return Material(
        name,
        base_color=one.base_color,
        double_sided=through is not None,
        ior=one.ior,
        specular=one.specular,
        roughness=one.roughness,
        diffuse_transmission=one.diffuse_transmission,
        diffuse_transmission_color=one.diffuse_transmission_color,
        reflectance=Spectrum(one.wavelength_nm, one.reflectance),
        transmittance=None if through is None else Spectrum(one.wavelength_nm, through),
        spectral_luminance=luminance(one.base_color),
    )


@cache
def _library() -> dict[str, NaturalMaterial]:
    sources = {row["key"]: row for row in packaged_rows("omma.scene", "material_sources.csv")}
    facts = [
        MaterialFact(
            row["material"],
            row["quantity"],
            float(row["wavelength_nm"]) if row["wavelength_nm"] else None,
            float(row["value"]),
            row["standing"],
            sources[row["source"]]["citation"],
            sources[row["source"]]["read"],
            row["note"],
        )
        for table in ("materials.csv", "leaf_spectra.csv")
        for row in packaged_rows("omma.scene", table)
    ]
    names = dict.fromkeys(fact.material for fact in facts)
    return {name: _made(name, tuple(f for f in facts if f.material == name)) for name in names}


def _made(name: str, facts: tuple[MaterialFact, ...]) -> NaturalMaterial:
    surface = {fact.quantity: fact.value for fact in facts if fact.wavelength_nm is None}
    transmits = any(fact.quantity == "transmittance" for fact in facts)
    return NaturalMaterial(
        name,
        _NM,
        _curve(facts, "reflectance"),
        _curve(facts, "transmittance") if transmits else None,
        surface["ior"],
        surface["specular"],
        surface["roughness"],
        facts,
    )


def _curve(facts: tuple[MaterialFact, ...], quantity: str) -> Floats:
    """A smooth curve through the numbers that does not overshoot them: (W,)."""
    from scipy.interpolate import PchipInterpolator

    knots = sorted((f.wavelength_nm, f.value) for f in facts if f.quantity == quantity)
    values: Floats = PchipInterpolator(*zip(*knots), extrapolate=False)(_NM)
    values.flags.writeable = False
    return values
