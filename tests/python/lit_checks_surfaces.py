"""Checks of surfaces: what they reflect, transmit and polarise."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from lit_checks import (
    BAND,
    DARK,
    ROUNDING,
    Check,
    flat_spectrum,
    look,
    look_each,
    look_many,
    matter,
    room,
    shining,
    slanted,
    square,
)

import omma
from omma.light import Bands, Disc, Light, Spectrum, uniform_sky
from omma.scene import Image, Material, TextureUse

WHITE_SKY = uniform_sky(1.0, bands=BAND, unit="watts")
UPPER_SKY = uniform_sky(1.0, below=0, bands=BAND, unit="watts")

# The table of what gloss reflects in all directions together, by which the base is dimmed, is exact
# to a thousandth of 1, mostly far better (tests/cpp/physics_specular_albedo.cpp).
ALBEDO_TABLE = 1e-3
# Mirrors are lobes 0.03 deg wide, whose tails see other angles.
MIRROR = 5e-4


def furnace(backend: str) -> Iterator[Check]:
    """A closed room that shines and reflects."""
    for reflectance in (0.2, 0.5):
        scene = omma.Scene(meshes=room(2), materials=[shining(1.0, reflectance)])
        world = omma.World(scene, light=DARK, backend=backend, lighting="path")
        eye = (0.1, 0.2, 0.3), (0.3, -1, 0.2)
        seen, error = look(world, *eye, samples=2048)
        yield Check(
            f"closed furnace, ρ {reflectance}",
            "e/(1 − ρ)",
            1 / (1 - reflectance),
            seen[0],
            error[0],
        )
        direct = world.with_light(DARK, depth=1)
        seen, error = look(direct, *eye, samples=1024)
        yield Check(
            f"the same, direct light alone, ρ {reflectance}",
            "e (1 + ρ)",
            1 + reflectance,
            seen[0],
            error[0],
        )
        polarised = world.with_light(DARK, polarized=True)
        seen, error = look(polarised, *eye, samples=2048)
        yield Check(
            f"the same with polarisation, ρ {reflectance}",
            "e/(1 − ρ)",
            1 / (1 - reflectance),
            seen[0, 0],
            error[0, 0],
        )


def leaf(backend: str) -> Iterator[Check]:
    """A sheet that absorbs nothing is not seen in a uniform surround."""
    for name, gloss in (("matt", 0.0), ("glossy", 1.0)):
        sheet = matter(0.6, transmittance=flat_spectrum(0.4), specular=gloss, roughness=0.4)
        scene = omma.Scene(meshes=[square(2, (0, 0, 0), (0, 1, 0))], materials=[sheet])
        world = omma.World(scene, light=WHITE_SKY, backend=backend, lighting="path")
        tolerance = ALBEDO_TABLE if gloss else ROUNDING
        for angle in (0, 60, 80):
            seen, error = look(world, *slanted(angle), samples=2048)
            yield Check(
                f"{name} leaf, ρ + τ = 1, seen {angle}° off its normal",
                "L",
                1.0,
                seen[0],
                error[0],
                tolerance,
            )


def facet(backend: str) -> Iterator[Check]:
    """A tilted facet under a uniform sky above a black ground."""
    for tilt in (0, 30, 60, 90, 120):
        angle = np.radians(tilt)
        normal = np.array([np.sin(angle), np.cos(angle), 0.0])
        scene = omma.Scene(meshes=[square(2, (0, 0, 0), normal)], materials=[matter(1.0)])
        world = omma.World(scene, light=UPPER_SKY, backend=backend, lighting="path")
        seen, error = look(world, normal, -normal, samples=2048)
        yield Check(
            f"facet tilted by {tilt}°, E of a uniform sky",
            "π L (1 + cos β)/2",
            np.pi * (1 + np.cos(angle)) / 2,
            np.pi * seen[0],
            np.pi * error[0],
        )


def angles(backend: str) -> Iterator[Check]:
    """Smooth boundaries in a uniform surround: Fresnel's reflectances, as I and Q."""
    for name, ior in (("water", 1.33), ("glass", 1.5)):
        scene = omma.Scene(
            meshes=[square(2, (0, 0, 0), (0, 1, 0))],
            materials=[matter(0.0, specular=1.0, ior=ior, roughness=0.0)],
        )
        world = omma.World(scene, light=WHITE_SKY, polarized=True, backend=backend, lighting="path")
        brewster = np.degrees(np.arctan(ior))
        for angle in (20.0, brewster, 75.0):
            across, along = fresnel(angle, ior)
            seen, error = look(world, *slanted(angle))
            where = f"{angle:.2f}° (Brewster)" if angle == brewster else f"{angle:.0f}°"
            yield Check(
                f"{name}, n {ior}, {where}: reflectance",
                "(R_s + R_p)/2",
                (across + along) / 2,
                seen[0, 0],
                error[0, 0],
                MIRROR,
                1.0,
            )
            yield Check(
                f"{name}, n {ior}, {where}: Q, horizontal",
                "−(R_s − R_p)/2",
                -(across - along) / 2,
                seen[1, 0],
                error[1, 0],
                MIRROR,
                1.0,
            )


