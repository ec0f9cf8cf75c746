"""Checks of volumes that rays bend into: water below a level surface, and glass."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from lit_checks import (
    BAND,
    DARK,
    Check,
    flat_spectrum,
    look,
    look_each,
    matter,
    shining,
    slanted,
    square,
)
from lit_checks_surfaces import ALBEDO_TABLE, WHITE_SKY, fresnel

import omma
from omma.light import Disc, Light

N, DEPTH_M, PER_M = 1.34, 1.5, 0.4
WATER = matter(
    1.0, specular=1.0, ior=N, roughness=0.0, transmission=1.0, thickness_m=1.0,
    absorption_per_m=flat_spectrum(PER_M),
)  # fmt: skip


def pool(bottom: omma.scene.Material, light: Light, backend: str, **how: object) -> omma.World:
    scene = omma.Scene(
        meshes=[
            square(60, (0, 0, 0), (0, 1, 0)),
            square(60, (0, -DEPTH_M, 0), (0, 1, 0), material=1),
        ],
        materials=[WATER, bottom],
    )
    return omma.World(scene, light=light, backend=backend, lighting="path", **how)  # type: ignore[arg-type]


def way_m(angle_deg: float) -> float:
    """Through the water, of what is refracted."""
    return float(DEPTH_M / np.cos(np.arcsin(np.sin(np.radians(angle_deg)) / N)))


def let_through(angle_deg: float) -> float:
    return 1 - sum(fresnel(angle_deg, N)) / 2


def from_above(backend: str) -> Iterator[Check]:
    """What shines below water: how bright, and how polarised."""
    world = pool(shining(1.0), DARK, backend)
    for angle in (0.0, 50.0, 75.0):
        seen, error = look(world, *slanted(angle), samples=4096)
        yield Check(
            f"what shines 1.5 m below water, {angle:.0f}°",
            "L (1 − R)/n² exp(−a d)",
            let_through(angle) / N**2 * np.exp(-PER_M * way_m(angle)),
            seen[0],
            error[0],
            ALBEDO_TABLE,
        )
    polarised = pool(shining(1.0), DARK, backend, polarized=True)
    for angle in (30.0, 60.0):
        i, q, _ = look_each(polarised, *slanted(angle))[:, :, 0].mean(axis=0)
        across, along = (1 - one for one in fresnel(angle, N))
        yield Check(
            f"its degree of polarisation, {angle:.0f}°",
            "(T_p − T_s)/(T_p + T_s)",
            (along - across) / (along + across),
            q / i,
        )


def from_below(backend: str) -> Iterator[Check]:
    """The sky through a surface seen from within, and no sky beyond the critical angle."""
    world = pool(matter(0.0), WHITE_SKY, backend)
    left = np.exp(-PER_M * 0.5)
    for angle in (0.0, 30.0, 45.0, 60.0):
        up = np.array([0.0, np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        seen, error = look(world, -0.5 * up, up, samples=4096)
        outside = N * np.sin(np.radians(angle))
        inside = outside < 1
        yield Check(
            f"an even sky from 0.5 m below water, {angle:.0f}°",
            "n² (1 − R) L exp(−a d)" if inside else "0",
            N**2 * let_through(np.degrees(np.arcsin(outside))) * left if inside else 0.0,
            seen[0],
            error[0],
            scale=1.0,
        )


def bottom(backend: str) -> Iterator[Check]:
    """The sun on the bottom, seen from within; one scattering."""
    elevation = 40.0
    sun = np.array([0.0, np.sin(np.radians(elevation)), np.cos(np.radians(elevation))])
    radius, radiance = 0.004654, 1e4
    light = Light(BAND, "watts", discs=(Disc(sun, radius, [radiance]),))
    world = pool(matter(0.5), light, backend, depth=1)
    # From so near that the water between takes nothing of note, as what an eye begins in is not
    # known.
    seen, error = look(world, (0.3, -DEPTH_M + 0.01, 0.2), (0.1, -1.0, 0.0))
    yield Check(
        "matter on the bottom, 1.5 m down, in the sun, 40° high",
        "ρ/π E (1 − R) exp(−a d)",
        0.5 * radiance * np.sin(radius) ** 2 * sun[1] * let_through(90 - elevation)
        * np.exp(-PER_M * way_m(90 - elevation)),
        seen[0],
        error[0],
        ALBEDO_TABLE,
    )  # fmt: skip


CASES = {"water from above": from_above, "water from below": from_below, "bottom": bottom}
