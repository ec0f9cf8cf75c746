"""Receptors of the species: which types there are, and which ommatidium has which."""

from __future__ import annotations

from omma._core import Eye, ReceptorType
from omma.eye.superposition import fly_receptors
from omma.receptors.mosaic import OmmatidiumType, Region, assign_receptors
from omma.species.facts import number

_SEED = 3  # of the random arrangement of types over an eye: any number, always the same


def receptor(
    animal: str,
    name: str,
    peak: str,
    *,
    microvillus_angle_rad: float = 0.0,
    polarisation_sensitivity: float = 1.0,
    absorption_per_m: float = 0.0,
    length_m: float = 0.0,
) -> ReceptorType:
    """A receptor whose visual pigment peaks at the table's ``peak``."""
    return ReceptorType(
        name,
        peak_wavelength_nm=number(animal, peak),
        microvillus_angle_rad=microvillus_angle_rad,
        polarisation_sensitivity=polarisation_sensitivity,
        absorption_per_m=absorption_per_m,
        length_m=length_m,
    )


def mixed(eye: Eye, kinds: list[OmmatidiumType], where: Region | None = None) -> Eye:
    """The eye with these kinds of ommatidia at random, always the same ones."""
    return assign_receptors(eye, kinds, where=where, seed=_SEED)


def bee_kinds(animal: str, fractions_of: str, **properties: float) -> list[OmmatidiumType]:
    """Types I (1 ultraviolet, 1 blue, 6 green), II (2 ultraviolet, 6 green) and III (2 blue, 6
    green): Wakakuwa et al. 2005."""
    ultraviolet, blue, green = bee_receptors(animal, **properties)
    greens = (green,) * 6
    first, second = (number(fractions_of, f"type_{k}_fraction") for k in (1, 2))
    return [
        OmmatidiumType("I", (ultraviolet, blue, *greens), first),
        OmmatidiumType("II", (ultraviolet, ultraviolet, *greens), second),
        OmmatidiumType("III", (blue, blue, *greens), 1 - first - second),
    ]


def bee_receptors(animal: str, **properties: float) -> tuple[ReceptorType, ...]:
    """Ultraviolet, blue and green."""
    return (
        receptor(animal, "ultraviolet", "uv_peak", **properties),
        receptor(animal, "blue", "blue_peak", **properties),
        receptor(animal, "green", "green_peak", **properties),
    )


def with_fly_receptors(
    eye: Eye, animal: str, peaks: tuple[str, str, str, str, str], **properties: float
) -> Eye:
    """The eye with a fly's receptors, of the table's peaks of R1-6, R7 and R8 pale, R7 and R8
    yellow; R1 to R6 look beside the axis as neural superposition wants."""
    names = ("R1-6", "R7p", "R8p", "R7y", "R8y")
    types = {
        name: receptor(animal, name, peak, **properties)
        for name, peak in zip(names, peaks, strict=True)
    }
    pale = number(animal, "pale_fraction")
    return fly_receptors(eye, pale_fraction=pale, seed=_SEED, types=types)