def fresnel(angle_deg: float, ior: float) -> tuple[float, float]:
    """R_s and R_p of a boundary, in doubles."""
    cosine = np.cos(np.radians(angle_deg))
    inside = np.sqrt(1 - (1 - cosine**2) / ior**2)
    across = ((cosine - ior * inside) / (cosine + ior * inside)) ** 2
    along = ((ior * cosine - inside) / (ior * cosine + inside)) ** 2
    return float(across), float(along)


def leaf_polarisation(backend: str) -> Iterator[Check]:
    """The degree of polarisation of a smooth leaf at Brewster's angle, and of white surfaces."""
    half = fresnel(np.degrees(np.arctan(1.5)), 1.5)[0] / 2
    for rho in (0.02, 0.06, 0.12):
        scene = omma.Scene(
            meshes=[square(2, (0, 0, 0), (0, 1, 0))],
            materials=[matter(rho, specular=1.0, ior=1.5, roughness=0.0)],
        )
        world = omma.World(scene, light=WHITE_SKY, polarized=True, backend=backend, lighting="path")
        each = look_each(world, *slanted(np.degrees(np.arctan(1.5))))[:, :2, 0]
        degree = -each[:, 1] / each[:, 0]
        yield Check(
            f"leaf of ρ {rho} at Brewster's angle: degree of polarisation",
            "(1 − ρ) (R_s/2)/(R_s/2 + ρ (1 − R_s/2))",
            (1 - rho) * half / (half + rho * (1 - half)),
            degree.mean(),
            degree.std(ddof=1) / np.sqrt(len(degree)),
            # Where the mirror ends the degree has its maximum; the table dims the base.
            ALBEDO_TABLE,
            1.0,
        )
    for roughness in (0.0, 0.5):
        scene = omma.Scene(
            meshes=[square(2, (0, 0, 0), (0, 1, 0))],
            materials=[matter(1.0, specular=1.0, ior=1.5, roughness=roughness)],
        )
        world = omma.World(scene, light=WHITE_SKY, polarized=True, backend=backend, lighting="path")
        each = look_each(world, *slanted(60.0))[:, :2, 0]
        degree = each[:, 1] / each[:, 0]
        yield Check(
            f"white gloss of roughness {roughness} at 60°, uniform light: Q over I",
            "0",
            0.0,
            degree.mean(),
            degree.std(ddof=1) / np.sqrt(len(degree)),
            ALBEDO_TABLE,
            1.0,
        )


def glass(backend: str) -> Iterator[Check]:
    """A thin pane, and what shines behind it."""
    pane = matter(1.0, transmission=1.0, specular=1.0, ior=1.5, roughness=0.0)
    scene = omma.Scene(
        meshes=[square(2, (0, 0, 0), (0, 1, 0)), square(9, (0, -1, 0), (0, 1, 0), 1)],
        materials=[pane, shining(1.0)],
    )
    world = omma.World(scene, light=DARK, backend=backend, lighting="path")
    for angle in (0.0, 50.0):
        lost = sum(fresnel(angle, 1.5)) / 2
        seen, error = look(world, *slanted(angle))
        yield Check(
            f"pane of glass before a shining wall, {angle:.0f}°",
            "L (1 − R)",
            1 - lost,
            seen[0],
            error[0],
            MIRROR,
        )
    lit = omma.World(
        omma.Scene(meshes=scene.meshes[:1], materials=[pane]),
        light=WHITE_SKY,
        backend=backend,
        lighting="path",
    )
    seen, error = look(lit, *slanted(50))
    yield Check("pane of glass in a uniform surround", "L", 1.0, seen[0], error[0], MIRROR)


def blend_and_mask(backend: str) -> Iterator[Check]:
    """Shade of sheets that let light by."""
    sun = Light(BAND, "watts", discs=(Disc((0, 1, 0), 0.01, [1.0]),))
    full = sun.discs[0].irradiance()[0] / np.pi
    half = Image(np.concatenate([np.zeros((4, 2, 4)), np.ones((4, 2, 4))], axis=1))
    veil = matter(0.0, base_color=(1, 1, 1, 0.5), alpha_mode="blend")
    cut = matter(0.0, base_color_texture=TextureUse(0), alpha_mode="mask")
    scene = omma.Scene(
        meshes=[
            square(20, (0, 0, 0), (0, 1, 0), 0),
            square(2, (0, 2, 0), (0, 1, 0), 1),
            square(2, (5, 2, 0), (0, 1, 0), 2),
        ],
        materials=[matter(1.0), veil, cut],
        images=[half],
        textures=[omma.scene.Texture(0, filter="nearest")],
    )
    world = omma.World(scene, light=sun, backend=backend, lighting="path")
    for effect, form, x, share in (
        ("ground in the sun", "ρ E/π", -3.0, 1.0),
        ("under a sheet of alpha 0.5 (BLEND)", "ρ E/(2 π)", 0.1, 0.5),
        ("through what MASK cuts out", "ρ E/π", 4.5, 1.0),
        ("below what it leaves", "0", 5.5, 0.0),
    ):
        seen, error = look(world, (x, 1, 0.1), (0, -1, 0))
        yield Check(effect, form, share * full, seen[0], error[0], ROUNDING, full)


def normal_map(backend: str) -> Iterator[Check]:
    """A normal map that turns the normal by about 30 degrees, in the sun."""
    code = np.round(
        np.array([0.5 + 0.5 * np.sin(np.pi / 6), 0.5, 0.5 + 0.5 * np.cos(np.pi / 6)]) * 255
    )
    normal = code / 255 * 2 - 1
    cosine = normal[2] / np.linalg.norm(normal)
    picture = Image(np.tile((code / 255).astype(np.float32), (2, 2, 1)))
    sun = Light(BAND, "watts", discs=(Disc((0, 1, 0), 1e-3, [1.0]),))
    scene = omma.Scene(
        meshes=[square(2, (0, 0, 0), (0, 1, 0))],
        materials=[matter(0.5, normal_texture=TextureUse(0))],
        images=[picture],
    )
    world = omma.World(scene, light=sun, backend=backend, lighting="path")
    seen, error = look(world, (0.1, 1, 0.1), (0, -1, 0))
    yield Check(
        "normal map, normal turned by 30° from the sun",
        "ρ E cos 30°/π",
        0.5 * sun.discs[0].irradiance()[0] * cosine / np.pi,
        seen[0],
        error[0],
        # Half a level of an image of 16 bits.
        5e-5,
    )


def products(backend: str) -> Iterator[Check]:
    """Light that two surfaces reflect: bands are products of both reflectances."""
    bands = Bands.equal(4, 400, 700)
    nm = bands.centers_nm
    one, other = np.array([0.1, 0.3, 0.8, 0.5]), np.array([0.9, 0.2, 0.4, 0.6])
    # Even within bands, which end 37.5 nm from their middle: the steps between are 0.0002 nm wide.
    steps = np.column_stack([nm - 37.4999, nm + 37.4999]).ravel()
    walls = [
        Material(specular=0.0, double_sided=True, reflectance=Spectrum(steps, np.repeat(values, 2)))
        for values in (one, other)
    ]
    sun = Light(bands, "watts", discs=(Disc((1, 1, 0), 0.01, [1.0] * 4),))
    scene = omma.Scene(
        meshes=[square(2, (0, 0, 0), (0, 1, 0), 0), square(2, (-1, 1, 0), (1, 0, 0), 1)],
        materials=walls,
    )
    once = omma.World(scene, light=sun, depth=1, backend=backend)
    twice = once.with_light(sun, depth=2)
    at = (0.2, 1, 0.1), (0, -1, 0)
    first, _ = look(once, *at)
    both, _ = look(twice, *at)
    second = both - first
    ratio = one * other / (one[0] * other[0])
    for band in range(1, 4):
        yield Check(
            f"two reflections, band {band + 1} over band 1",
            "ρ₁ρ₂ ratio",
            ratio[band],
            second[band] / second[0],
            # A difference of two numbers in single precision.
            tolerance=10 * ROUNDING,
        )


def energy(backend: str) -> Iterator[Check]:
    """Random materials, white where they can be, in a uniform surround."""
    random = np.random.default_rng(14)
    materials, meshes, eyes = [], [], []
    for k in range(96):
        through = random.random()
        kind = k % 4
        materials.append(
            matter(
                1.0 if kind != 1 else 1 - through,
                transmittance=flat_spectrum(through) if kind == 1 else None,
                specular=random.random(),
                roughness=random.random(),
                ior=1 + 1.5 * random.random(),
                metallic=random.random() if kind == 2 else 0.0,
                transmission=random.random() if kind == 3 else 0.0,
                clearcoat=random.random() if kind != 1 else 0.0,
                clearcoat_roughness=random.random(),
            )
        )
        place = np.array([3.0 * (k % 10), 0, 3.0 * (k // 10)])
        meshes.append(square(1, place, (0, 1, 0), k))
        angle = np.radians(random.uniform(0, 85))
        back = np.array([0.0, np.cos(angle), np.sin(angle)]) * 0.3
        eyes.append((place + back, -back))
    scene = omma.Scene(meshes=meshes, materials=materials)
    world = omma.World(scene, light=WHITE_SKY, backend=backend, lighting="path")
    seen, error = look_many(world, *np.array(eyes).transpose(1, 0, 2), samples=256)
    over = seen[:, 0] - 3 * error[:, 0]
    worst = int(np.argmax(over))
    yield Check(
        "the brightest of 96 random materials in a uniform surround",
        "at most L",
        min(1.0, float(seen[worst, 0])),
        seen[worst, 0],
        error[worst, 0],
        ALBEDO_TABLE * 1.7,
    )


CASES = {
    "furnace": furnace,
    "leaf": leaf,
    "facet": facet,
    "fresnel": angles,
    "leaf polarisation": leaf_polarisation,
    "glass": glass,
    "blend and mask": blend_and_mask,
    "normal map": normal_map,
    "two reflections": products,
    "energy": energy,
}
